//! A closed mesh that can be rewoven edge by edge: split, collapse, flip. Each operation keeps it a
//! closed 2-manifold or refuses.

use crate::{mesh::Mesh, sdf::Field, surface::project};
use fast_surface_nets::glam::DVec3;

/// In place of the index of a vertex: this triangle is gone.
const GONE: [u32; 3] = [u32::MAX; 3];

/// Points and faces, where each point knows the faces around it.
pub struct Fabric<'a> {
    pub field: &'a Field,
    pub points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Indices of the faces around each vertex, in no particular (but a reproducible) order.
    stars: Vec<Vec<u32>>,
    /// Faces that are not [`GONE`].
    pub count: usize,
    /// The edge length aimed at.
    pub length: f64,
}

/// An edge with the faces on both sides and the corners opposite to it.
pub struct Hinge {
    a: u32,
    b: u32,
    /// The face that runs from `a` to `b`, and its third corner.
    pub left: (u32, u32),
    /// The face that runs from `b` to `a`, and its third corner.
    pub right: (u32, u32),
}

impl<'a> Fabric<'a> {
    pub fn new(field: &'a Field, mesh: &Mesh) -> Self {
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

    pub fn into_mesh(self) -> Mesh {
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

    pub fn at(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    pub fn star(&self, v: u32) -> &[u32] {
        &self.stars[v as usize]
    }

    pub fn face(&self, f: u32) -> [u32; 3] {
        self.faces[f as usize]
    }

    /// Twice the area, as a vector along the normal.
    pub fn normal(&self, face: [u32; 3]) -> DVec3 {
        let [a, b, c] = face.map(|v| self.at(v));
        (b - a).cross(c - a)
    }

    pub fn area(&self) -> f64 {
        let live = self.faces.iter().filter(|&&face| face != GONE);
        live.map(|&face| self.normal(face).length() / 2.0).sum()
    }

    /// All edges once, as (length, a, b).
    pub fn edges(&self) -> Vec<(f64, u32, u32)> {
        let mut edges = Vec::with_capacity(self.count * 3 / 2);
        for &[a, b, c] in self.faces.iter().filter(|&&face| face != GONE) {
            let sides = [(a, b), (b, c), (c, a)].into_iter().filter(|(p, q)| p < q);
            edges.extend(sides.map(|(p, q)| (self.at(p).distance(self.at(q)), p, q)));
        }
        edges
    }

    /// The edge from `a` to `b`, if there still is one.
    pub fn hinge(&self, a: u32, b: u32) -> Option<Hinge> {
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

    /// Puts a vertex in the middle of an edge: two faces become four.
    pub fn split(&mut self, hinge: &Hinge) {
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

    /// Draws an edge together to its middle: two faces go. Refused, with `false`, where that would
    /// pinch the surface, fold it or leave an edge longer than `longest`.
    pub fn collapse(&mut self, hinge: &Hinge, longest: f64) -> bool {
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

    /// Turns an edge to the other diagonal of its two faces if that brings the four corners nearer
    /// to six neighbours each, or keeps them there and makes the sharpest angle blunter.
    pub fn flip(&mut self, hinge: &Hinge) {
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
}
