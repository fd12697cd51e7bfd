//! Numbers, and texts of anyone, in a picture.

use crate::wire::text::is_unsafe;

/// Most characters of a line of text that fit.
const LINE: usize = 120;
/// Widest title that fits, in small letters of its size.
const TITLE: f64 = 64.0;

/// A title that fits into a picture, as XML has it; one that is cut says so. The width of letters is a guess,
/// since the reader's fonts are not known.
pub(super) fn title(text: &str) -> String {
    let mut width = 0.0;
    let mut fits = 0;
    for (count, c) in text.chars().enumerate() {
        width += match c {
            'm' | 'w' | '@' | '%' => 1.5,
            '\u{1100}'.. => 2.0,
            c if c.is_uppercase() => 1.3,
            _ => 1.0,
        };
        if width > TITLE {
            let cut = text.chars().take(fits).chain(['…']);
            return escape(&cut.collect::<String>());
        }
        if width + 1.0 <= TITLE {
            fits = count + 1;
        }
    }
    escape(text)
}

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

/// Four digits that count.
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
    fn figures_keep_four_digits_and_the_zeros_that_count() {
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
    fn a_long_title_is_cut_and_says_so() {
        for (text, most) in [("é", 64), ("W", 49), ("爪", 32)] {
            let cut = title(&text.repeat(200));
            assert!(cut.ends_with('…') && (most - 2..=most).contains(&cut.chars().count()));
        }
        let whole = "e".repeat(64);
        assert_eq!([title("duck.obj"), title(&whole)], ["duck.obj", &whole]);
    }

    #[test]
    fn lines_are_cut_between_words() {
        let text = "word ".repeat(100);
        let lines = wrap(&text);
        assert!(lines.len() > 1 && lines.iter().all(|line| line.len() <= LINE));
        assert_eq!(lines.join(" "), text.trim());
    }
}
