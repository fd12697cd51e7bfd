//! Isotropic remeshing after Botsch & Kobbelt (2004): split what is too long, collapse what is too
//! short, flip towards six neighbours each, slide the vertices to the middle of their fans and put
//! them back on the surface. The result has triangles of nearly one size and shape, in any number
//! asked for.
//!
//! Everything runs over vectors in a fixed order, so the same field gives the same mesh.

use crate::{mesh::Mesh, sdf::Field, surface::project};
use fast_surface_nets::glam::DVec3;

/// Rounds that look for the right edge length and take out the unevenness of the extraction.
const COARSE_ROUNDS: usize = 14;
/// Rounds after the number of triangles is settled, which only flip and slide.
const FINE_ROUNDS: usize = 30;

/// Covers the surface that `mesh` roughly follows with exactly `target` like triangles.
pub fn remesh(field: &Field, mesh: &Mesh, target: usize) -> Result<Mesh, String> {
    let mut fabric = Fabric::new(field, mesh);
    // An equilateral triangle of side s covers sqrt(3)/4 s².
    let mut length = (fabric.area() / target as f64 * 4.0 / 3f64.sqrt()).sqrt();
    for _ in 0..COARSE_ROUNDS {
        fabric.length = length;
        fabric.split_long();
        fabric.collapse_short();
        fabric.flip_all();
        fabric.slide();
        length *= (fabric.count as f64 / target as f64)
            .sqrt()
            .clamp(0.8, 1.25);
    }
    fabric.settle(target)?;
    for _ in 0..FINE_ROUNDS {
        fabric.flip_all();
        fabric.slide();
    }
    Ok(fabric.into_mesh())
}

/// In place of the index of a vertex: this triangle is gone.
const GONE: [u32; 3] = [u32::MAX; 3];

/// A closed mesh that can be rewoven: each vertex knows the triangles around it.
struct Fabric<'a> {
    field: &'a Field,
    points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Indices of the faces around each vertex, in no particular (but a reproducible) order.
    stars: Vec<Vec<u32>>,
    /// Faces that are not [`GONE`].
    count: usize,
    /// The edge length aimed at.
    length: f64,
}

/// An edge with the faces on both sides and the corners opposite to it.
struct Hinge {
    a: u32,
    b: u32,
    /// The face that runs from `a` to `b`, and its third corner.
    left: (u32, u32),
    /// The face that runs from `b` to `a`, and its third corner.
    right: (u32, u32),
}

impl<'a> Fabric<'a> {
    fn new(field: &'a Field, mesh: &Mesh) -> Self {
        let mut stars = vec![Vec::new(); mesh.vertices.len()];
        for (i, face) in mesh.triangles.iter().enumerate() {
            face.iter().for_each(|&v| stars[v as usize].push(i as u32));
        }
        Self {
            field,
            points: mesh.vertices.clone(),
            faces: mesh.triangles.clone(),
            stars,
            count: mesh.triangles.len(),
            length: 0.0,
        }
    }

    fn into_mesh(self) -> Mesh {
        let mut renumbered = vec![u32::MAX; self.points.len()];
        let mut mesh = Mesh::default();
        for face in self.faces.iter().filter(|&&face| face != GONE) {
            mesh.triangles.push(face.map(|v| {
                let new = &mut renumbered[v as usize];
                if *new == u32::MAX {
                    *new = mesh.vertices.len() as u32;
                    mesh.vertices.push(self.points[v as usize]);
                }
                *new
            }));
        }
        mesh
    }

    fn at(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    fn star(&self, v: u32) -> &[u32] {
        &self.stars[v as usize]
    }

    fn face(&self, f: u32) -> [u32; 3] {
        self.faces[f as usize]
    }

    /// Twice the area, as a vector along the normal.
    fn normal(&self, face: [u32; 3]) -> DVec3 {
        let [a, b, c] = face.map(|v| self.at(v));
        (b - a).cross(c - a)
    }

    fn area(&self) -> f64 {
        let live = self.faces.iter().filter(|&&face| face != GONE);
        live.map(|&face| self.normal(face).length() / 2.0).sum()
    }

    /// All edges once, as (length, a, b).
    fn edges(&self) -> Vec<(f64, u32, u32)> {
        let mut edges = Vec::with_capacity(self.count * 3 / 2);
        for &[a, b, c] in self.faces.iter().filter(|&&face| face != GONE) {
            let sides = [(a, b), (b, c), (c, a)].into_iter().filter(|(p, q)| p < q);
            edges.extend(sides.map(|(p, q)| (self.at(p).distance(self.at(q)), p, q)));
        }
        edges
    }

    /// The edge from `a` to `b`, if there still is one.
    fn hinge(&self, a: u32, b: u32) -> Option<Hinge> {
        let (mut left, mut right) = (None, None);
        for &f in self.star(a) {
            let [x, y, z] = self.face(f);
            for (from, to, opposite) in [(x, y, z), (y, z, x), (z, x, y)] {
                if (from, to) == (a, b) {
                    left = Some((f, opposite));
                } else if (from, to) == (b, a) {
                    right = Some((f, opposite));
                }
            }
        }
        Some(Hinge {
            a,
            b,
            left: left?,
            right: right?,
        })
    }

    fn are_joined(&self, a: u32, b: u32) -> bool {
        self.star(a).iter().any(|&f| self.face(f).contains(&b))
    }

    fn split_long(&mut self) {
        let limit = self.length * 4.0 / 3.0;
        let mut edges = self.edges();
        edges.retain(|edge| edge.0 > limit);
        edges.sort_by(|p, q| q.0.total_cmp(&p.0));
        for (_, a, b) in edges {
            // An earlier split may have taken the edge; what is left of it is seen next round.
            if let Some(hinge) = self.hinge(a, b) {
                self.split(&hinge);
            }
        }
    }

    /// Puts a vertex in the middle of an edge: two faces become four.
    fn split(&mut self, hinge: &Hinge) {
        let &Hinge { a, b, left, right } = hinge;
        let m = self.points.len() as u32;
        let middle = (self.at(a) + self.at(b)) / 2.0;
        self.points
            .push(project(self.field, middle, self.length / 2.0));
        self.stars.push(vec![left.0, right.0]);
        for (f, opposite) in [left, right] {
            let half = self.faces.len() as u32;
            self.faces
                .push(self.face(f).map(|v| if v == a { m } else { v }));
            self.replace(f, b, m);
            for v in [b, m, opposite] {
                self.stars[v as usize].push(half);
            }
            self.stars[b as usize].retain(|&other| other != f);
        }
        self.count += 2;
    }

    fn replace(&mut self, f: u32, old: u32, new: u32) {
        let face = &mut self.faces[f as usize];
        *face = face.map(|v| if v == old { new } else { v });
    }

    fn collapse_short(&mut self) {
        let limit = self.length * 4.0 / 5.0;
        let mut edges = self.edges();
        edges.retain(|edge| edge.0 < limit);
        edges.sort_by(|p, q| p.0.total_cmp(&q.0));
        for (_, a, b) in edges {
            if let Some(hinge) = self.hinge(a, b)
                && self.at(a).distance(self.at(b)) < limit
            {
                self.collapse(&hinge, self.length * 4.0 / 3.0);
            }
        }
    }

    /// Draws an edge together to its middle: two faces go. Refused, with `false`, where that would
    /// pinch the surface, fold it or leave an edge longer than `longest`.
    fn collapse(&mut self, hinge: &Hinge, longest: f64) -> bool {
        let &Hinge { a, b, left, right } = hinge;
        let shared = |v: &u32| *v != a && *v != b && self.are_joined(*v, b);
        let mut common: Vec<u32> = self
            .star(a)
            .iter()
            .flat_map(|&f| self.face(f))
            .filter(shared)
            .collect();
        common.sort_unstable();
        common.dedup();
        let too_few = |v: u32| self.star(v).len() <= 3;
        if common.len() != 2 || too_few(left.1) || too_few(right.1) {
            return false;
        }
        let middle = project(
            self.field,
            (self.at(a) + self.at(b)) / 2.0,
            self.length / 2.0,
        );
        for f in self.star(a).iter().chain(self.star(b)).copied() {
            let face = self.face(f);
            if f == left.0 || f == right.0 {
                continue;
            }
            let [p, q, r] = face.map(|v| if v == a || v == b { middle } else { self.at(v) });
            let after = (q - p).cross(r - p);
            let before = self.normal(face);
            let sides = [p.distance(q), q.distance(r), r.distance(p)];
            let folds = after.dot(before) < 0.7 * after.length() * before.length();
            if folds || sides.iter().any(|&side| side > longest) {
                return false;
            }
        }
        self.points[a as usize] = middle;
        for (f, opposite) in [left, right] {
            for v in [a, b, opposite] {
                self.stars[v as usize].retain(|&other| other != f);
            }
            self.faces[f as usize] = GONE;
        }
        for f in std::mem::take(&mut self.stars[b as usize]) {
            self.replace(f, b, a);
            self.stars[a as usize].push(f);
        }
        self.count -= 2;
        true
    }

    fn flip_all(&mut self) {
        for (_, a, b) in self.edges() {
            if let Some(hinge) = self.hinge(a, b) {
                self.flip(&hinge);
            }
        }
    }

    /// Turns an edge to the other diagonal of its two faces if that brings the four corners nearer
    /// to six neighbours each, or keeps them there and makes the sharpest angle blunter.
    fn flip(&mut self, hinge: &Hinge) {
        let &Hinge {
            a,
            b,
            left: (f, c),
            right: (g, d),
        } = hinge;
        let excess = |v: u32, change: i64| (self.star(v).len() as i64 + change - 6).pow(2);
        let before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
        let after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
        let old = [[a, b, c], [b, a, d]];
        let new = [[a, d, c], [d, b, c]];
        if after > before
            || self.star(a).len() <= 3
            || self.star(b).len() <= 3
            || self.are_joined(c, d)
        {
            return;
        }
        if after == before && self.bluntness(new) < self.bluntness(old) + 0.02 {
            return;
        }
        let facing = (self.normal(old[0]) + self.normal(old[1])).normalize_or_zero();
        let folds = |face| self.normal(face).dot(facing) < 0.7 * self.normal(face).length();
        if new.into_iter().any(folds) || self.bluntness(new) < 0.3 {
            return;
        }
        self.faces[f as usize] = new[0];
        self.faces[g as usize] = new[1];
        self.stars[a as usize].retain(|&face| face != g);
        self.stars[b as usize].retain(|&face| face != f);
        self.stars[c as usize].push(g);
        self.stars[d as usize].push(f);
    }

    /// The lesser shape quality of two faces: 1 for equilateral ones, 0 for slivers.
    fn bluntness(&self, faces: [[u32; 3]; 2]) -> f64 {
        let quality = |face: [u32; 3]| {
            let [a, b, c] = face.map(|v| self.at(v));
            let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
            self.normal(face).length() * 2.0 * 3f64.sqrt() / sides
        };
        quality(faces[0]).min(quality(faces[1]))
    }

    /// Moves each vertex along the surface towards the centre of mass of the faces around it. Large
    /// faces weigh more and draw it in, which evens out their areas.
    fn slide(&mut self) {
        let moved = (0..self.points.len() as u32).map(|v| {
            let p = self.at(v);
            let (mut sum, mut weight, mut normal) = (DVec3::ZERO, 0.0, DVec3::ZERO);
            for &f in self.star(v) {
                let face = self.face(f);
                let outward = self.normal(face);
                let area = outward.length();
                let [a, b, c] = face.map(|v| self.at(v));
                sum += (a + b + c) * (area / 3.0);
                weight += area;
                normal += outward;
            }
            if weight == 0.0 {
                return p;
            }
            let towards = (sum / weight - p).reject_from(normal);
            project(self.field, p + towards, self.length / 2.0)
        });
        self.points = moved.collect();
    }

    /// Reaches exactly `target` faces by the shortest collapses or the longest splits, no two of
    /// them side by side in one pass.
    fn settle(&mut self, target: usize) -> Result<(), String> {
        while self.count != target {
            let start = self.count;
            let mut touched = vec![false; self.points.len()];
            let mut edges = self.edges();
            edges.sort_by(|p, q| p.0.total_cmp(&q.0));
            if start < target {
                edges.reverse();
            }
            for (_, a, b) in edges {
                let Some(hinge) = self.hinge(a, b) else {
                    continue;
                };
                let corners = [a, b, hinge.left.1, hinge.right.1].map(|v| v as usize);
                if self.count == target || corners.iter().any(|&v| touched.get(v) != Some(&false)) {
                    continue;
                }
                if start < target {
                    self.split(&hinge);
                } else if !self.collapse(&hinge, self.length * 1.5) {
                    continue;
                }
                corners.iter().for_each(|&v| touched[v] = true);
            }
            if self.count == start {
                return Err(format!("stuck at {start} triangles on the way to {target}"));
            }
            self.flip_all();
            self.slide();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{sdf, surface::extract};

    #[test]
    fn a_ball_comes_out_closed_and_even() {
        let ball = |p| sdf::sphere(p, DVec3::ZERO, 1.0);
        let rough = extract(&ball, DVec3::splat(-1.0), DVec3::splat(1.0), 0.2);
        rough.check().unwrap();
        let even = remesh(&ball, &rough, 1000).unwrap();
        let report = even.check().unwrap();
        assert_eq!((report.triangles, report.genus), (1000, 0));
        assert!(report.area_ratio <= 2.0, "{report:?}");
        assert!(report.min_angle >= 15.0, "{report:?}");
        assert!(
            even.vertices
                .iter()
                .all(|v| (v.length() - 1.0).abs() < 1e-5)
        );
        assert_eq!(even, remesh(&ball, &rough, 1000).unwrap());
    }
}
