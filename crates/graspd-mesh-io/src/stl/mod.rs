//! STL (3D Systems' stereolithography interface), in its two forms.

pub(super) mod ascii;
pub(super) mod binary;
