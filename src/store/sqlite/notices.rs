//! No other process has the folder: notices go to nobody.

use async_trait::async_trait;

use super::Sqlite;
use crate::store::{Audience, Listener, Notice, Notices, StoreError};

#[async_trait]
impl Notices for Sqlite {
    async fn notify(&self, _notices: &[Notice]) -> Result<(), StoreError> {
        Ok(())
    }

    async fn listen(&self, _audience: Audience) -> Result<Option<Box<dyn Listener>>, StoreError> {
        Ok(None)
    }
}
