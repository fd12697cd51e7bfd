//! Qhull, the C library in its reentrant form, on one wrench set at a time.
//!
//! A test compares its answers with those of the quality engine, and a benchmark the time that both take.

use std::ffi::{CStr, c_char, c_int};
use std::ptr;

use graspd_core::wrench::Wrench;
use qhull_sys as sys;

/// What Qhull 2020.2 does in six dimensions by default, and what scipy's `ConvexHull` asks
/// for: coplanar points are merged into a facet only where it must be.
pub const PLAIN: &CStr = c"qhull Qx Pp";

/// As [`PLAIN`], with the merged facets triangulated.
pub const TRIANGULATED: &CStr = c"qhull Qt Qx Pp";

/// What GraspIt! asks for: facets are merged until they are convex to 10⁻⁴. Its answers are as coarse.
pub const GRASPIT: &CStr = c"qhull Qx C-0.0001 Pp FA";

/// As [`TRIANGULATED`], with area and volume.
pub const VOLUME: &CStr = c"qhull Qt Qx Pp FA";

/// Why there is no hull: Qhull's exit code, 2 when the set is flat to its precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Failed(pub i32);

unsafe extern "C" {
    fn fopen(path: *const c_char, mode: *const c_char) -> *mut sys::FILE;
}

/// A hull in Qhull's own memory, freed on drop.
pub struct Qhull {
    qh: Box<sys::qhT>,
}

/// The points of one set as Qhull takes them.
pub fn points(wrenches: &[Wrench]) -> Vec<f64> {
    wrenches.iter().flat_map(|w| w.iter().copied()).collect()
}

/// Where Qhull's messages go: nowhere.
pub struct Silence(*mut sys::FILE);

impl Default for Silence {
    fn default() -> Self {
        Self::new()
    }
}

impl Silence {
    pub fn new() -> Self {
        // SAFETY: both strings end in zero; the handle lives as long as the process.
        let file = unsafe { fopen(c"/dev/null".as_ptr(), c"w".as_ptr()) };
        assert!(!file.is_null(), "/dev/null cannot be opened");
        Self(file)
    }

    /// The hull of `points`, six numbers each, which must outlive it.
    pub fn hull(&self, points: &mut [f64], options: &CStr) -> Result<Qhull, Failed> {
        let count = c_int::try_from(points.len() / 6).expect("a set that fits into memory");
        // SAFETY: `qhT` is a C struct without invariants before `qh_zero`, which is called before any
        // other function. Qhull reports errors by its exit code: its long jumps end in
        // `qh_new_qhull` and cross no Rust frame. Options are only read.
        let mut qh: Box<sys::qhT> = unsafe { Box::new(std::mem::zeroed()) };
        let code = unsafe {
            sys::qh_zero(&mut *qh, self.0);
            sys::qh_new_qhull(
                &mut *qh,
                6,
                count,
                points.as_mut_ptr(),
                0,
                options.as_ptr().cast_mut(),
                ptr::null_mut(),
                self.0,
            )
        };
        let hull = Qhull { qh };
        if code == 0 {
            Ok(hull)
        } else {
            Err(Failed(code))
        }
    }
}

impl Qhull {
    /// The facets: outward unit normal, and offset, the distance of the origin on their inner side.
    pub fn facets(&self) -> impl Iterator<Item = ([f64; 6], f64)> {
        let mut facet = self.qh.facet_list;
        std::iter::from_fn(move || {
            // SAFETY: the list ends in a sentinel whose `next` is null; a facet's normal has six
            // components while the hull lives.
            let at = unsafe { facet.as_ref()? };
            if at.next.is_null() {
                return None;
            }
            facet = at.next;
            let normal = unsafe { *at.normal.cast::<[f64; 6]>() };
            Some((normal, -at.offset))
        })
    }

    /// The least offset of any facet.
    pub fn margin(&self) -> f64 {
        self.facets()
            .fold(f64::INFINITY, |least, (_, offset)| least.min(offset))
    }

    /// The volume, when the hull was made with [`VOLUME`].
    pub fn volume(&self) -> f64 {
        self.qh.totvol
    }
}

impl Drop for Qhull {
    fn drop(&mut self) {
        let (mut left, mut blocks) = (0, 0);
        // SAFETY: the memory is Qhull's own and nothing refers to it any more.
        unsafe {
            sys::qh_freeqhull(&mut *self.qh, 0);
            sys::qh_memfreeshort(&mut *self.qh, &mut left, &mut blocks);
        }
    }
}
