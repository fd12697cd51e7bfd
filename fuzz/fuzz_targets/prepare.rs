//! Arbitrary triangles, prepared.

#![no_main]

use fuzz_checks::meshes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| meshes::check_preparation(meshes::decode(data)));
