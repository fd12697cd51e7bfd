//! `cargo +nightly fuzz run wrench_sets`: no wrench set, however odd, makes the engine panic, loop or lie.
#![no_main]

use fuzz_checks::wrench_sets;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    wrench_sets::check(&wrench_sets::decode(data));
});
