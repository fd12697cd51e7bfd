//! Cursors of lists: where a page ended, as clients carry it.

use sha2::{Digest, Sha256};

/// Hexadecimal digits of the checksum. It tells a cursor from a slip or a guess; nothing secret
/// hangs on it.
const CHECK_DIGITS: usize = 8;

/// The cursor of `list` for the key of the last item of a page.
pub fn encode(list: &str, key: &str) -> String {
    format!("{}{key}", checksum(list, key))
}

/// The key in a cursor; `None` when `cursor` is not one that [`encode`] made for `list`.
pub fn decode<'a>(list: &str, cursor: &'a str) -> Option<&'a str> {
    let (check, key) = cursor.split_at_checked(CHECK_DIGITS)?;
    (check == checksum(list, key)).then_some(key)
}

/// A page of `list`, made of the items asked for, one more than `limit` where there are so many, and its cursor if others
/// follow.
pub fn page<T>(
    list: &str,
    mut items: Vec<T>,
    limit: usize,
    key: impl Fn(&T) -> String,
) -> (Vec<T>, Option<String>) {
    let more = items.len() > limit;
    items.truncate(limit);
    let last = items.last().filter(|_| more);
    let next = last.map(|last| encode(list, &key(last)));
    (items, next)
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
