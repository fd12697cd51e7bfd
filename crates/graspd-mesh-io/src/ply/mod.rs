//! PLY (Greg Turk's polygon file format): vertices and faces, every other element skipped.
//!
//! The header says what follows and in which order; there is no other way to find the end of an element than to read
//! every property of it. Faces may come before the vertices that they name.

mod header;
mod values;

use graspd_core::mesh::RawMesh;
use header::{Element, Kind, Scalar, malformed};
use values::Values;

use super::builder::Builder;
use super::text::{Lines, fields};
use super::{Place, ReadError};

/// Whether the first line of a file is the word `ply`.
pub(super) fn begins(bytes: &[u8]) -> bool {
    let first = Lines::new(bytes).next();
    first.is_some_and(|(_, line)| fields(line).eq([b"ply"]))
}

/// Reads the elements `vertex` and `face`; other elements and properties are skipped.
pub(super) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let header = header::parse(bytes)?;
    let mut values = Values::new(&header, bytes.len());
    for element in &header.elements {
        values.check_room(element)?;
        match element.name {
            b"vertex" => vertices(element, &mut values, &mut mesh)?,
            b"face" => faces(element, &mut values, &mut mesh)?,
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
    let list = element
        .properties
        .iter()
        .position(|p| matches!(p.name, b"vertex_indices" | b"vertex_index"))
        .filter(|&column| matches!(element.properties[column].kind, Kind::List { .. }));
    if list.is_none() && element.count > 0 {
        return Err(malformed(
            Place::Line(element.line),
            "the faces have no list vertex_indices; export the mesh again",
        ));
    }
    let mut corners = Vec::new();
    for _ in 0..element.count {
        for (column, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { count, item } if list == Some(column) => {
                    let at = values.place();
                    corners.clear();
                    for _ in 0..values.length(count, item)? {
                        corners.push(index(values, item)?);
                    }
                    mesh.polygon(&corners, at)?;
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
    let value = values.scalar(scalar)?;
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
