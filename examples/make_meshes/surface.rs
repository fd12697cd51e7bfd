//! From a signed distance field to a first closed mesh, and points onto its surface.

use crate::{mesh::Mesh, sdf::Field};
use fast_surface_nets::{
    SurfaceNetsBuffer,
    glam::DVec3,
    ndshape::{RuntimeShape, Shape},
    surface_nets,
};

/// Samples `field` on a grid of cubes of side `step` over the box from `min` to `max` and joins one
/// vertex in each cube the surface passes through (naive surface nets). The triangles are uneven;
/// [`crate::remesh`] sees to that.
pub fn extract(field: &Field, min: DVec3, max: DVec3, step: f64) -> Mesh {
    // Two empty layers all around, so that the surface never meets the end of the grid.
    let origin = min - 2.0 * step;
    let size = ((max - origin) / step).ceil().as_uvec3() + 3;
    let shape = RuntimeShape::<u32, 3>::new(size.to_array());
    let at = |[x, y, z]: [u32; 3]| origin + DVec3::new(x.into(), y.into(), z.into()) * step;
    let mut samples: Vec<f32> = (0..shape.size())
        .map(|i| field(at(shape.delinearize(i))) as f32)
        .collect();
    fill_ambiguous(&mut samples, size.to_array());
    let mut net = SurfaceNetsBuffer::default();
    let last = size - 1;
    surface_nets(&samples, &shape, [0; 3], last.to_array(), &mut net);
    Mesh {
        vertices: net
            .positions
            .iter()
            .map(|&[x, y, z]| origin + DVec3::new(x.into(), y.into(), z.into()) * step)
            .collect(),
        triangles: net
            .indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    }
}

/// Fills samples in until no two sheets of the surface pass through one cube or touch across one of
/// its faces, where surface nets would tie them together. That happens in sharp creases only; the
/// remeshing brings the surface back to where it belongs.
fn fill_ambiguous(samples: &mut [f32], [nx, ny, nz]: [u32; 3]) {
    let [right, back, up] = [1, nx as usize, (nx * ny) as usize];
    let mut settled = false;
    while !settled {
        settled = true;
        let mut fill_if = |first: [usize; 2], second: [usize; 2]| {
            let inside = |i: usize| samples[i] < 0.0;
            let alike = |pair: [usize; 2]| inside(pair[0]) == inside(pair[1]);
            if alike(first) && alike(second) && inside(first[0]) != inside(second[0]) {
                let [a, b] = if inside(first[0]) { second } else { first };
                samples[if samples[a] <= samples[b] { a } else { b }] = -1e-3;
                settled = false;
            }
        };
        for i in cells([nx, ny, nz]) {
            for (u, v) in [(right, back), (back, up), (up, right)] {
                fill_if([i, i + u + v], [i + u, i + v]);
            }
        }
        for i in cells([nx, ny, nz]) {
            let corners: [usize; 8] =
                std::array::from_fn(|k| i + (k & 1) * right + (k >> 1 & 1) * back + (k >> 2) * up);
            let inside = corners.iter().filter(|&&c| samples[c] < 0.0).count();
            if inside != 2 && inside != 6 {
                continue;
            }
            let odd: Vec<usize> = (0..8)
                .filter(|&k| (samples[corners[k]] < 0.0) == (inside == 2))
                .collect();
            if odd[0] + odd[1] == 7 {
                let outside = corners.into_iter().filter(|&c| samples[c] >= 0.0);
                let nearest = outside.min_by(|&a, &b| samples[a].total_cmp(&samples[b]));
                samples[nearest.expect("two or six corners are outside")] = -1e-3;
                settled = false;
            }
        }
    }
}

/// The lowest corner of each cube of a grid of samples.
fn cells([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = usize> {
    (0..nz - 1).flat_map(move |z| {
        (0..ny - 1).flat_map(move |y| (0..nx - 1).map(move |x| ((z * ny + y) * nx + x) as usize))
    })
}

/// Moves `p` to the surface by Newton steps along the gradient, none longer than `reach`.
pub fn project(field: &Field, mut p: DVec3, reach: f64) -> DVec3 {
    for _ in 0..4 {
        let (distance, gradient) = sample(field, p, reach * 1e-3);
        let step = gradient * (distance / gradient.length_squared().max(1e-2));
        p -= step.clamp_length_max(reach);
        if step.length_squared() < 1e-8 * reach * reach {
            break;
        }
    }
    p
}

/// The field and its gradient from the four corners of a small tetrahedron around `p`, which is
/// cheaper than six central differences and as good.
fn sample(field: &Field, p: DVec3, h: f64) -> (f64, DVec3) {
    const CORNERS: [DVec3; 4] = [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, -1.0, -1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(-1.0, -1.0, 1.0),
    ];
    let mut mean = 0.0;
    let mut gradient = DVec3::ZERO;
    for corner in CORNERS {
        let value = field(p + corner * h);
        mean += value / 4.0;
        gradient += corner * (value / (4.0 * h));
    }
    (mean, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sdf::sphere;

    #[test]
    fn a_sharp_crease_stays_one_clean_surface_on_every_grid() {
        let twins = |p| sphere(p, DVec3::X, 1.1).min(sphere(p, DVec3::NEG_X, 1.1));
        for hundredths in 5..30 {
            let step = 0.01 * f64::from(hundredths);
            let (min, max) = (DVec3::new(-2.1, -1.1, -1.1), DVec3::new(2.1, 1.1, 1.1));
            let report = extract(&twins, min, max, step).check();
            assert_eq!(report.map(|r| r.genus), Ok(0), "step {step}");
        }
    }

    #[test]
    fn projection_reaches_the_surface() {
        let ball = |p| sphere(p, DVec3::ZERO, 2.0);
        let p = project(&ball, DVec3::new(1.5, 0.5, -0.5), 1.0);
        assert!((p.length() - 2.0).abs() < 1e-6);
    }
}
