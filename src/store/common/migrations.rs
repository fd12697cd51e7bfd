//! The migrations that a database has had.
//!
//! A database made before the migrations were put together into one has a list of several, which make the same
//! tables. An engine knows that list by heart: where a database has all of it and nothing else, the engine puts its
//! one migration in the place of the list. Whatever else a database has is left to the migrator, which refuses what
//! it does not know.

/// Selects the rows of the table of migrations, as [`Applied`].
pub const SELECT_APPLIED: &str =
    "SELECT version, checksum, success FROM _sqlx_migrations ORDER BY version";

/// Empties the table of migrations.
pub const DELETE_APPLIED: &str = "DELETE FROM _sqlx_migrations";

/// Enters a migration in the table of migrations, by version, description and checksum.
pub const INSERT_APPLIED: &str = "INSERT INTO _sqlx_migrations \
     (version, description, success, checksum, execution_time) VALUES ($1, $2, TRUE, $3, 0)";

/// A row of the table of migrations: version, checksum, and whether it succeeded.
pub type Applied = (i64, Vec<u8>, bool);

/// A migration of the list before: version, and the first eight bytes of its checksum.
pub type Before = (i64, u64);

/// The state of a database according to its table of migrations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum History {
    /// The tables have had the migrations up to this version; 0 when there are none.
    Version(i64),
    /// They have had all migrations of the list before.
    AllBefore,
    /// They have had some migrations of the list before. The largest version is this.
    SomeBefore(i64),
}

impl History {
    /// Reads the rows of the table, in the order of their versions.
    pub fn of(applied: &[Applied], before: &[Before]) -> Self {
        let is_before = |((version, checksum, success), (known, digest)): &(&Applied, &Before)| {
            let begin = checksum.first_chunk().copied().map(u64::from_be_bytes);
            *success && version == known && begin == Some(*digest)
        };
        let same = applied.iter().zip(before).take_while(is_before).count();
        let succeeded = applied.iter().filter(|(_, _, success)| *success);
        let version = succeeded.map(|(version, ..)| *version).max().unwrap_or(0);
        match same {
            0 => Self::Version(version),
            same if same == before.len() && same == applied.len() => Self::AllBefore,
            _ => Self::SomeBefore(version),
        }
    }

    /// The version of the tables, where those of the list before are those of version `current`.
    pub fn version(self, current: i64) -> i64 {
        match self {
            Self::Version(version) | Self::SomeBefore(version) => version,
            Self::AllBefore => current,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_whole_list_before_is_taken_for_it() {
        let before = [(1, 0x0102_0304_0506_0708), (2, 0x1112_1314_1516_1718)];
        let first = (1, vec![1, 2, 3, 4, 5, 6, 7, 8, 9], true);
        let second = (2, vec![17, 18, 19, 20, 21, 22, 23, 24, 25], true);
        let of = |applied: &[Applied]| History::of(applied, &before);
        assert_eq!(of(&[]), History::Version(0));
        assert_eq!(of(&[first.clone(), second.clone()]), History::AllBefore);
        assert_eq!(of(std::slice::from_ref(&first)), History::SomeBefore(1));
        let failed = (2, second.1.clone(), false);
        assert_eq!(of(&[first.clone(), failed]), History::SomeBefore(1));
        let more = (3, vec![0; 9], true);
        assert_eq!(of(&[first, second, more]), History::SomeBefore(3));
        assert_eq!(of(&[(1, vec![0; 9], true)]), History::Version(1));
    }
}
