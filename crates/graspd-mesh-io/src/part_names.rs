//! The names of the parts that a reader meets, as they go into the table of the mesh.
//!
//! A part enters the table with its first triangle. The table thus takes memory in proportion to the triangles, which
//! are limited, however many names without a surface a file has.
//!
//! Two kinds of formats differ in what an equal name means. A group of an OBJ file may be interrupted and resumed, so
//! an equal name is the same part. Objects of the others are things of their own, two screws with one name included:
//! the second is entered as `screw (2)`.

use std::collections::HashMap;

use graspd_core::mesh::NamedParts;

/// The longest name that is kept, in characters.
const LONGEST: usize = 100;

/// The part that the next triangle belongs to, and the names that are taken.
#[derive(Default)]
pub(super) struct PartNames {
    state: State,
    /// The index of each name in the table.
    taken: HashMap<String, usize>,
    /// How many parts wanted each name that more than one wanted.
    wanted: HashMap<String, usize>,
    /// The bytes of all names in the table.
    bytes: usize,
}

#[derive(Default)]
enum State {
    #[default]
    Nameless,
    /// No triangle has come yet.
    Pending {
        name: String,
        may_resume: bool,
    },
    Entered(usize),
}

impl PartNames {
    /// Continues the part with this name, or begins it.
    pub(super) fn resume(&mut self, name: &[u8]) {
        self.state = pending(name, true);
    }

    /// Begins a part, whatever other parts are called.
    pub(super) fn begin(&mut self, name: &[u8]) {
        self.state = pending(name, false);
    }

    /// Returns the index of the current part in `table`, which it enters if it is new.
    pub(super) fn current(&mut self, table: &mut NamedParts) -> Option<usize> {
        let (name, may_resume) = match &self.state {
            State::Nameless => return None,
            State::Entered(part) => return Some(*part),
            State::Pending { name, may_resume } => (name.clone(), *may_resume),
        };
        let known = self.taken.get(&name).copied().filter(|_| may_resume);
        let part = known.unwrap_or_else(|| {
            let name = self.free(name);
            self.bytes += name.len();
            let part = table.add(name.clone());
            self.taken.insert(name, part);
            part
        });
        self.state = State::Entered(part);
        Some(part)
    }

    /// Returns about how many bytes of memory the names take, in the table and here.
    pub(super) fn memory(&self) -> usize {
        let keys = self.taken.len() + self.wanted.len();
        3 * self.bytes + (keys + self.taken.len()) * size_of::<(String, usize)>()
    }

    /// Returns the name, with a number where it is taken. Every number is tried once for each name, so all parts
    /// together take time in proportion to their count.
    fn free(&mut self, name: String) -> String {
        if !self.taken.contains_key(&name) {
            return name;
        }
        let count = self.wanted.entry(name.clone()).or_insert(1);
        loop {
            *count += 1;
            let numbered = format!("{name} ({count})");
            if !self.taken.contains_key(&numbered) {
                return numbered;
            }
        }
    }
}

/// A name as it may be shown: without line breaks and marks that would spoil a message, and not too long.
fn pending(name: &[u8], may_resume: bool) -> State {
    // Longer than the longest name of four-byte characters; the rest need not be decoded.
    let name = &name.trim_ascii()[..name.trim_ascii().len().min(4 * LONGEST)];
    let text = String::from_utf8_lossy(name);
    let shown = text.chars().filter(|c| !is_unsafe(*c)).take(LONGEST);
    let name: String = shown.collect();
    match name.trim() {
        "" => State::Nameless,
        name => State::Pending {
            name: name.to_owned(),
            may_resume,
        },
    }
}

/// Whether a character can change how the text around it is shown.
fn is_unsafe(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}
