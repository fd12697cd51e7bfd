//! The three formats the examples come in.

use crate::mesh::Mesh;
use std::fmt::Write;

/// Binary STL: 80 bytes of title, the count, 50 bytes a triangle with its own copies of the corners.
pub fn stl(mesh: &Mesh, title: &str) -> Vec<u8> {
    // A title that begins with "solid" would pass for ASCII STL with some readers.
    assert!(title.len() <= 80 && !title.starts_with("solid"));
    let mut bytes = title.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for &triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize();
        for vector in [normal, a, b, c] {
            bytes.extend(
                vector
                    .as_vec3()
                    .to_array()
                    .into_iter()
                    .flat_map(f32::to_le_bytes),
            );
        }
        bytes.extend([0, 0]);
    }
    bytes
}

/// OBJ text with `decimals` digits after the point.
pub fn obj(mesh: &Mesh, title: &str, decimals: usize) -> Vec<u8> {
    let mut text = format!("# {title}\n");
    for v in &mesh.vertices {
        writeln!(
            text,
            "v {:.decimals$} {:.decimals$} {:.decimals$}",
            v.x, v.y, v.z
        )
        .expect("a String takes all");
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
        writeln!(text, "f {a} {b} {c}").expect("a String takes all");
    }
    text.into_bytes()
}

/// PLY, binary little-endian, float32 coordinates.
pub fn ply(mesh: &Mesh, title: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {title}\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len(),
    )
    .into_bytes();
    for v in &mesh.vertices {
        bytes.extend(
            v.as_vec3()
                .to_array()
                .into_iter()
                .flat_map(f32::to_le_bytes),
        );
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cuboid;

    #[test]
    fn sizes_and_counts_are_those_of_the_formats() {
        let mesh = cuboid::mesh();
        let (v, t) = (mesh.vertices.len(), mesh.triangles.len());

        let stl = stl(&mesh, "box");
        assert_eq!(stl.len(), 84 + 50 * t);
        assert_eq!(stl[80..84], (t as u32).to_le_bytes());

        let obj = String::from_utf8(obj(&mesh, "box", 3)).unwrap();
        assert_eq!(obj.lines().filter(|line| line.starts_with("v ")).count(), v);
        assert_eq!(obj.lines().filter(|line| line.starts_with("f ")).count(), t);

        let ply = ply(&mesh, "box");
        let header = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        assert_eq!(ply.len(), header + 12 * v + 13 * t);
    }
}
