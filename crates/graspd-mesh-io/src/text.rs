//! Lines, words and numbers of text files, which need not be valid UTF-8.
//!
//! Old exporters write names in whatever encoding they ran in, so text is handled as bytes. Only numbers are decoded.

/// Lines with their numbers from 1; ends are `\n`, `\r\n` or `\r`, and a byte-order mark is
/// skipped.
#[derive(Clone)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self::starting_at(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), 1)
    }

    /// Goes on inside a file; `rest` begins on line `number`.
    pub(super) fn starting_at(rest: &'a [u8], number: usize) -> Self {
        Self {
            rest,
            number: number - 1,
        }
    }

    /// The bytes after the lines taken so far.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = match rest {
            [b'\r', b'\n', rest @ ..] => rest,
            [_, rest @ ..] => rest,
            [] => rest,
        };
        self.number += 1;
        Some((self.number, line))
    }
}

/// The words of a line.
pub(super) fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// Words of a text in order, wherever the lines end.
pub(super) struct Words<'a> {
    lines: Lines<'a>,
    line: &'a [u8],
    number: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(lines: Lines<'a>) -> Self {
        Self {
            number: lines.number + 1,
            lines,
            line: b"",
        }
    }

    /// The line of the last word taken, from 1.
    pub(super) fn line(&self) -> usize {
        self.number
    }

    /// Takes the rest of the current line.
    pub(super) fn take_line(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.line)
    }

    /// How many bytes are left.
    pub(super) fn remaining(&self) -> usize {
        self.line.len() + self.lines.rest.len()
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            self.line = self.line.trim_ascii_start();
            if !self.line.is_empty() {
                let end = self.line.iter().position(u8::is_ascii_whitespace);
                let (word, rest) = self.line.split_at(end.unwrap_or(self.line.len()));
                self.line = rest;
                return Some(word);
            }
            (self.number, self.line) = self.lines.next()?;
        }
    }
}

/// The value of a decimal number. `nan` and `inf` count as numbers here, so that the message which refuses them later
/// can say what is wrong.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Whether a word is a number with a comma instead of a point, as some programs write it under a locale.
pub(super) fn has_decimal_comma(word: &[u8]) -> bool {
    let commas = word.iter().filter(|&&b| b == b',').count();
    let point: Vec<u8> = word
        .iter()
        .map(|&b| if b == b',' { b'.' } else { b })
        .collect();
    commas == 1 && number(&point).is_some()
}

/// Says what is wrong with a word that should be a number, and what to do.
pub(super) fn not_a_number(word: &[u8], expected: &str) -> String {
    let word_shown = shown(word);
    match has_decimal_comma(word) {
        true => format!(
            "`{word_shown}` has a decimal comma; export the mesh with decimal points, as under an English locale"
        ),
        false => format!(
            "found `{word_shown}` where {expected} was expected; correct the line or export the mesh again"
        ),
    }
}

/// A word as it may be shown in a message: short, and of printable ASCII only.
pub(super) fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 32;
    let mut text: String = word
        .iter()
        .take(LONGEST)
        .map(|&b| match b {
            b' '..=b'~' => char::from(b),
            _ => '?',
        })
        .collect();
    if word.len() > LONGEST {
        text.push_str("...");
    }
    text
}
