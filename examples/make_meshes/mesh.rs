//! A triangle mesh and what is demanded of it before it is written.

use fast_surface_nets::glam::DVec3;

/// Triangles over shared vertices, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// The figures of a mesh that passed [`Mesh::check`].
#[derive(Clone, Debug)]
pub struct Report {
    pub triangles: usize,
    pub vertices: usize,
    /// Number of holes through the body: 0 for anything a ball could be kneaded into.
    pub genus: i64,
    pub volume: f64,
    pub min: DVec3,
    pub max: DVec3,
    /// 95th over 5th percentile of the triangles' areas.
    pub area_ratio: f64,
    /// The sharpest corner of all triangles, in degrees.
    pub min_angle: f64,
}

impl Mesh {
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.vertices[v as usize])
    }

    /// Demands a closed, 2-manifold, connected surface with its normals outward, and measures it.
    pub fn check(&self) -> Result<Report, String> {
        self.check_edges()?;
        self.check_fans()?;
        let mut areas = Vec::with_capacity(self.triangles.len());
        let mut volume = 0.0;
        let mut min_angle = f64::INFINITY;
        for &triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle);
            areas.push((b - a).cross(c - a).length() / 2.0);
            volume += a.dot(b.cross(c)) / 6.0;
            for [p, q, r] in [[a, b, c], [b, c, a], [c, a, b]] {
                min_angle = (q - p).angle_between(r - p).to_degrees().min(min_angle);
            }
        }
        if volume <= 0.0 {
            return Err(format!("normals point inward: volume {volume}"));
        }
        areas.sort_by(f64::total_cmp);
        let percentile = |p: usize| areas[(areas.len() - 1) * p / 100];
        let euler = self.vertices.len() as i64 - self.triangles.len() as i64 / 2;
        Ok(Report {
            triangles: self.triangles.len(),
            vertices: self.vertices.len(),
            genus: (2 - euler) / 2,
            volume,
            min: self.vertices.iter().fold(DVec3::INFINITY, |m, &v| m.min(v)),
            max: self
                .vertices
                .iter()
                .fold(DVec3::NEG_INFINITY, |m, &v| m.max(v)),
            area_ratio: percentile(95) / percentile(5),
            min_angle,
        })
    }

    /// Each directed edge once, and its reverse once: closed, and all triangles turn the same way.
    fn check_edges(&self) -> Result<(), String> {
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(self.triangles.len() * 3);
        for &[a, b, c] in &self.triangles {
            if a == b || b == c || c == a {
                return Err(format!("a triangle names a vertex twice: {a} {b} {c}"));
            }
            edges.extend([[a, b], [b, c], [c, a]]);
        }
        edges.sort_unstable();
        if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
            let place = self.vertices[pair[0][0] as usize];
            return Err(format!("an edge at {place} is used twice in one direction"));
        }
        match edges
            .iter()
            .find(|&&[a, b]| edges.binary_search(&[b, a]).is_err())
        {
            Some(&[a, _]) => Err(format!("an edge at {} is open", self.vertices[a as usize])),
            None => Ok(()),
        }
    }

    /// One fan of triangles around each vertex, and one component: two fans meeting in a point
    /// would pass the test of the edges.
    fn check_fans(&self) -> Result<(), String> {
        let n = self.vertices.len();
        let mut spokes: Vec<Vec<(u32, u32)>> = vec![Vec::new(); n];
        for &[a, b, c] in &self.triangles {
            for [hub, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
                spokes[hub as usize].push((from, to));
            }
        }
        for (hub, fan) in spokes.iter().enumerate() {
            let Some(&(first, mut at)) = fan.first() else {
                return Err(format!("vertex {hub} belongs to no triangle"));
            };
            let mut steps = 1;
            while at != first {
                let next = fan.iter().find(|spoke| spoke.0 == at);
                at = next
                    .ok_or_else(|| format!("the fan of vertex {hub} is open"))?
                    .1;
                steps += 1;
            }
            if steps != fan.len() {
                return Err(format!("vertex {hub} joins two fans"));
            }
        }
        let mut seen = vec![false; n];
        let mut queue = vec![0];
        while let Some(v) = queue.pop() {
            if !std::mem::replace(&mut seen[v], true) {
                queue.extend(spokes[v].iter().map(|spoke| spoke.0 as usize));
            }
        }
        match seen.iter().all(|&reached| reached) {
            true => Ok(()),
            false => Err("more than one component".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        Mesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        }
    }

    #[test]
    fn a_tetrahedron_passes() {
        let report = tetrahedron().check().unwrap();
        assert_eq!((report.triangles, report.vertices, report.genus), (4, 4, 0));
        assert!((report.volume - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn open_inverted_and_double_bodies_are_refused() {
        let mut open = tetrahedron();
        open.triangles.pop();
        assert!(open.check().unwrap_err().contains("open"));

        let mut inverted = tetrahedron();
        inverted.triangles.iter_mut().for_each(|t| t.reverse());
        assert!(inverted.check().unwrap_err().contains("inward"));

        let mut double = tetrahedron();
        double.vertices.extend(tetrahedron().vertices);
        double
            .triangles
            .extend(tetrahedron().triangles.iter().map(|t| t.map(|v| v + 4)));
        assert!(double.check().unwrap_err().contains("component"));
    }
}
