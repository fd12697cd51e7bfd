//! Volume, centre of mass and flatness.
//!
//! A closed surface that is wound outward bounds a solid. Every triangle makes a signed tetrahedron with a reference
//! point; summed over the surface, the parts outside the solid cancel, and what is left is the volume and, weighted
//! with the centroids, the first moment. An open surface bounds no solid, but most scans are open only where the
//! body stood: if flat caps over the holes are small, the capped surface is weighed in its place. What is neither is
//! weighed as a thin shell.
//!
//! ```text
//! closed                             the solid, or no body at all if it has no volume
//! open, and all caps are small       the solid within surface and caps
//! parts of either that overlap       their union, as its boundary was found
//! else                               the surface as a shell
//! a solid that fails its checks      the surface as a shell
//! ```
//!
//! **Why the numbers can be trusted:** sums are taken about the centre of the box in units of its diagonal, so a body
//! far from the origin loses no precision and one of extreme size neither overflows nor vanishes. The volume is
//! computed a second time as the flux of x, y and z through the surface. These three sums agree with it, and with
//! each other, only when the surface is closed and consistently wound; their distance is reported.
//!
//! **Cost:** O(n), and O(n log n) to find the holes of an open surface.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use parry3d_f64::mass_properties::details::trimesh_signed_volume_and_center_of_mass;
use parry3d_f64::math::Vector;

use super::caps::Caps;
use super::overlap::Moments;
use super::{MassSource, triangle};

/// Volume below which a closed surface encloses nothing, over its area times its diagonal.
///
/// Summing signed tetrahedra leaves rounding of about 1e-13 of that product for a million
/// triangles. A plate that is just thick enough to pass for a body, one welding tolerance
/// (5e-7 of the diagonal), still has half of that.
const ZERO_VOLUME: f64 = 1e-9;

/// Greatest area of the caps that close all holes, over that of the surface. A box scanned without its floor
/// stays below, and an empty half of a ball, which is no solid, is at 0.5.
const LARGEST_CAPS: f64 = 0.25;

/// How far the volumes along the three axes may be apart, over the volume.
const WORST_VOLUME: f64 = 1e-6;

/// The same for the union of parts that overlap, whose boundary is cut out within a tolerance.
const WORST_UNION: f64 = 0.01;

/// Steps after which the search for principal axes gives up; three by three needs a handful.
const MAX_SWEEPS: usize = 100;

/// The axis-aligned box of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) low: Point3<f64>,
    pub(super) high: Point3<f64>,
    pub(super) center: Point3<f64>,
    pub(super) diagonal: f64,
}

/// What a body weighs, and what was weighed.
#[derive(Debug)]
pub(super) struct Weight {
    pub(super) mass_from: MassSource,
    /// `None` of a shell.
    pub(super) volume: Option<f64>,
    /// How far the volumes along the three axes are from `volume`, over it; `None` of a shell.
    pub(super) volume_error: Option<f64>,
    /// Of the whole surface, without caps.
    pub(super) area: f64,
    pub(super) center_of_mass: Point3<f64>,
    /// How far volume, over itself, and centre of mass of a union may be wrong.
    pub(super) bounds: Option<[f64; 2]>,
    /// Closed lines along which the surface is open.
    pub(super) holes: usize,
}

/// What a surface bounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounded<'a> {
    /// Whether the surface, with its caps if it has any, bounds a solid.
    pub(super) is_solid: bool,
    /// The caps over its holes.
    pub(super) caps: Option<&'a Caps>,
    /// The moments of the union, where parts overlap.
    pub(super) union: Option<&'a Moments>,
}

/// Whether caps are so small that what they close is a solid.
pub(super) fn are_small(caps: &Caps, vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> bool {
    let areas = triangles
        .iter()
        .map(|&t| triangle::area(&triangle::corners(vertices, t)));
    caps.area(vertices) <= LARGEST_CAPS * areas.sum::<f64>()
}

/// Weighs a surface that is consistently wound, where that is possible, and faces away from its matter. `None` when it
/// is closed and encloses no volume.
pub(super) fn weigh(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    bounded: &Bounded<'_>,
    extent: &Extent,
) -> Option<Weight> {
    let &Bounded {
        is_solid,
        caps,
        union,
    } = bounded;
    let (area, center_of_surface) = surface(vertices, triangles, &extent.center);
    let closed = is_solid && caps.is_none();
    let (mass_from, solid) = match (union, caps) {
        _ if !is_solid => (MassSource::Surface, None),
        (Some(union), _) => (MassSource::Union, Some(Solid::of_union(union, extent))),
        (None, None) => (MassSource::Solid, Some(solid(vertices, triangles, extent))),
        (None, Some(caps)) => {
            let (vertices, triangles) = caps.applied(vertices, triangles);
            (
                MassSource::Capped,
                Some(solid(&vertices, &triangles, extent)),
            )
        }
    };
    let least_volume = ZERO_VOLUME * area * extent.diagonal;
    if closed && solid.is_some_and(|solid| solid.volume <= least_volume) {
        return None;
    }
    let worst = match mass_from {
        MassSource::Union => WORST_UNION,
        _ => WORST_VOLUME,
    };
    // A surface that crosses itself counts some space negatively. When that moves the centre
    // out of the box, or nothing is left, the numbers are not those of any solid.
    let solid = solid.filter(|solid| {
        solid.volume > least_volume
            && solid.error <= worst
            && extent.low <= solid.center
            && solid.center <= extent.high
    });
    let bound = |solid: Solid| [solid.uncertain, solid.uncertain * extent.diagonal];
    Some(Weight {
        mass_from: match solid {
            Some(_) => mass_from,
            None => MassSource::Surface,
        },
        volume: solid.map(|solid| solid.volume),
        volume_error: solid.map(|solid| solid.error),
        area,
        center_of_mass: solid.map_or(center_of_surface, |solid| solid.center),
        bounds: solid.filter(|_| mass_from == MassSource::Union).map(bound),
        holes: caps.map_or(0, Caps::count),
    })
}

/// Mass properties of a solid of uniform density.
#[derive(Debug, Clone, Copy)]
struct Solid {
    volume: f64,
    /// The centre of mass.
    center: Point3<f64>,
    /// How far the volumes along the three axes are from `volume`, over it.
    error: f64,
    /// How much of the volume may be wrong, over it. All of it lies within half a diagonal of the middle, as the centre
    /// of mass does, so the centre is off by at most a diagonal times this.
    uncertain: f64,
}

impl Solid {
    fn of_union(union: &Moments, extent: &Extent) -> Self {
        let &Moments {
            volume,
            moment,
            flux,
            uncertain,
        } = union;
        let error = (flux / volume).add_scalar(-1.0).amax();
        Self {
            volume: volume * extent.diagonal.powi(3),
            center: extent.center + moment / volume * extent.diagonal,
            error,
            // A boundary that does not close shows in the flux.
            uncertain: (uncertain / volume).max(error),
        }
    }
}

/// Enclosed volume and centre of mass of a closed, outward surface at uniform density.
fn solid(vertices: &[Point3<f64>], triangles: &[[u32; 3]], extent: &Extent) -> Solid {
    let &Extent {
        center, diagonal, ..
    } = extent;
    let local: Vec<Vector> = vertices
        .iter()
        .map(|v| (v - center) / diagonal)
        .map(|v| Vector::new(v.x, v.y, v.z))
        .collect();
    let (volume, at) = trimesh_signed_volume_and_center_of_mass(&local, triangles);
    // By the divergence theorem the flux of (x, 0, 0) through the surface is the volume; of y and z alike. Over a
    // triangle the mean of x is that of its centroid, and its area vector is half its normal.
    let flux: Vector3<f64> = triangles
        .iter()
        .map(|&indices| triangle::corners(vertices, indices))
        .map(|corners| corners.map(|corner| Point3::from((corner - center) / diagonal)))
        .map(|corners| {
            let middle = triangle::centroid(&corners).coords;
            middle.component_mul(&triangle::normal(&corners)) / 2.0
        })
        .sum();
    Solid {
        volume: volume * diagonal.powi(3),
        center: center + Vector3::new(at.x, at.y, at.z) * diagonal,
        error: (flux / volume).add_scalar(-1.0).amax(),
        uncertain: 0.0,
    }
}

/// Total area, and the centre of mass of the surface as a thin shell of uniform thickness.
fn surface(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    center: &Point3<f64>,
) -> (f64, Point3<f64>) {
    let (area, moment) = triangles
        .iter()
        .map(|&indices| triangle::corners(vertices, indices))
        .fold((0.0, Vector3::zeros()), |(area, moment), corners| {
            let share = triangle::area(&corners);
            let arm = triangle::centroid(&corners) - center;
            (area + share, moment + arm * share)
        });
    (area, center + moment / area)
}

/// Least width of the body along its principal axes: the distance of two parallel planes, at right angles to such
/// an axis, that hold all vertices between them.
///
/// For points of one plane this is zero but for rounding, in whatever direction the plane lies.
pub(super) fn thickness(vertices: &[Point3<f64>], extent: &Extent) -> f64 {
    let &Extent {
        center, diagonal, ..
    } = extent;
    let local = || vertices.iter().map(|v| (v - center) / diagonal);
    let mean = local().sum::<Vector3<f64>>() / vertices.len() as f64;
    let covariance: Matrix3<f64> = local().map(|v| (v - mean) * (v - mean).transpose()).sum();
    let axes = SymmetricEigen::try_new(covariance, f64::EPSILON, MAX_SWEEPS)
        .map_or_else(Matrix3::identity, |eigen| eigen.eigenvectors);
    let widths = axes.column_iter().map(|axis| {
        let (low, high) = local()
            .map(|v| axis.dot(&v))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
        high - low
    });
    widths.fold(f64::INFINITY, f64::min) * diagonal
}

/// Greatest distance of a vertex from `point`.
pub(super) fn radius_about(vertices: &[Point3<f64>], point: &Point3<f64>) -> f64 {
    vertices
        .iter()
        .map(|v| (v - point).norm_squared())
        .fold(0.0, f64::max)
        .sqrt()
}
