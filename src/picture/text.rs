//! Numbers, and texts from clients, in a picture.

use super::raster;
use crate::wire::text::is_unsafe;

/// Most characters that fit into a line.
const LINE: usize = 120;
/// Width available to a title, in the unit of the drawing.
const ROOM: f64 = 900.0;
/// Size of its bold letters.
pub(super) const TITLE_SIZE: f64 = 20.0;

/// Returns a title that fits into a picture, escaped for XML; a shortened title ends with an ellipsis.
pub(super) fn title(text: &str) -> String {
    let fits = |text: &str| {
        // The font has no East Asian letters; those of other fonts are as wide as high.
        let square = text.chars().filter(|&c| c >= '\u{1100}').count() as f64;
        raster::width(&escape(text), TITLE_SIZE).max(square * TITLE_SIZE) <= ROOM
    };
    if text.chars().count() <= LINE && fits(text) {
        return escape(text);
    }
    let cut = |count: usize| -> String { text.chars().take(count).chain(['…']).collect() };
    let counts: Vec<usize> = (1..LINE).collect();
    escape(&cut(counts.partition_point(|&count| fits(&cut(count)))))
}

/// Breaks a text between words into lines of at most [`LINE`] characters.
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

/// Escapes a text for XML and shortens it to fit, without characters that XML forbids or that could disguise the text.
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

/// Formats a number with four significant digits.
pub(super) fn figure(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    match digits {
        1..=7 => {
            let text = format!("{value:.*}", digits as usize);
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        -4..=0 => format!("{value:.0}"),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_keep_four_significant_digits() {
        let cases = [
            (0.0, "0"),
            (1000.0, "1000"),
            (1230.0, "1230"),
            (9999.7, "10000"),
            (120.0, "120"),
            (0.5, "0.5"),
            (0.000_123_46, "0.0001235"),
            (0.000_067_95, "6.795e-5"),
            (-0.25, "-0.25"),
            (1.5e9, "1.500e9"),
        ];
        for (value, expected) in cases {
            assert_eq!(figure(value), expected);
        }
    }

    #[test]
    fn no_text_breaks_out_of_xml() {
        assert_eq!(
            escape("<b>\u{0} \"a\" & \u{202e}\u{ffff}é"),
            "&lt;b&gt;\u{fffd} &quot;a&quot; &amp; \u{fffd}\u{fffd}é"
        );
    }

    #[test]
    fn a_title_that_leaves_the_picture_is_cut_and_says_so() {
        for letter in ["W", "=", "i", "é", "爪", "&"] {
            let cut = title(&letter.repeat(200));
            assert!(cut.ends_with('…'), "{cut}");
            let width = raster::width(&cut, TITLE_SIZE);
            assert!(width <= ROOM, "{cut} is {width} wide");
            let more = format!("{}{}", escape(letter), cut);
            let is_full = raster::width(&more, TITLE_SIZE) > ROOM - TITLE_SIZE;
            assert!(is_full || letter == "爪" || letter == "i", "{cut} is short");
        }
        let whole = "A title of some words, which has as many letters as fit";
        assert_eq!([title(""), title(whole)], ["", whole]);
    }

    #[test]
    fn lines_are_cut_between_words() {
        let text = "word ".repeat(100);
        let lines = wrap(&text);
        assert!(lines.len() > 1 && lines.iter().all(|line| line.len() <= LINE));
        assert_eq!(lines.join(" "), text.trim());
    }
}
