//! Pages of lists, and the cursors that say where one ended. Clients carry them.

use sha2::{Digest, Sha256};

use crate::store::MAX_PAGE;

/// Hexadecimal digits of the checksum, by which a cursor differs from a typing error or a guess. It protects no secret.
const CHECK_DIGITS: usize = 8;

/// Returns the cursor of `list` behind the item with this key.
fn encode(list: &str, key: &str) -> String {
    format!("{}{key}", checksum(list, key))
}

/// Returns the key in a cursor; `None` when it is not one that [`encode`] made for `list`.
pub fn decode<'a>(list: &str, cursor: &'a str) -> Option<&'a str> {
    let (check, key) = cursor.split_at_checked(CHECK_DIGITS)?;
    (check == checksum(list, key)).then_some(key)
}

/// How many items a page may have.
#[derive(Debug, Clone, Copy)]
pub struct Limit(u32);

/// The number of items that a client asks for, brought into the range from 1 to [`MAX_PAGE`].
pub fn limit(wanted: u32) -> Limit {
    Limit(wanted.clamp(1, MAX_PAGE))
}

impl Limit {
    /// How many rows to ask the database for: one more shows whether another page follows.
    pub fn asked_for(self) -> u32 {
        self.0 + 1
    }

    /// Returns the page of `list` that begins with the items asked for, and its cursor if others follow.
    pub fn page<T>(
        self,
        list: &str,
        mut items: Vec<T>,
        key: impl Fn(&T) -> String,
    ) -> (Vec<T>, Option<String>) {
        let limit = self.0 as usize;
        let more = items.len() > limit;
        items.truncate(limit);
        let last = items.last().filter(|_| more);
        let next = last.map(|last| encode(list, &key(last)));
        (items, next)
    }
}

fn checksum(list: &str, key: &str) -> String {
    let hash = Sha256::digest(format!("{list} {key}"));
    let check = u32::from_be_bytes([hash[0], hash[1], hash[2], hash[3]]);
    format!("{check:0CHECK_DIGITS$x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_encoded_is_decoded() {
        let cursor = encode("meshes", "42");
        assert_eq!(decode("meshes", &cursor), Some("42"));
        assert_eq!(decode("jobs", &cursor), None);
        for forged in ["", "42", "0000000042", "é3456789", &cursor[1..]] {
            assert_eq!(decode("meshes", forged), None, "{forged:?}");
        }
    }
}
