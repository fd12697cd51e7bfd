//! Which texts are fit to be shown again.

/// Whether `c` can change how the text around it is shown: control characters, line and
/// paragraph separators, and the marks that switch the direction of writing.
pub fn is_unsafe(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}
