//! The box: exact, so it is built directly from grids of right triangles.

use crate::mesh::Mesh;
use fast_surface_nets::glam::DVec3;

const SIZE: DVec3 = DVec3::new(1.0, 0.6, 0.4);
/// 2 (20·10 + 20·9 + 10·9) = 940 nearly square cells, two triangles each.
const CELLS: [u32; 3] = [20, 10, 9];

/// The box from the origin to [`SIZE`], 1,880 triangles.
pub fn mesh() -> Mesh {
    let [nx, ny, nz] = CELLS;
    let mut mesh = Mesh::default();
    // All points of the lattice that lie on the surface get a number, the others none.
    let mut number = vec![u32::MAX; ((nx + 1) * (ny + 1) * (nz + 1)) as usize];
    let place = |[x, y, z]: [u32; 3]| ((z * (ny + 1) + y) * (nx + 1) + x) as usize;
    for z in 0..=nz {
        for y in 0..=ny {
            for x in 0..=nx {
                let inside = |i, n| 0 < i && i < n;
                if !(inside(x, nx) && inside(y, ny) && inside(z, nz)) {
                    number[place([x, y, z])] = mesh.vertices.len() as u32;
                    let cells = DVec3::new(nx.into(), ny.into(), nz.into());
                    mesh.vertices
                        .push(DVec3::new(x.into(), y.into(), z.into()) * SIZE / cells);
                }
            }
        }
    }
    for (axis, top) in CELLS.into_iter().enumerate() {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (level, outward) in [(0, false), (top, true)] {
            for j in 0..CELLS[v] {
                for i in 0..CELLS[u] {
                    let corner = |di, dj| {
                        let mut lattice = [level; 3];
                        lattice[u] = i + di;
                        lattice[v] = j + dj;
                        number[place(lattice)]
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    mesh.triangles.extend(match outward {
                        true => [[a, b, c], [a, c, d]],
                        false => [[a, c, b], [a, d, c]],
                    });
                }
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_box_has_1880_triangles_and_its_volume() {
        let report = super::mesh().check().unwrap();
        assert_eq!((report.triangles, report.genus), (1880, 0));
        assert!((report.volume - 0.24).abs() < 1e-12);
        assert!(report.area_ratio <= 2.0);
    }
}
