//! Puts the page that Vite has built from `web/` into the binary.
//!
//! Without it, as on a machine without Node, the list is empty and the server says how to get the page.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

use flate2::Compression;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};

/// Where `npm run build` puts the page, and the folder around it, which is always there.
const PAGE: &str = "web/dist/page";
const AROUND: &str = "web/dist";

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={AROUND}");
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?);
    let root = env::current_dir()?.join(PAGE);
    let mut files = Vec::new();
    if root.join("index.html").is_file() {
        collect(&root, &mut files)?;
        files.sort();
    }
    let mut list = String::from("&[\n");
    for (number, file) in files.iter().enumerate() {
        let bytes = fs::read(file)?;
        let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
        gzip.write_all(&bytes)?;
        let compressed = out.join(format!("{number}.gz"));
        fs::write(&compressed, gzip.finish()?)?;
        let name = file.strip_prefix(&root).map_err(io::Error::other)?;
        let path = format!("/{}", name.display()).replace('\\', "/");
        let hash = Sha256::digest(&bytes);
        let hash = hash[..12].iter().fold(String::new(), |mut hash, byte| {
            // Writing to a string cannot fail.
            let _ = write!(hash, "{byte:02x}");
            hash
        });
        let _ = writeln!(
            list,
            "    File {{ path: {path:?}, hash: {hash:?}, bytes: include_bytes!({file:?}), \
             gzip: include_bytes!({compressed:?}) }},",
        );
    }
    list.push(']');
    fs::write(out.join("page.rs"), list)
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        match path.is_dir() {
            true => collect(&path, files)?,
            false => files.push(path),
        }
    }
    Ok(())
}
