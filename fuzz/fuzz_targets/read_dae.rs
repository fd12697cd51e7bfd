//! Arbitrary bytes, read as COLLADA and as what they look like.

#![no_main]

use fuzz_checks::meshes;
use graspd_mesh_io::MeshFormat;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| meshes::check_reader(data, MeshFormat::Dae));
