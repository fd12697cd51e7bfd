//! Texts of anyone in a picture.

use crate::wire::text::is_unsafe;

/// Most characters of a title, and of a line of text, that fit.
const LINE: usize = 120;

/// Lines of at most [`LINE`] characters, cut between words.
pub(super) fn wrap(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < LINE => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Text as XML has it, cut to what fits, without what XML forbids or what could disguise it.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars().take(LINE) {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            c if is_unsafe(c) || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_breaks_out_of_xml() {
        assert_eq!(
            escape("<b>\u{0} \"a\" & \u{202e}\u{ffff}é"),
            "&lt;b&gt;\u{fffd} &quot;a&quot; &amp; \u{fffd}\u{fffd}é"
        );
    }

    #[test]
    fn lines_are_cut_between_words() {
        let text = "word ".repeat(100);
        let lines = wrap(&text);
        assert!(lines.len() > 1 && lines.iter().all(|line| line.len() <= LINE));
        assert_eq!(lines.join(" "), text.trim());
    }
}
