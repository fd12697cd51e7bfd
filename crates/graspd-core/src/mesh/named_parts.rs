//! The named parts of a file, such as the groups of an OBJ file.

/// The entry of a triangle that belongs to no named part.
const UNNAMED: u32 = u32::MAX;

/// Which triangles belong to which named part of the file: a table of names, and an entry for each triangle.
///
/// ```
/// use graspd_core::mesh::NamedParts;
///
/// let mut parts = NamedParts::default();
/// let handle = parts.add("handle".to_owned());
/// parts.assign(1, handle);
/// assert_eq!([0, 1, 2].map(|triangle| parts.of(triangle)), [None, Some(handle), None]);
/// assert_eq!(parts.names()[handle], "handle");
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct NamedParts {
    names: Vec<String>,
    /// Ends with the last triangle that belongs to a part, so that a file without names takes no memory.
    entries: Vec<u32>,
}

impl NamedParts {
    /// Adds a part and returns its index. Names need not differ.
    pub fn add(&mut self, name: String) -> usize {
        self.names.push(name);
        self.names.len() - 1
    }

    /// Makes a triangle belong to the part with this index.
    pub fn assign(&mut self, triangle: usize, part: usize) {
        if self.entries.len() <= triangle {
            self.entries.resize(triangle + 1, UNNAMED);
        }
        self.entries[triangle] = part as u32;
    }

    /// Returns the index of the part that a triangle of the file belongs to, or `None` if it belongs to none.
    pub fn of(&self, triangle: usize) -> Option<usize> {
        let entry = self.entries.get(triangle).copied();
        entry
            .filter(|&part| part != UNNAMED)
            .map(|part| part as usize)
    }

    /// Returns the names of the parts, in the order in which the file has them.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}
