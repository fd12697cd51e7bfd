//! What the fuzz target of the quality engine has found or was started with, without a fuzzer.

#[path = "../fuzz/wrench_sets.rs"]
mod wrench_sets;

use std::path::Path;

/// The corpus covers the engine only if it is there.
const FEWEST: usize = 20;

#[test]
fn every_wrench_set_of_the_corpus_keeps_the_promises() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/wrench_sets");
    let mut files: Vec<_> = std::fs::read_dir(&corpus)
        .expect("the corpus")
        .map(|file| file.expect("a file").path())
        .collect();
    files.sort();
    assert!(
        files.len() >= FEWEST,
        "{} files in {}",
        files.len(),
        corpus.display()
    );
    for file in files {
        println!("{}", file.display());
        let data = std::fs::read(&file).expect("a file of the corpus");
        wrench_sets::check(&wrench_sets::decode(&data));
    }
}
