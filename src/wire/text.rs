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

/// Most characters of a client's own name for something that are echoed.
const MAX_ECHO: usize = 100;

/// A name as one segment of a JSON pointer, with its slash: cut to what is worth echoing, and
/// without what is unfit to be shown.
pub fn pointer(name: &str) -> String {
    let shown: String = name
        .chars()
        .take(MAX_ECHO)
        .map(|c| if is_unsafe(c) { '\u{fffd}' } else { c })
        .collect();
    format!("/{}", shown.replace('~', "~0").replace('/', "~1"))
}
