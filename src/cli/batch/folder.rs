//! The folder of the results.

use std::fs::{self, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::Builder;

/// Prefix of the names of unfinished files.
const UNFINISHED: &str = ".graspd-batch-";

/// The folder into which results are written; a file is never left half-written.
pub struct Folder(PathBuf);

impl Folder {
    /// Opens the folder and creates it if necessary.
    pub fn open(path: &Path) -> io::Result<Self> {
        fs::create_dir_all(path)?;
        Ok(Self(path.to_owned()))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file, replacing one of the same name. The file is on stable storage once this returns.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let mut file = Builder::new()
            .prefix(UNFINISHED)
            .permissions(Permissions::from_mode(0o666))
            .tempfile_in(&self.0)?;
        file.write_all(bytes)?;
        let file = file.persist(self.path(name))?;
        file.sync_all()
    }

    /// Removes unfinished files that a killed run has left.
    pub fn remove_unfinished(&self) -> io::Result<()> {
        for entry in fs::read_dir(&self.0)? {
            let entry = entry?;
            let name = entry.file_name();
            if name.to_string_lossy().starts_with(UNFINISHED) {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }
}

/// Returns the name of the result of a mesh file: the first free one of `duck.stl.json`, `duck.stl-2.json`, ...
pub fn output_name(file_name: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let first = format!("{file_name}.json");
    let mut others = (2..).map(|number: u64| format!("{file_name}-{number}.json"));
    match is_taken(&first) {
        false => first,
        true => others.find(|name| !is_taken(name)).unwrap_or(first),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_files_have_the_same_name() {
        let mut taken: Vec<String> = Vec::new();
        for file in ["duck.stl", "duck.stl", "duck.stl-2", "duck.stl", "box.stl"] {
            let name = output_name(file, |name| taken.iter().any(|other| other == name));
            taken.push(name);
        }
        let expected = [
            "duck.stl.json",
            "duck.stl-2.json",
            "duck.stl-2-2.json",
            "duck.stl-3.json",
            "box.stl.json",
        ];
        assert_eq!(taken, expected);
    }

    #[test]
    fn a_file_is_replaced_and_unfinished_files_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(&place.path().join("a/b")).unwrap();
        folder.write("x.json", b"one").unwrap();
        folder.write("x.json", b"two").unwrap();
        fs::write(folder.path(".graspd-batch-half"), b"ha").unwrap();
        folder.remove_unfinished().unwrap();
        assert_eq!(fs::read(folder.path("x.json")).unwrap(), b"two");
        assert_eq!(fs::read_dir(folder.path("")).unwrap().count(), 1);
    }
}
