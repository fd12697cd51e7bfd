//! PLY (Greg Turk's polygon file format): vertices, faces and triangle strips, every other element skipped.
//!
//! The header says what follows and in which order; there is no other way to find the end of an element than to read
//! every property of it. Faces may come before the vertices that they name.

mod header;
mod values;

use graspd_core::mesh::RawMesh;
use header::{Element, Kind, Scalar, malformed};
use values::Values;

use super::builder::Builder;
use super::text::{Lines, fields, shown};
use super::{Place, ReadError};

/// Whether the first line of a file is the word `ply`.
pub(super) fn begins(bytes: &[u8]) -> bool {
    let first = Lines::new(bytes).next();
    first.is_some_and(|(_, line)| fields(line).eq([b"ply"]))
}

/// Reads the elements `vertex`, `face` and `tristrips`; other elements and properties are skipped.
pub(super) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let header = header::parse(bytes)?;
    let mut values = Values::new(&header, bytes.len());
    for element in &header.elements {
        values.check_room(element)?;
        match element.name {
            b"vertex" => vertices(element, &mut values, &mut mesh)?,
            b"face" => faces(element, &mut values, &mut mesh)?,
            b"tristrips" => strips(element, &mut values, &mut mesh)?,
            _ => others(element, &mut values)?,
        }
    }
    mesh.finish()
}

fn vertices(
    element: &Element,
    values: &mut Values,
    mesh: &mut Builder<'_>,
) -> Result<(), ReadError> {
    let column = |name: &str| {
        element
            .properties
            .iter()
            .position(|property| property.name == name.as_bytes())
            .filter(|&column| matches!(element.properties[column].kind, Kind::Scalar(_)))
            .ok_or_else(|| {
                malformed(
                    Place::Line(element.line),
                    format!("the vertices have no property {name}; export the mesh again"),
                )
            })
    };
    let columns = [column("x")?, column("y")?, column("z")?];
    let is_single = columns.iter().any(|&column| {
        let kind = element.properties[column].kind;
        kind == Kind::Scalar(Scalar::F32) && values.is_binary()
    });
    for _ in 0..element.count {
        let mut position = [0.0; 3];
        for (column, property) in element.properties.iter().enumerate() {
            match (columns.iter().position(|&c| c == column), property.kind) {
                (Some(axis), Kind::Scalar(scalar)) => position[axis] = values.scalar(scalar)?,
                (_, kind) => values.skip(kind)?,
            }
        }
        let at = Place::Vertex(mesh.vertices());
        match is_single {
            true => mesh.single_vertex(position, at)?,
            false => mesh.vertex(position, at)?,
        };
    }
    Ok(())
}

fn faces(element: &Element, values: &mut Values, mesh: &mut Builder<'_>) -> Result<(), ReadError> {
    let mut corners = Vec::new();
    each_list(element, values, |values, length, item| {
        let at = values.place();
        corners.clear();
        for _ in 0..length {
            corners.push(index(values, item)?);
        }
        mesh.polygon(&corners, at)
    })
}

/// Reads triangle strips. Each corner makes a triangle with the two before it, every other one the other way round; a
/// negative number ends a strip and begins another.
fn strips(element: &Element, values: &mut Values, mesh: &mut Builder<'_>) -> Result<(), ReadError> {
    each_list(element, values, |values, length, item| {
        let mut last = [0; 2];
        let mut seen = 0_u64;
        for _ in 0..length {
            let at = values.place();
            let value = values.scalar(item)?;
            if value < 0.0 {
                seen = 0;
                continue;
            }
            let corner = whole(value, at)?;
            let [before, previous] = last;
            match seen {
                0 | 1 => {}
                _ if seen.is_multiple_of(2) => mesh.triangle([before, previous, corner])?,
                _ => mesh.triangle([previous, before, corner])?,
            }
            last = [previous, corner];
            seen += 1;
        }
        Ok(())
    })
}

/// Calls `each` at the list of vertex numbers of every entry of an element, with its length and the type of its items,
/// all of which it has to read; skips the other properties.
fn each_list(
    element: &Element,
    values: &mut Values,
    mut each: impl FnMut(&mut Values, u64, Scalar) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    let list = element
        .properties
        .iter()
        .position(|p| matches!(p.name, b"vertex_indices" | b"vertex_index"))
        .filter(|&column| matches!(element.properties[column].kind, Kind::List { .. }));
    if list.is_none() && element.count > 0 {
        let what = format!(
            "the element `{}` has no list vertex_indices; export the mesh again",
            shown(element.name)
        );
        return Err(malformed(Place::Line(element.line), what));
    }
    for _ in 0..element.count {
        for (column, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { count, item } if list == Some(column) => {
                    let length = values.length(count, item)?;
                    each(values, length, item)?;
                }
                kind => values.skip(kind)?,
            }
        }
    }
    Ok(())
}

/// A vertex index, whole and not negative. Whether there is such a vertex is checked at the end, because faces may
/// come before the vertices.
fn index(values: &mut Values, scalar: Scalar) -> Result<u32, ReadError> {
    let at = values.place();
    whole(values.scalar(scalar)?, at)
}

fn whole(value: f64, at: Place) -> Result<u32, ReadError> {
    if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
        Ok(value as u32)
    } else {
        Err(malformed(
            at,
            format!("{value} is not a vertex index; export the mesh again"),
        ))
    }
}

fn others(element: &Element, values: &mut Values) -> Result<(), ReadError> {
    // An element without properties takes no bytes, so the length of the file does not bound its count.
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            values.skip(property.kind)?;
        }
    }
    Ok(())
}
