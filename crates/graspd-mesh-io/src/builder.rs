//! What every reader fills: the triangles of a file, checked as they come.
//!
//! A reader knows its format, and the builder what holds of all of them: coordinates are finite and not absurd, indices
//! are in range, limits hold, polygons are cut, and the work can be interrupted. Limits are enforced while reading, since
//! counts in headers may be anything.
//!
//! Polygons are put down as fans at once and cut anew at the end where a fan does not cover them, when all vertices are
//! known. Such a cut has as many triangles as the fan, so it takes its place and nothing moves.

use nalgebra::Point3;

use graspd_core::Interrupt;
use graspd_core::mesh::{MAX_COORDINATE, MeshWarning, RawMesh, WarningKind};

use super::part_names::PartNames;
use super::precision::SinglePrecision;
use super::{MeshFormat, Place, ReadError, polygon};

/// What a file may hold at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// The most triangles, after polygons are cut.
    pub triangles: usize,
    /// The most vertices. STL, which repeats each vertex in every triangle, is bounded by `triangles` alone.
    pub vertices: usize,
    /// The most bytes that vertices and triangles may take in memory while they are read; preparing them takes about
    /// twice as much.
    pub memory: usize,
}

impl Limits {
    /// No limits but that of 32-bit indices.
    pub const NONE: Self = Self {
        triangles: u32::MAX as usize,
        vertices: u32::MAX as usize,
        memory: usize::MAX,
    };
}

/// Vertices and triangles added between two checks of the interrupt.
const PACE: usize = 4096;

/// Collects vertices and triangles within limits.
pub(super) struct Builder<'a> {
    format: MeshFormat,
    limits: Limits,
    raw: RawMesh,
    /// The polygons of more than three corners among the triangles.
    polygons: Vec<Polygon>,
    names: PartNames,
    single: SinglePrecision,
    interrupt: Interrupt<'a>,
}

/// A polygon, for now cut as a fan about its first corner.
struct Polygon {
    /// The first of its triangles, which follow one another.
    triangle: usize,
    corners: usize,
    at: Place,
}

impl<'a> Builder<'a> {
    /// An empty mesh, for a file of this format.
    pub(super) fn new(format: MeshFormat, limits: &Limits, interrupt: Interrupt<'a>) -> Self {
        let most = u32::MAX as usize;
        Self {
            format,
            limits: Limits {
                triangles: limits.triangles.min(most),
                // STL repeats each vertex, so that the triangles bound them.
                vertices: match format {
                    MeshFormat::Stl => most,
                    _ => limits.vertices.min(most),
                },
                memory: limits.memory,
            },
            raw: RawMesh::default(),
            polygons: Vec::new(),
            names: PartNames::default(),
            single: SinglePrecision::default(),
            interrupt,
        }
    }

    /// Fails when there are `count` of something and `limit` forbids one more, and when reading is to stop.
    fn check(&mut self, what: &'static str, count: usize, limit: usize) -> Result<(), ReadError> {
        if count >= limit {
            return Err(ReadError::TooLarge { what, limit });
        }
        if !count.is_multiple_of(PACE) {
            return Ok(());
        }
        let RawMesh {
            vertices,
            triangles,
            ..
        } = &self.raw;
        let bytes = vertices.len() * size_of::<Point3<f64>>()
            + triangles.len() * size_of::<[u32; 3]>()
            + self.names.memory()
            + self.polygons.len() * size_of::<Polygon>();
        self.check_memory(count, bytes)
    }

    /// Fails when a reader keeps more `bytes` than are accepted for vertices and triangles, and when reading is to stop,
    /// which is checked at one of a few thousand values of `count`.
    pub(super) fn check_memory(&self, count: usize, bytes: usize) -> Result<(), ReadError> {
        if bytes > self.limits.memory {
            return Err(ReadError::TooLarge {
                what: "bytes of vertices and triangles",
                limit: self.limits.memory,
            });
        }
        self.check_interrupt(count)
    }

    /// Fails when reading is to stop, which is checked at one of a few thousand values of `count`.
    pub(super) fn check_interrupt(&self, count: usize) -> Result<(), ReadError> {
        match count.is_multiple_of(PACE) {
            true => Ok(self.interrupt.check()?),
            false => Ok(()),
        }
    }

    /// The error for something wrong in the file.
    pub(super) fn malformed(&self, at: Place, what: impl Into<String>) -> ReadError {
        ReadError::Malformed {
            format: self.format,
            at,
            what: what.into(),
        }
    }

    /// Reserves room for as many vertices and triangles as the bytes of the file are known to hold.
    pub(super) fn reserve(&mut self, vertices: usize, triangles: usize) {
        let Limits {
            vertices: v,
            triangles: t,
            memory,
        } = self.limits;
        let fitting = memory / size_of::<Point3<f64>>();
        self.raw
            .vertices
            .reserve_exact(vertices.min(v).min(fitting));
        self.raw
            .triangles
            .reserve_exact(triangles.min(t).min(fitting));
    }

    /// Vertices so far.
    pub(super) fn vertices(&self) -> usize {
        self.raw.vertices.len()
    }

    /// Triangles so far.
    pub(super) fn triangles(&self) -> usize {
        self.raw.triangles.len()
    }

    /// Adds a vertex and returns its index; `at` is where it stands in the file.
    pub(super) fn vertex(&mut self, position: [f64; 3], at: Place) -> Result<u32, ReadError> {
        for (axis, x) in ["x", "y", "z"].into_iter().zip(position) {
            if !x.is_finite() {
                return Err(self.malformed(
                    at,
                    format!("{axis} is {x}, not a finite number; repair or export the mesh again"),
                ));
            }
            if x.abs() > MAX_COORDINATE {
                return Err(self.malformed(
                    at,
                    format!("{axis} is {x:e}, beyond the greatest coordinate accepted, {MAX_COORDINATE:e}; check the unit or export the mesh again"),
                ));
            }
        }
        let index = self.raw.vertices.len();
        self.check("vertices", index, self.limits.vertices)?;
        self.raw.vertices.push(Point3::from(position));
        Ok(index as u32)
    }

    /// Adds a vertex that the file has in single precision.
    pub(super) fn single_vertex(
        &mut self,
        position: [f64; 3],
        at: Place,
    ) -> Result<u32, ReadError> {
        self.note_single(position);
        self.vertex(position, at)
    }

    /// Takes into account that the file has a position in single precision, before any transform.
    pub(super) fn note_single(&mut self, position: [f64; 3]) {
        self.single.add(position);
    }

    /// Adds a triangle whose indices are checked at the end.
    pub(super) fn triangle(&mut self, corners: [u32; 3]) -> Result<(), ReadError> {
        let count = self.raw.triangles.len();
        self.check("triangles", count, self.limits.triangles)?;
        self.raw.triangles.push(corners);
        if let Some(part) = self.names.current(&mut self.raw.parts) {
            self.raw.parts.assign(count, part);
        }
        Ok(())
    }

    /// Lets the triangles that follow belong to the part with this name, which may have begun earlier; to none where the
    /// name is empty.
    pub(super) fn continue_part(&mut self, name: &[u8]) {
        self.names.resume(name);
    }

    /// Lets the triangles that follow belong to a part of their own. It gets a number where its name is taken, and is no
    /// part where the name is empty.
    pub(super) fn begin_part(&mut self, name: &[u8]) {
        self.names.begin(name);
    }

    /// Adds a warning to the report on the mesh.
    pub(super) fn warn(&mut self, kind: WarningKind, detail: String) {
        self.raw.warnings.push(MeshWarning { kind, detail });
    }

    /// Adds a polygon, for now as a fan.
    pub(super) fn polygon(&mut self, corners: &[u32], at: Place) -> Result<(), ReadError> {
        let [first, rest @ ..] = corners else {
            return Err(
                self.malformed(at, "a face is without corners; a face needs at least three")
            );
        };
        if rest.len() < 2 {
            return Err(self.malformed(
                at,
                format!(
                    "a face has {} corners; a face needs at least three",
                    corners.len()
                ),
            ));
        }
        if rest.len() > 2 {
            self.polygons.push(Polygon {
                triangle: self.triangles(),
                corners: corners.len(),
                at,
            });
        }
        rest.windows(2)
            .try_for_each(|pair| self.triangle([*first, pair[0], pair[1]]))
    }

    /// Cuts the polygons anew that a fan does not cover.
    fn cut_polygons(&mut self) -> Result<(), ReadError> {
        let mut work = 0;
        for (n, polygon) in std::mem::take(&mut self.polygons).into_iter().enumerate() {
            if n.is_multiple_of(PACE) || polygon.corners > PACE {
                self.interrupt.check()?;
            }
            let last = polygon.triangle + polygon.corners - 2;
            let fan = &self.raw.triangles[polygon.triangle..last];
            let first = fan.iter().take(1).flat_map(|&[a, b, _]| [a, b]);
            let corners: Vec<u32> = first.chain(fan.iter().map(|&[_, _, c]| c)).collect();
            let places = corners
                .iter()
                .map(|&index| self.raw.vertices[index as usize]);
            let cut = polygon::cut(&places.collect::<Vec<_>>(), &mut work);
            if work > polygon::MAX_WORK {
                return Err(self.malformed(
                    polygon.at,
                    format!(
                        "faces that are not convex, such as the one of {} corners here, are too much work to cut; \
                         cut them into triangles before export",
                        polygon.corners
                    ),
                ));
            }
            if let Some(cut) = cut {
                let cut = cut
                    .iter()
                    .map(|triangle| triangle.map(|i| corners[i as usize]));
                self.raw.triangles.splice(polygon.triangle..last, cut);
            }
        }
        Ok(())
    }

    /// Returns the finished mesh. Fails on an index out of range, and when there is no triangle.
    pub(super) fn finish(mut self) -> Result<RawMesh, ReadError> {
        if self.raw.triangles.is_empty() {
            return Err(match self.raw.vertices.len() {
                0 => ReadError::NoTriangles,
                points => ReadError::PointCloud {
                    format: self.format,
                    points,
                },
            });
        }
        let count = self.raw.vertices.len();
        for (n, corners) in self.raw.triangles.iter().enumerate() {
            if let Some(index) = corners.iter().find(|&&index| index as usize >= count) {
                return Err(self.malformed(
                    Place::Triangle(n),
                    format!("it names vertex {index} (counted from 0), but the file has {count} vertices; export the mesh again"),
                ));
            }
        }
        self.cut_polygons()?;
        if let Some(detail) = self.single.doubt() {
            self.warn(WarningKind::Precision, detail);
        }
        Ok(self.raw)
    }
}
