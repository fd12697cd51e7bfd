//! Arbitrary bytes, read as 3MF, as the model in a 3MF file, and as what they look like.

#![no_main]

use fuzz_checks::meshes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| meshes::check_3mf(data));
