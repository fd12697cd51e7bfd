//! Consistent, outward winding.
//!
//! Inside a part of the surface that hangs together over edges of two triangles, one winding
//! decides all others. The part as a whole is then turned outward: away from the material.

use nalgebra::Point3;

use super::edges::{EdgeUse, Edges};
use super::{nest, triangle};

/// What was found on the way.
#[derive(Debug)]
pub(super) struct Orientation {
    pub(super) components: usize,
    pub(super) flipped: usize,
    pub(super) border_edges: usize,
    pub(super) non_manifold_edges: usize,
    /// Every part is closed in itself, so the signed volume is that of the solid.
    pub(super) closed: bool,
}

/// A part of the surface that hangs together over edges of two triangles.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) triangles: Vec<u32>,
    /// Each of its edges is used as often in one direction as in the other.
    pub(super) closed: bool,
    /// Signed volume about the reference point, with the winding at hand.
    pub(super) volume: f64,
}

/// Turns triangles until the surface is consistent and faces away from the material.
///
/// A closed part faces outward when an even number of other closed parts encloses it and inward
/// (into the cavity) when an odd number does, so a hollow body stays hollow. An open part has no
/// inside: it keeps the winding of most of its triangles, and if the open parts together then
/// enclose a negative volume about `center`, all of them are turned. O(n log n) but for the
/// nesting test, which is bounded.
pub(super) fn orient(
    vertices: &[Point3<f64>],
    triangles: &mut [[u32; 3]],
    center: &Point3<f64>,
    tolerance: f64,
) -> Orientation {
    let edges = Edges::new(triangles);
    let Growth {
        part,
        turned,
        parts,
    } = grow(triangles.len(), &edges);
    let mut parts: Vec<Part> = parts
        .into_iter()
        .map(|triangles| Part {
            triangles,
            closed: true,
            volume: 0.0,
        })
        .collect();

    let (border_edges, non_manifold_edges) = tally(&edges, &part, &turned, &mut parts);

    let before = triangles.to_vec();
    for (indices, &turned) in triangles.iter_mut().zip(&turned) {
        if turned {
            indices.swap(1, 2);
        }
    }
    for part in &mut parts {
        part.volume = part
            .triangles
            .iter()
            .map(|&n| triangle::corners(vertices, triangles[n as usize]))
            .map(|corners| triangle::volume(&corners, center))
            .sum();
        if !part.closed {
            let turned = part.triangles.iter().filter(|&&n| turned[n as usize]);
            if turned.count() * 2 > part.triangles.len() {
                flip(part, triangles);
            }
        } else if part.volume < 0.0 {
            flip(part, triangles);
        }
    }

    let open: f64 = parts.iter().filter(|p| !p.closed).map(|p| p.volume).sum();
    let cavities = nest::cavities(vertices, triangles, &parts, tolerance);
    for (part, cavity) in parts.iter_mut().zip(cavities) {
        if cavity || (!part.closed && open < 0.0) {
            flip(part, triangles);
        }
    }

    Orientation {
        components: parts.len(),
        flipped: before
            .iter()
            .zip(&*triangles)
            .filter(|(a, b)| a != b)
            .count(),
        border_edges,
        non_manifold_edges,
        closed: parts.iter().all(|part| part.closed),
    }
}

fn flip(part: &mut Part, triangles: &mut [[u32; 3]]) {
    for &n in &part.triangles {
        triangles[n as usize].swap(1, 2);
    }
    part.volume = -part.volume;
}

struct Growth {
    /// For each triangle its part.
    part: Vec<u32>,
    /// For each triangle whether it must be turned to agree with the first of its part.
    turned: Vec<bool>,
    parts: Vec<Vec<u32>>,
}

/// Spreads the winding of the first triangle of each part over the part.
fn grow(count: usize, edges: &Edges) -> Growth {
    // Each triangle has at most three neighbours over edges of two triangles; the flag says that
    // both run along the edge in the same direction, so that one of them must be turned.
    let mut neighbours = vec![[None; 3]; count];
    let mut join = |from: &EdgeUse, to: &EdgeUse| {
        let free = neighbours[from.triangle as usize]
            .iter_mut()
            .find(|slot| slot.is_none());
        if let Some(slot) = free {
            *slot = Some((to.triangle, from.ascending == to.ascending));
        }
    };
    for uses in edges.iter() {
        if let [a, b] = uses {
            join(a, b);
            join(b, a);
        }
    }
    let mut part = vec![u32::MAX; count];
    let mut turned = vec![false; count];
    let mut parts = Vec::new();
    for seed in 0..count {
        if part[seed] != u32::MAX {
            continue;
        }
        let id = parts.len() as u32;
        part[seed] = id;
        let mut members = vec![seed as u32];
        let mut done = 0;
        while let Some(&at) = members.get(done) {
            done += 1;
            for (next, same_direction) in neighbours[at as usize].into_iter().flatten() {
                if part[next as usize] == u32::MAX {
                    part[next as usize] = id;
                    turned[next as usize] = turned[at as usize] ^ same_direction;
                    members.push(next);
                }
            }
        }
        parts.push(members);
    }
    Growth {
        part,
        turned,
        parts,
    }
}

/// Counts border and non-manifold edges, and marks the parts that are open.
fn tally(edges: &Edges, part: &[u32], turned: &[bool], parts: &mut [Part]) -> (usize, usize) {
    let (mut border, mut non_manifold) = (0, 0);
    let mut directions = Vec::new();
    for uses in edges.iter() {
        directions.clear();
        directions.extend(uses.iter().map(|edge| {
            let triangle = edge.triangle as usize;
            (part[triangle], edge.ascending ^ turned[triangle])
        }));
        // Groups the uses by part; there may be as many as there are triangles.
        directions.sort_unstable();
        let mut balanced = true;
        for group in directions.chunk_by(|a, b| a.0 == b.0) {
            let ascending = group.iter().filter(|(_, ascending)| *ascending).count();
            if ascending * 2 != group.len() {
                parts[group[0].0 as usize].closed = false;
                balanced = false;
            }
        }
        match uses.len() {
            1 => border += 1,
            2 if balanced => {}
            _ => non_manifold += 1,
        }
    }
    (border, non_manifold)
}
