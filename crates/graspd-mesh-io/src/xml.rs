//! What the readers of XML formats share.
//!
//! `quick-xml` splits the text into tags and never opens a file. It leaves entities alone, so a document that declares
//! any can be refused: no text grows while it is read.

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::events::BytesStart;

/// Why a document type is refused.
pub(super) const DOCUMENT_TYPE: &str = "it declares a document type, whose entities could stand for any amount of text or for other files; \
     remove the DOCTYPE line, or export the mesh again";

/// Says what is wrong with the XML. The fault may quote as much of the file as it likes, so only its beginning is shown.
pub(super) fn fault(fault: &quick_xml::Error) -> String {
    const LONGEST: usize = 100;
    let text = fault.to_string();
    let shown = |c: char| {
        if c == ' ' || c.is_ascii_graphic() {
            c
        } else {
            '?'
        }
    };
    let mut short: String = text.chars().take(LONGEST).map(shown).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    format!("the XML cannot be read: {short}; send the whole file or export it again")
}

/// Returns the value of an attribute, whatever its prefix. The attributes are not checked for repetitions, which would
/// take the square of their number.
pub(super) fn attribute<'a>(tag: &'a BytesStart<'_>, name: &str) -> Option<Cow<'a, str>> {
    let mut attributes = tag.attributes();
    let found = attributes.with_checks(false).flatten();
    let mut found = found.filter(|attribute| attribute.key.local_name().into_inner() == name);
    let attribute = found.next()?;
    attribute.normalized_value(XmlVersion::Implicit1_0).ok()
}

/// The name of the root element of an XML document, without its prefix. Looks no further than the first pages.
pub(super) fn root(bytes: &[u8]) -> Option<&[u8]> {
    const FARTHEST: usize = 1 << 16;
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut rest = &text[..text.len().min(FARTHEST)];
    loop {
        rest = rest.trim_ascii_start().strip_prefix(b"<")?;
        // A declaration, a comment or a document type precede the root.
        let end: &[u8] = match rest {
            [b'?', ..] => b"?>",
            [b'!', b'-', b'-', ..] => b"-->",
            // Entities stand in brackets.
            [b'!', ..] if rest.iter().take_while(|&&b| b != b'>').any(|&b| b == b'[') => b"]>",
            [b'!', ..] => b">",
            _ => break,
        };
        let at = rest.windows(end.len()).position(|at| at == end)?;
        rest = &rest[at + end.len()..];
    }
    let end = rest
        .iter()
        .position(|b| !(b.is_ascii_alphanumeric() || matches!(b, b':' | b'_' | b'-' | b'.')))?;
    rest[..end].rsplit(|&b| b == b':').next()
}
