//! Writers of plain mesh files: binary STL and PLY.
//!
//! Both write a surface as it is given, in its own frame and unit. STL has single precision and no shared vertices;
//! PLY keeps double precision, and a number for each triangle, such as its index in the file that it came from.

use std::io::Write as _;

use nalgebra::{Point3, Vector3};

/// The bytes that STL leaves for a text.
const STL_HEADER: usize = 80;

/// A surface as binary STL, in single precision.
///
/// `title` fills the header, as far as its 80 bytes go. A triangle without area gets a normal of zeros. Indices must be
/// in range.
///
/// ```
/// use graspd_core::mesh::solids;
/// use graspd_mesh_io::{Limits, MeshFormat, read, write};
///
/// let cube = solids::cube(2.0);
/// let file = write::stl("a cube", &cube.vertices, &cube.triangles);
/// let (format, again) = read(&file, None, &Limits::NONE)?;
/// assert_eq!(format, MeshFormat::Stl);
/// assert_eq!(again.triangles.len(), 12);
/// # Ok::<(), graspd_mesh_io::ReadError>(())
/// ```
pub fn stl(title: &str, vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut file = Vec::with_capacity(STL_HEADER + 4 + 50 * triangles.len());
    file.extend(title.bytes().take(STL_HEADER));
    file.resize(STL_HEADER, b' ');
    file.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| vertices[corner as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
        let normal = Point3::from(normal.unwrap_or_else(Vector3::zeros));
        for point in [normal, a, b, c] {
            file.extend(point.iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
        // Attributes, which nobody agrees on.
        file.extend([0, 0]);
    }
    file
}

/// A surface as binary little-endian PLY, in double precision.
///
/// `title` becomes a comment; it should be one line. `numbers` has a number for each triangle, written as the property
/// `triangle`.
///
/// ```
/// use graspd_core::mesh::solids;
/// use graspd_mesh_io::{Limits, read, write};
///
/// let ball = solids::sphere(0.1, 8, 12);
/// let numbers: Vec<u32> = (0..ball.triangles.len() as u32).collect();
/// let file = write::ply("a ball", &ball.vertices, &ball.triangles, &numbers);
/// assert_eq!(read(&file, None, &Limits::NONE)?.1, ball);
/// # Ok::<(), graspd_mesh_io::ReadError>(())
/// ```
pub fn ply(
    title: &str,
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    numbers: &[u32],
) -> Vec<u8> {
    let mut file = Vec::with_capacity(300 + 24 * vertices.len() + 17 * triangles.len());
    let title = title.lines().next().unwrap_or_default();
    // Writing to memory cannot fail.
    let _ = write!(
        file,
        "ply\nformat binary_little_endian 1.0\ncomment {title}\n\
         element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nproperty uint triangle\nend_header\n",
        vertices.len(),
        triangles.len(),
    );
    for vertex in vertices {
        file.extend(vertex.iter().flat_map(|x| x.to_le_bytes()));
    }
    for (triangle, number) in triangles.iter().zip(numbers) {
        file.push(3);
        let values = triangle.iter().chain([number]);
        file.extend(values.flat_map(|value| value.to_le_bytes()));
    }
    file
}
