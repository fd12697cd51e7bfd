//! A statement for either engine.
//!
//! Its parameters are written `$1`, `$2`, ..., which both engines read. SQLite has no lists among its values: it
//! gets them as JSON.

use std::borrow::Cow;

use sqlx::postgres::PgArguments;
use sqlx::query::Query;
use sqlx::sqlite::SqliteArguments;
use sqlx::{AssertSqlSafe, Postgres, Sqlite};

use super::Engine;
use crate::store::{StoreError, damaged};

/// Text and parameters of a statement.
#[derive(Debug, Clone)]
pub struct Statement {
    text: Cow<'static, str>,
    values: Vec<Value>,
}

/// The value of a parameter.
#[derive(Debug, Clone)]
pub enum Value {
    Text(String),
    Integer(i64),
    List(Vec<String>),
}

impl Statement {
    /// A statement whose parameters are still to be bound.
    pub fn new(text: &'static str) -> Self {
        Self {
            text: Cow::Borrowed(text),
            values: Vec::new(),
        }
    }

    /// Binds the next parameter.
    pub fn bind(mut self, value: impl Into<Value>) -> Self {
        self.values.push(value.into());
        self
    }

    /// Appends `text` and a parameter of this value.
    pub fn push(mut self, text: &'static str, value: impl Into<Value>) -> Self {
        self.append(text, "", "", value.into());
        self
    }

    /// Appends `text` and the condition that what it ends with is one of these texts.
    pub fn push_in_list<E: Engine>(mut self, text: &'static str, list: Vec<String>) -> Self {
        let (before, after) = E::IN_LIST;
        self.append(text, before, after, Value::List(list));
        self
    }

    /// Appends `text`.
    pub fn push_text(mut self, text: &'static str) -> Self {
        self.text.to_mut().push_str(text);
        self
    }

    fn append(&mut self, text: &str, before: &str, after: &str, value: Value) {
        self.values.push(value);
        let number = self.values.len().to_string();
        self.text
            .to_mut()
            .extend([text, before, "$", &number, after]);
    }

    /// Converts the value for SQLite.
    pub fn for_sqlite<'q>(self) -> Result<Query<'q, Sqlite, SqliteArguments>, StoreError> {
        let mut query = sqlx::query(AssertSqlSafe(self.text));
        for value in self.values {
            query = match value {
                Value::Text(text) => query.bind(text),
                Value::Integer(number) => query.bind(number),
                Value::List(list) => query.bind(serde_json::to_string(&list).map_err(damaged)?),
            };
        }
        Ok(query)
    }

    /// As PostgreSQL takes it, whose texts have no zero bytes. No id has one.
    pub fn for_postgres<'q>(self) -> Query<'q, Postgres, PgArguments> {
        let mut query = sqlx::query(AssertSqlSafe(self.text));
        for value in self.values {
            query = match value {
                Value::Text(text) => query.bind(text.replace('\0', " ")),
                Value::Integer(number) => query.bind(number),
                Value::List(list) => query.bind(list),
            };
        }
        query
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Self::Integer(number)
    }
}

impl From<u32> for Value {
    fn from(number: u32) -> Self {
        Self::Integer(number.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::sqlite::Sqlite;

    #[test]
    fn what_is_appended_counts_its_parameters() {
        let statement = Statement::new("SELECT x FROM y WHERE a = $1")
            .bind("a")
            .push(" AND b = ", 2_u32)
            .push_in_list::<Sqlite>(" AND c", vec!["d".to_owned()])
            .push_text(" ORDER BY x");
        assert_eq!(
            statement.text,
            "SELECT x FROM y WHERE a = $1 AND b = $2 \
             AND c IN (SELECT value FROM json_each($3)) ORDER BY x"
        );
    }
}
