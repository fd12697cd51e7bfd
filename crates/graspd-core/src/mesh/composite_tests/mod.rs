//! Everyday things that people model as solids which cross, touch or nest, each compared with an integral over lines.
//!
//! Every thing is a union of convex polyhedra, which half-spaces describe without triangles. Along a line through it the
//! half-spaces of each polyhedron leave an interval; the length of the union of the intervals, integrated over a grid of
//! lines, is the volume. Nothing of this uses winding numbers, cuts or fluxes.
//!
//! The table has what the same things with seed 1 came to when parts were not compared, with 2,000 uniform candidates
//! each: how many of them point out of the body ("pull"), how many lie in matter ("buried"), and how far volume and
//! centre of mass were off, in percent of the volume and of the bounding radius. Now no candidate pulls or is buried, the
//! volume is right within the 0.4 % of the integral over lines, and the centre within 0.1 % of the radius.
//!
//! | thing | pull | buried | volume, % | centre, % |
//! |---|---|---|---|---|
//! | mug | 0 | 123 | 1.33 | 0.517 |
//! | mallet | 0 | 187 | 4.43 | 0.270 |
//! | hammer | 0 | 153 | 4.63 | 1.037 |
//! | dumbbell | 0 | 320 | 7.99 | 0.211 |
//! | cross | 0 | 203 | 11.59 | 0.069 |
//! | kettle | 91 | 235 | -2.59 | 2.314 |
//! | spoon | 0 | 137 | 2.39 | 0.047 |
//! | table | 0 | 61 | 1.10 | 0.080 |
//! | snowman | 0 | 291 | 4.51 | 1.327 |
//! | pan | 0 | 57 | 1.03 | 0.299 |
//! | bracket | 0 | 68 | 4.64 | 1.811 |
//! | bottle | 0 | 376 | 7.05 | 3.613 |
//! | fan | 456 | 219 | -98.52 | 16.909 |
//! | screwdriver | 0 | 79 | 0.97 | 0.369 |
//! | key | 0 | 123 | 3.40 | 0.810 |
//! | bench of blocks | 0 | 289 | 0.00 | 0.000 |
//! | core in a case | 0 | 374 | -11.81 | 0.488 |
//! | chain of two links | 0 | 373 | 16.04 | 3.359 |

mod boxes;
mod convex;
mod things;

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use self::convex::{Solid, by_lines, contains, near_surface};
use self::things::things;
use super::solids::join;
use super::*;
use crate::interrupt::Interrupt;

fn shuffled(raw: &RawMesh, seed: u64) -> RawMesh {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut raw = raw.clone();
    for last in (1..raw.triangles.len()).rev() {
        let other = (rng.next_u64() % (last as u64 + 1)) as usize;
        raw.triangles.swap(last, other);
    }
    raw
}

fn joined(solids: &[Solid]) -> RawMesh {
    let parts: Vec<RawMesh> = solids.iter().map(|solid| solid.raw.clone()).collect();
    join(&parts)
}

#[test]
fn everyday_composites_are_weighed_and_touched_as_their_union() {
    for seed in [1, 2] {
        for (name, solids) in things(seed) {
            let raw = joined(&solids);
            let mesh = Mesh::prepare(raw.clone()).unwrap();
            let report = mesh.report();
            let (volume, center) = by_lines(&solids, &report.bounds, 300);
            let found = report.volume.unwrap();
            assert!(
                (found / volume - 1.0).abs() < 4e-3,
                "{name}: {found} for {volume}"
            );
            let off = (report.center_of_mass - center).norm() / report.bounding_radius;
            assert!(off < 1e-3, "{name}: the centre is off by {off}");
            if let Some(bound) = report.volume_bound {
                assert!(bound < 1e-3, "{name}: {bound}");
            }
            let step = 1e-4 * (report.bounds[1] - report.bounds[0]).norm();
            let uniform = mesh
                .uniform_candidates(500, seed, Interrupt::never())
                .unwrap();
            assert_eq!(uniform.len(), 500);
            for candidate in mesh.candidates().into_iter().chain(uniform) {
                if near_surface(&solids, &candidate.position, 0.3 * step) {
                    let above = candidate.position - candidate.normal.into_inner() * step;
                    let below = candidate.position + candidate.normal.into_inner() * step;
                    assert!(!contains(&solids, &above), "{name}: buried {candidate:?}");
                    assert!(contains(&solids, &below), "{name}: pulls {candidate:?}");
                } else {
                    panic!("{name}: not on the surface of the union: {candidate:?}");
                }
            }
            // Whatever is left out lies in matter, or is flush with the same face of another solid.
            for &number in mesh.source() {
                if let Err(NoCandidate::Buried(_)) = mesh.candidate_of(number) {
                    let index = mesh.source().binary_search(&number).unwrap();
                    let corners = triangle::corners(mesh.vertices(), mesh.triangles()[index]);
                    let outward = triangle::normal(&corners).normalize() * step;
                    let at = triangle::centroid(&corners);
                    let filled = solids
                        .iter()
                        .filter(|solid| contains(std::slice::from_ref(*solid), &(at - outward)));
                    let buried = contains(&solids, &(at + outward)) || filled.count() > 1;
                    assert!(buried, "{name}: triangle {number}");
                }
            }
        }
    }
}

#[test]
fn the_order_of_triangles_changes_nothing() {
    for (name, solids) in things(3) {
        let raw = joined(&solids);
        let plain = Mesh::prepare(raw.clone()).unwrap().report().clone();
        for seed in 0..2 {
            let other = Mesh::prepare(shuffled(&raw, seed))
                .unwrap()
                .report()
                .clone();
            let volume = other.volume.unwrap() / plain.volume.unwrap() - 1.0;
            let off = (other.center_of_mass - plain.center_of_mass).norm();
            let bound = plain.volume_bound.unwrap_or(0.0) + 1e-12;
            assert!(volume.abs() <= bound, "{name}: {volume}");
            assert!(off <= bound * plain.bounding_radius, "{name}: {off}");
            assert_eq!(
                (
                    plain.candidates,
                    plain.buried_triangles,
                    plain.enclosed_triangles
                ),
                (
                    other.candidates,
                    other.buried_triangles,
                    other.enclosed_triangles
                ),
                "{name}"
            );
            assert_eq!(
                (plain.overlapping_parts, plain.body_count, plain.mass_from),
                (other.overlapping_parts, other.body_count, other.mass_from),
                "{name}"
            );
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let (_, solids) = things(4).swap_remove(5);
    let raw = joined(&solids);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| Mesh::prepare(raw.clone()).unwrap())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.report(), three.report());
    assert_eq!(
        (one.triangles(), &one.cover),
        (three.triangles(), &three.cover)
    );
}
