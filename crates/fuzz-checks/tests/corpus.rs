//! Checks what the fuzz targets have found or were started with, without a fuzzer.

use std::path::Path;

use fuzz_checks::{meshes, wrench_sets};
use graspd_mesh_io::MeshFormat;

/// The bytes of every file of a corpus, which has `fewest` of them: it covers something only if it is there.
fn corpus(name: &str, fewest: usize) -> Vec<Vec<u8>> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/corpus")
        .join(name);
    let mut files: Vec<_> = std::fs::read_dir(&corpus)
        .expect("the corpus")
        .map(|file| file.expect("a file").path())
        .collect();
    files.sort();
    assert!(files.len() >= fewest, "{} files of {name}", files.len());
    let read = |file| {
        println!("{}", Path::display(file));
        std::fs::read(file).expect("a file of the corpus")
    };
    files.iter().map(|file| read(file)).collect()
}

#[test]
fn every_wrench_set_of_the_corpus_keeps_the_promises() {
    for data in corpus("wrench_sets", 20) {
        wrench_sets::check(&wrench_sets::decode(&data));
    }
}

#[test]
fn every_file_of_the_corpora_is_read_or_refused() {
    for (name, format) in [
        ("read_stl", MeshFormat::Stl),
        ("read_obj", MeshFormat::Obj),
        ("read_ply", MeshFormat::Ply),
        ("read_off", MeshFormat::Off),
        ("read_gltf", MeshFormat::Glb),
        ("read_dae", MeshFormat::Dae),
    ] {
        for data in corpus(name, 30) {
            meshes::check_reader(&data, format);
        }
    }
}

#[test]
fn every_3mf_file_of_the_corpus_is_read_or_refused() {
    for data in corpus("read_3mf", 30) {
        meshes::check_3mf(&data);
    }
}

#[test]
fn all_triangles_of_the_corpus_are_prepared_or_refused() {
    for data in corpus("prepare", 30) {
        meshes::check_preparation(meshes::decode(&data));
    }
}
