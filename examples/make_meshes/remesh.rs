//! Isotropic remeshing after Botsch & Kobbelt (2004): split what is too long, collapse what is too
//! short, flip towards six neighbours each, slide the vertices to the middle of their fans and put
//! them back on the surface. The result has triangles of nearly one size and shape, in any number
//! asked for.
//!
//! Everything runs over vectors in a fixed order, so the same field gives the same mesh.

use crate::{fabric::Fabric, mesh::Mesh, sdf::Field, surface::project};
use fast_surface_nets::glam::DVec3;

/// Rounds that look for the right edge length and take out the unevenness of the extraction.
const COARSE_ROUNDS: usize = 14;
/// Rounds after the number of triangles is settled, which only flip and slide.
const FINE_ROUNDS: usize = 30;

/// Covers the surface that `mesh` roughly follows with exactly `target` like triangles.
pub fn remesh(field: &Field, mesh: &Mesh, target: usize) -> Result<Mesh, String> {
    if !target.is_multiple_of(2) {
        return Err(format!("no closed mesh has {target} triangles: odd"));
    }
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

impl Fabric<'_> {
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

    fn flip_all(&mut self) {
        for (_, a, b) in self.edges() {
            if let Some(hinge) = self.hinge(a, b) {
                self.flip(&hinge);
            }
        }
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
