//! The faces of a geometry.
//!
//! The lists of numbers `p` name, for each corner of a face, an entry of each input: a position, a normal, texture
//! coordinates. Only positions are read:
//!
//! ```text
//! p       v0 n0 t0  v1 n1 t1  v2 n2 t2  ...       stride: the greatest offset of an input, and one more
//! source  x0 y0 z0  x1 y1 z1  ...                 the accessor says where an entry begins
//! ```

use nalgebra::Point3;

use super::malformed;
use super::tree::Element;
use crate::ReadError;
use crate::instance::Shape;

/// The most numbers that one corner may have.
const MAX_STRIDE: usize = 64;

/// Reads the faces of a geometry. One without a mesh, such as a spline, has none.
pub(super) fn read(geometry: Element<'_>) -> Result<Shape, ReadError> {
    let mut shape = Shape {
        sizes: Some(Vec::new()),
        ..Shape::default()
    };
    let Some(mesh) = geometry.child("mesh") else {
        return Ok(shape);
    };
    // Most geometries have one list of positions, which several primitives share.
    let mut known: Vec<(u32, u32)> = Vec::new();
    for primitive in mesh.children() {
        let kind = primitive.name();
        if !matches!(
            kind,
            "triangles" | "polylist" | "polygons" | "trifans" | "tristrips"
        ) {
            continue;
        }
        let Some(layout) = Layout::of(primitive)? else {
            continue;
        };
        let first = match known
            .iter()
            .find(|(source, _)| *source == layout.source.index)
        {
            Some(&(_, first)) => first,
            None => {
                let first = shape.vertices.len() as u32;
                positions(layout.source, &mut shape.vertices)?;
                known.push((layout.source.index, first));
                first
            }
        };
        let mut faces = Faces {
            first,
            stop: shape.vertices.len() as u32,
            shape: &mut shape,
        };
        match kind {
            "triangles" => {
                for list in layout.lists(primitive) {
                    let corners = layout.corners(list?)?;
                    let (triangles, rest) = corners.as_chunks::<3>();
                    if !rest.is_empty() {
                        return Err(uneven(primitive));
                    }
                    triangles
                        .iter()
                        .try_for_each(|corners| faces.add(corners, primitive))?;
                }
            }
            "polylist" => {
                let mut corners = Vec::new();
                for list in layout.lists(primitive) {
                    corners.extend(layout.corners(list?)?);
                }
                let mut rest = &corners[..];
                let counts = primitive.child("vcount");
                for count in counts
                    .into_iter()
                    .flat_map(|counts| counts.values::<usize>())
                {
                    let (face, behind) = rest
                        .split_at_checked(count?)
                        .ok_or_else(|| uneven(primitive))?;
                    faces.add(face, primitive)?;
                    rest = behind;
                }
                if !rest.is_empty() {
                    return Err(uneven(primitive));
                }
            }
            "polygons" => {
                for list in layout.lists(primitive) {
                    faces.add(&layout.corners(list?)?, primitive)?;
                }
            }
            "trifans" => {
                for list in layout.lists(primitive) {
                    let corners = layout.corners(list?)?;
                    for pair in corners.get(1..).unwrap_or_default().windows(2) {
                        faces.add(&[corners[0], pair[0], pair[1]], primitive)?;
                    }
                }
            }
            _ => {
                for list in layout.lists(primitive) {
                    for (n, three) in layout.corners(list?)?.windows(3).enumerate() {
                        // Every other triangle of a strip runs the other way round.
                        let [a, b, c] = [three[0], three[1], three[2]];
                        let corners = if n % 2 == 0 { [a, b, c] } else { [b, a, c] };
                        faces.add(&corners, primitive)?;
                    }
                }
            }
        }
    }
    Ok(shape)
}

fn uneven(primitive: Element<'_>) -> ReadError {
    let what = format!(
        "the corners in <p> do not make whole faces of <{}>; send the whole file or export it again",
        primitive.name()
    );
    malformed(primitive.place(), what)
}

/// Where the positions of a primitive are.
struct Layout<'t> {
    /// The source of the positions.
    source: Element<'t>,
    /// Which number of a corner is that of its position, and how many numbers a corner has.
    offset: usize,
    stride: usize,
}

impl<'t> Layout<'t> {
    /// Returns the layout of a primitive, or `None` if it has no positions.
    fn of(primitive: Element<'t>) -> Result<Option<Self>, ReadError> {
        let mut found = None;
        let mut stride = 1;
        for input in primitive.children().filter(|child| child.name() == "input") {
            let offset = input.number("offset", 0)?;
            stride = stride.max(offset.saturating_add(1));
            if input.attribute("semantic").as_deref() == Some("VERTEX") {
                let vertices = input.target("source", "vertices")?;
                let mut inputs = vertices.children().filter(|child| child.name() == "input");
                let position =
                    inputs.find(|input| input.attribute("semantic").as_deref() == Some("POSITION"));
                let position = position.ok_or_else(|| {
                    malformed(
                        vertices.place(),
                        "the vertices have no positions; export the mesh again",
                    )
                })?;
                found = Some((position.target("source", "source")?, offset));
            }
        }
        if stride > MAX_STRIDE {
            let what =
                format!("a corner has more than {MAX_STRIDE} numbers; export the mesh again");
            return Err(malformed(primitive.place(), what));
        }
        Ok(found.map(|(source, offset)| Self {
            source,
            offset,
            stride,
        }))
    }

    /// The lists of corners of a primitive. A polygon with holes is refused.
    fn lists(
        &self,
        primitive: Element<'t>,
    ) -> impl Iterator<Item = Result<Element<'t>, ReadError>> + use<'t> {
        primitive.children().filter_map(|child| match child.name() {
            "p" => Some(Ok(child)),
            "ph" => {
                let what = "a polygon has holes, which cannot be read; cut it into triangles before export";
                Some(Err(malformed(child.place(), what)))
            }
            _ => None,
        })
    }

    /// The numbers of the positions of a list of corners.
    fn corners(&self, list: Element<'t>) -> Result<Vec<u32>, ReadError> {
        let mut corners = Vec::new();
        let mut count = 0_usize;
        for number in list.values::<u32>() {
            let number = number?;
            if count % self.stride == self.offset {
                corners.push(number);
            }
            count += 1;
        }
        match count.is_multiple_of(self.stride) {
            true => Ok(corners),
            false => Err(malformed(
                list.place(),
                format!(
                    "{count} numbers do not make whole corners of {} numbers; send the whole file or export it again",
                    self.stride
                ),
            )),
        }
    }
}

/// Appends the positions of a source.
fn positions(source: Element<'_>, vertices: &mut Vec<Point3<f64>>) -> Result<(), ReadError> {
    let wrong = |what: String| malformed(source.place(), what);
    let accessor = source
        .child("technique_common")
        .and_then(|technique| technique.child("accessor"));
    let array = match accessor {
        Some(accessor) => accessor.target("source", "float_array")?,
        None => {
            let array = source.child("float_array");
            array
                .ok_or_else(|| wrong("a source has no numbers; export the mesh again".to_owned()))?
        }
    };
    let numbers: Vec<f64> = array.values().collect::<Result<_, _>>()?;
    let default = numbers.len() / 3;
    let [offset, stride, count] = match accessor {
        Some(accessor) => [
            accessor.number("offset", 0)?,
            accessor.number("stride", 3)?,
            accessor.number("count", default)?,
        ],
        None => [0, 3, default],
    };
    let end = count.checked_sub(1).map_or(Some(0), |last| {
        last.checked_mul(stride)?
            .checked_add(offset)?
            .checked_add(3)
    });
    if stride < 3 || end.is_none_or(|end| end > numbers.len()) {
        return Err(wrong(format!(
            "{count} positions every {stride} numbers from {offset} on do not fit into {} numbers; send the whole file \
             or export it again",
            numbers.len()
        )));
    }
    let at = |n: usize| {
        let begin = offset + n * stride;
        Point3::new(numbers[begin], numbers[begin + 1], numbers[begin + 2])
    };
    vertices.extend((0..count).map(at));
    Ok(())
}

/// Adds faces to a shape.
struct Faces<'s> {
    shape: &'s mut Shape,
    /// The vertices of the source at hand: from the first to before the last.
    first: u32,
    stop: u32,
}

impl Faces<'_> {
    fn add(&mut self, corners: &[u32], primitive: Element<'_>) -> Result<(), ReadError> {
        for &corner in corners {
            let index = self
                .first
                .checked_add(corner)
                .filter(|&index| index < self.stop);
            let index = index.ok_or_else(|| {
                let what = format!(
                    "a face names vertex {corner} (counted from 0), but there are {}; export the mesh again",
                    self.stop - self.first
                );
                malformed(primitive.place(), what)
            })?;
            self.shape.corners.push(index);
        }
        if let Some(sizes) = &mut self.shape.sizes {
            sizes.push(corners.len() as u32);
        }
        Ok(())
    }
}
