//! Which parts of a surface belong to one body.
//!
//! Parts that touch, cross or nest are one body; the comparison of the closed parts says which. An open part is joined
//! with the parts whose boxes its own box meets, since faces that were never stitched together have gaps between them.
//! A part of degenerate triangles alone is no body: no finger can be put on it, and it weighs nothing. It goes with the
//! first part that is one.

use nalgebra::Point3;

use super::mass::Extent;
use super::parts::Part;
use super::tree::Bounds;
use super::{Body, NamedParts, overlap, triangle};

/// Gap between an open part and the rest of its body that is bridged, over the diagonal.
const GAP: f64 = 0.01;

/// Most bodies that are described.
const MOST: usize = 100;

/// Most names of one body.
const MOST_NAMES: usize = 10;

/// For each triangle the number of its body, counted from 0 in the order of their first triangles; empty when there is
/// one body. `joined` are the pairs of closed parts that belong together.
pub(super) fn group(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    parts: &[Part],
    joined: &[[u32; 2]],
    extent: &Extent,
    tolerance: f64,
) -> Vec<u32> {
    if parts.len() < 2 {
        return Vec::new();
    }
    let mut root: Vec<u32> = (0..parts.len() as u32).collect();
    joined
        .iter()
        .for_each(|&[a, b]| overlap::join(&mut root, a, b));
    let is_degenerate = |part: &Part| {
        let mut corners = part.triangles.iter();
        corners.all(|&n| {
            let corners = triangle::corners(vertices, triangles[n as usize]);
            triangle::is_degenerate(&corners, tolerance)
        })
    };
    if let Some(first) = parts.iter().position(|part| !is_degenerate(part)) {
        for (n, _) in (0..).zip(parts).filter(|(_, part)| is_degenerate(part)) {
            overlap::join(&mut root, first as u32, n);
        }
    }
    if parts.iter().any(|part| !part.closed) {
        let bounds = |part: &Part| {
            let corners = part.triangles.iter();
            let corners =
                corners.map(|&n| Bounds::of(&triangle::corners(vertices, triangles[n as usize])));
            let bounds = corners.fold(Bounds::empty(), |all, corners| all.joined(&corners));
            bounds.inflated(GAP / 2.0 * extent.diagonal)
        };
        let boxes: Vec<Bounds> = parts.iter().map(bounds).collect();
        let Some(near) = overlap::pairs(&boxes) else {
            return Vec::new();
        };
        for [a, b] in near {
            if !parts[a as usize].closed || !parts[b as usize].closed {
                overlap::join(&mut root, a, b);
            }
        }
    }
    let mut number = vec![None; parts.len()];
    let mut count = 0;
    let mut part_of = vec![0; triangles.len()];
    for (n, part) in (0..).zip(parts) {
        part.triangles
            .iter()
            .for_each(|&at| part_of[at as usize] = n);
    }
    let body_of: Vec<u32> = part_of
        .iter()
        .map(|&part| {
            let root = overlap::find(&mut root, part) as usize;
            *number[root].get_or_insert_with(|| {
                count += 1;
                count - 1
            })
        })
        .collect();
    if count < 2 { Vec::new() } else { body_of }
}

/// Describes the bodies by their triangles; none when there is one. `source` has the number of each triangle in the file.
pub(super) fn describe(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    body_of: &[u32],
    source: &[u32],
    parts: &NamedParts,
) -> Vec<Body> {
    let mut found: Vec<Body> = Vec::new();
    let mut last_part = Vec::new();
    for ((&body, &corners), &number) in body_of.iter().zip(triangles).zip(source) {
        let body = body as usize;
        if body >= MOST {
            continue;
        }
        let Bounds { low, high } = Bounds::of(&triangle::corners(vertices, corners));
        // Bodies are numbered in the order of their first triangles.
        if body == found.len() {
            found.push(Body {
                names: Vec::new(),
                triangles: 0,
                bounds: [low, high],
            });
            last_part.push(None);
        }
        let described = &mut found[body];
        described.triangles += 1;
        described.bounds = [
            described.bounds[0].inf(&low),
            described.bounds[1].sup(&high),
        ];
        let part = parts.of(number as usize);
        // Triangles of one part follow one another, so names are compared where the part changes.
        if part != last_part[body]
            && let Some(name) = part.and_then(|part| parts.names().get(part))
            && described.names.len() < MOST_NAMES
            && !described.names.contains(name)
        {
            described.names.push(name.clone());
        }
        last_part[body] = part;
    }
    found
}
