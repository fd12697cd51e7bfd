//! Nobody else has the folder: there is nobody to tell.

use async_trait::async_trait;

use super::Sqlite;
use crate::store::{Audience, Listener, Notice, Notices, StoreError};

#[async_trait]
impl Notices for Sqlite {
    async fn tell(&self, _notices: &[Notice]) -> Result<(), StoreError> {
        Ok(())
    }

    async fn listen(&self, _audience: Audience) -> Result<Option<Box<dyn Listener>>, StoreError> {
        Ok(None)
    }
}
