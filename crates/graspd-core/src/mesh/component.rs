//! One of several bodies of a mesh, or a named part of it, as a mesh of its own.
//!
//! The triangles that belong to it are prepared again by themselves, so that it has its own centre of mass and radius, and
//! nothing of it is buried in what was left out. They keep their numbers in the file.

use super::{Mesh, PrepareError, RawMesh};

/// What to choose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component<'a> {
    /// A body by its place in [`MeshReport::bodies`](super::MeshReport::bodies), from 0.
    Number(usize),
    /// All triangles of the parts that have this name in the file.
    Name(&'a str),
}

/// Why a component cannot be chosen.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoComponent {
    #[error("the mesh has no body {number}; its bodies are 0 to {last}")]
    NoSuchBody { number: usize, last: usize },
    #[error("no part of the mesh has the name \"{name}\"; {known}")]
    NoSuchName { name: String, known: String },
    /// By itself it is no body.
    #[error("the component cannot be used by itself: {0}")]
    Unusable(#[from] PrepareError),
}

/// Most names that a message lists.
const LISTED: usize = 20;

impl Mesh {
    /// Returns a component as a mesh of its own. O(n log n).
    ///
    /// ```
    /// use graspd_core::mesh::{Component, Mesh, solids};
    ///
    /// let far = solids::moved(&solids::cube(1.0), [5.0, 0.0, 0.0]);
    /// let mesh = Mesh::prepare(solids::join(&[solids::cube(1.0), far]))?;
    /// assert_eq!(mesh.report().body_count, 2);
    /// let second = mesh.component(Component::Number(1))?;
    /// assert_eq!(second.report().center_of_mass.x, 5.5);
    /// assert_eq!(second.candidates()[0].triangle, 12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// See [`NoComponent`].
    pub fn component(&self, which: Component<'_>) -> Result<Self, NoComponent> {
        let chosen: Vec<usize> = match which {
            Component::Number(number) => {
                let last = self.report.body_count.saturating_sub(1);
                if number > last {
                    return Err(NoComponent::NoSuchBody { number, last });
                }
                if self.body_of.is_empty() {
                    return Ok(self.clone());
                }
                let is_in = |&index: &usize| self.body_of[index] as usize == number;
                (0..self.triangles.len()).filter(is_in).collect()
            }
            Component::Name(name) => {
                let is_in = |&index: &usize| self.name_of(index) == Some(name);
                (0..self.triangles.len()).filter(is_in).collect()
            }
        };
        if let (Component::Name(name), true) = (which, chosen.is_empty()) {
            return Err(NoComponent::NoSuchName {
                name: name.to_owned(),
                known: self.known_names(),
            });
        }
        let mut mesh = Self::prepare(RawMesh {
            vertices: self.vertices.clone(),
            triangles: chosen.iter().map(|&index| self.triangles[index]).collect(),
            ..RawMesh::default()
        })?;
        let number = |index: &mut u32| *index = self.source[chosen[*index as usize]];
        mesh.source.iter_mut().for_each(number);
        mesh.report.triangles_read = self.report.triangles_read;
        mesh.named_parts = self.named_parts.clone();
        mesh.is_component = true;
        Ok(mesh)
    }

    /// The name that a triangle has in the file.
    fn name_of(&self, index: usize) -> Option<&str> {
        let part = self.named_parts.of(self.source[index] as usize)?;
        self.named_parts.names().get(part).map(String::as_str)
    }

    fn known_names(&self) -> String {
        let mut names: Vec<&str> = self
            .named_parts
            .names()
            .iter()
            .map(String::as_str)
            .collect();
        names.sort_unstable();
        names.dedup();
        match names.len() {
            0 => "the file names no parts, so choose a body by its number".to_owned(),
            count if count > LISTED => {
                format!("the first names are {}", names[..LISTED].join(", "))
            }
            _ => format!("the names are {}", names.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{NamedParts, NoCandidate, solids};

    /// Two cubes that touch, and a ball far away; the cubes have names.
    fn mesh() -> Mesh {
        let cube = solids::cube(2.0);
        let ball = solids::moved(&solids::sphere(1.0, 8, 12), [9.0, 0.0, 0.0]);
        let mut raw = solids::join(&[cube.clone(), ball, solids::moved(&cube, [2.0, 0.0, 0.0])]);
        let mut parts = NamedParts::default();
        let (left, right) = (parts.add("left".to_owned()), parts.add("right".to_owned()));
        (0..12).for_each(|n| parts.assign(n, left));
        (raw.triangles.len() - 12..raw.triangles.len()).for_each(|n| parts.assign(n, right));
        raw.parts = parts;
        Mesh::prepare(raw).unwrap()
    }

    #[test]
    fn a_component_has_mass_candidates_and_numbers_of_its_own() {
        let mesh = mesh();
        let bodies = &mesh.report().bodies;
        assert_eq!(bodies.len(), 2);
        assert_eq!(bodies[0].names, ["left", "right"]);
        assert_eq!((bodies[0].triangles, bodies[1].triangles), (24, 168));
        let both = mesh.component(Component::Number(0)).unwrap();
        let is = |volume: Option<f64>, right: f64| (volume.unwrap() / right - 1.0).abs() < 1e-12;
        assert!(is(both.report().volume, 16.0));
        assert_eq!(both.report().candidates, 20);
        let right = mesh.component(Component::Name("right")).unwrap();
        let report = right.report();
        // Nothing of it is buried once the other one is gone.
        assert!(is(report.volume, 8.0));
        assert_eq!(report.candidates, 12);
        assert!((report.center_of_mass.x - 3.0).abs() < 1e-12);
        assert!((report.bounding_radius - 3_f64.sqrt()).abs() < 1e-12);
        let first = mesh.report().triangles_read as u32 - 12;
        assert_eq!(right.source().first(), Some(&first));
        assert_eq!(right.candidate_of(first).unwrap().triangle, first);
        assert_eq!(right.candidate_of(0), Err(NoCandidate::OtherComponent(0)));
    }

    #[test]
    fn what_is_not_there_cannot_be_chosen() {
        let mesh = mesh();
        let refused = |which| mesh.component(which).unwrap_err().to_string();
        assert_eq!(
            refused(Component::Number(2)),
            "the mesh has no body 2; its bodies are 0 to 1"
        );
        assert!(refused(Component::Name("lid")).ends_with("the names are left, right"));
        let plain = Mesh::prepare(solids::cube(1.0)).unwrap();
        assert_eq!(
            plain.component(Component::Number(0)).unwrap().report(),
            plain.report()
        );
        assert!(plain.component(Component::Name("a")).is_err());
    }
}
