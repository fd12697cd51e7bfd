//! What the readers and the preparation promise of any bytes.

use std::io::{Cursor, Write};

use graspd_core::Interrupt;
use graspd_core::mesh::{Mesh, RawMesh};
use graspd_mesh_io::{Limits, MeshFormat, read};
use nalgebra::Point3;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Little, so that a mesh which outgrows it is soon made.
const LIMITS: Limits = Limits {
    triangles: 20_000,
    vertices: 20_000,
    ..Limits::NONE
};

/// Reads bytes as what they look like and as a format; what comes out keeps its limits, and is prepared.
pub fn check_reader(bytes: &[u8], format: MeshFormat) {
    for said in [Some(format), None] {
        match read(bytes, said, &LIMITS) {
            Ok((found, raw)) => {
                assert!(said.is_none_or(|said| said == found));
                assert!(!raw.triangles.is_empty() && raw.triangles.len() <= LIMITS.triangles);
                let count = raw.vertices.len();
                assert!(
                    raw.triangles
                        .iter()
                        .flatten()
                        .all(|&index| (index as usize) < count)
                );
                assert!(raw.vertices.iter().all(|v| v.iter().all(|x| x.is_finite())));
                check_preparation(raw);
            }
            Err(fault) => assert!(fault.to_string().len() < 1000, "{fault}"),
        }
    }
}

/// Reads bytes as a 3MF file, and as the model in one: a fuzzer does not find the checksum of an archive.
pub fn check_3mf(bytes: &[u8]) {
    check_reader(bytes, MeshFormat::ThreeMf);
    check_reader(&archive(bytes), MeshFormat::ThreeMf);
}

/// A zip archive with a model of that text.
fn archive(model: &[u8]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let begun = writer.start_file("3D/3dmodel.model", SimpleFileOptions::default());
    begun
        .and_then(|()| Ok(writer.write_all(model)?))
        .and_then(|()| writer.finish())
        .expect("memory takes any bytes")
        .into_inner()
}

/// Triangles between points that the bytes give: a byte for how, then three bytes a point, three a triangle.
pub fn decode(bytes: &[u8]) -> RawMesh {
    let (how, rest) = bytes.split_first().unwrap_or((&0, &[]));
    let step = [1.0, 1e-7, 1e-38, 1e28, 1.0 / 3.0, 1e6][usize::from(how % 6)];
    let offset = [0.0, 1e6, -3.0, 0.1][usize::from(how / 6 % 4)];
    let count = (rest.len() / 6).max(1);
    let (points, corners) = rest.split_at((3 * count).min(rest.len()));
    let at = |p: &[u8]| {
        let [x, y, z] = [p[0], p[1], p[2]].map(|x| f64::from(x as i8) * step + offset);
        Point3::new(x, y, z)
    };
    let corner = |&c: &u8| u32::from(c);
    RawMesh {
        vertices: points.chunks_exact(3).map(at).collect(),
        triangles: corners
            .chunks_exact(3)
            .map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])])
            .collect(),
        ..RawMesh::default()
    }
}

/// Prepares triangles; a body that comes out has numbers, normals and candidates of both kinds.
pub fn check_preparation(raw: RawMesh) {
    let read = raw.triangles.len();
    let Ok(mesh) = Mesh::prepare(raw) else {
        return;
    };
    let report = mesh.report();
    assert!(report.bounding_radius > 0.0 && report.bounding_radius.is_finite());
    assert!(report.center_of_mass.iter().all(|x| x.is_finite()));
    assert!(report.volume.is_none_or(|volume| volume > 0.0));
    assert!(report.area_ratio >= 1.0 && report.area > 0.0);
    assert!(mesh.source().is_sorted() && mesh.source().iter().all(|&n| (n as usize) < read));
    let candidates = mesh.candidates();
    assert_eq!(candidates.len(), report.candidates);
    let spread = mesh.uniform_candidates(50, 1, Interrupt::never());
    let spread = spread.expect("nothing interrupts it");
    assert_eq!(spread.len(), 50);
    for candidate in candidates.iter().chain(&spread) {
        assert!((candidate.normal.norm() - 1.0).abs() < 1e-9);
        assert!(candidate.position.iter().all(|x| x.is_finite()));
    }
}
