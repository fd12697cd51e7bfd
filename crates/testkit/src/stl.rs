//! Mesh files.

/// An axis-aligned box around the origin as binary STL, each side split into `split`² squares.
pub fn cuboid(sides: [f32; 3], split: u32) -> Vec<u8> {
    let mut triangles: Vec<[[f32; 3]; 3]> = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-0.5, 0.5] {
            let point = |i: u32, j: u32| {
                let mut at = [0.0; 3];
                at[axis] = side * sides[axis];
                at[u] = (i as f32 / split as f32 - 0.5) * sides[u];
                at[v] = (j as f32 / split as f32 - 0.5) * sides[v];
                at
            };
            for (i, j) in (0..split).flat_map(|i| (0..split).map(move |j| (i, j))) {
                let corners = [
                    point(i, j),
                    point(i + 1, j),
                    point(i + 1, j + 1),
                    point(i, j + 1),
                ];
                let [a, b, c, d] = corners;
                if side > 0.0 {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }
    stl(&triangles)
}

/// Triangles as binary STL.
pub fn stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        for coordinate in triangle.iter().flatten() {
            bytes.extend(coordinate.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}
