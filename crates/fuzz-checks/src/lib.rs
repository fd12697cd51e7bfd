//! What the planner and the readers of mesh files promise of any bytes. The fuzz targets in `fuzz/` look for bytes
//! that break a promise; a test checks the corpora that they have collected, without a fuzzer.

pub mod meshes;
pub mod wrench_sets;
