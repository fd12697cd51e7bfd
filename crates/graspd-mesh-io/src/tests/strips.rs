//! Triangle strips of PLY.

use super::*;

/// Strips of two triangles, one after the other, with restarts: text, then the numbers of the list.
fn file(raw: &RawMesh, ends: [i32; 2]) -> (String, Vec<i32>) {
    let vertices: Vec<String> = raw
        .vertices
        .iter()
        .map(|v| format!("{} {} {}", v.x, v.y, v.z))
        .collect();
    let mut list = Vec::new();
    for (n, t) in raw.triangles.iter().enumerate() {
        // Where a corner is repeated, a strip turns round: a, b, c, c, b, a is a, b, c and two of no area.
        list.extend(t.map(|index| index as i32));
        list.push(ends[n % 2]);
    }
    let head = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element tristrips 1\nproperty list int int vertex_indices\nend_header\n",
        raw.vertices.len()
    );
    (head + &vertices.join("\n") + "\n", list)
}

#[test]
fn strips_restart_at_negative_numbers_in_text_and_binary() {
    let (text, list) = file(&l_shape(), [-1, -7]);
    let words: Vec<String> = list.iter().map(i32::to_string).collect();
    let (format, raw) = good(format!("{text}{} {}\n", list.len(), words.join(" ")));
    assert_eq!((format, raw), (MeshFormat::Ply, l_shape()));
    for big_endian in [false, true] {
        let endian = if big_endian { "big" } else { "little" };
        let head = &text[..text.find("end_header\n").unwrap() + "end_header\n".len()];
        let mut bytes = head
            .replace("ascii", &format!("binary_{endian}_endian"))
            .into_bytes();
        for x in l_shape().vertices.iter().flat_map(|v| [v.x, v.y, v.z]) {
            bytes.extend(if big_endian {
                x.to_be_bytes()
            } else {
                x.to_le_bytes()
            });
        }
        for number in [list.len() as i32].iter().chain(&list) {
            bytes.extend(if big_endian {
                number.to_be_bytes()
            } else {
                number.to_le_bytes()
            });
        }
        assert_eq!(good(&bytes).1, l_shape());
    }
}

#[test]
fn every_other_triangle_of_a_strip_runs_the_other_way() {
    let (text, _) = file(&cube(1.0), [-1; 2]);
    let raw = good(text.clone() + "9 0 1 2 3 4 -1 5 6 7\n").1;
    assert_eq!(raw.triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4], [5, 6, 7]]);
    for (list, part) in [
        ("3 0 1 8\n", "vertex 8"),
        ("3 0 1 1.5\n", "1.5 is not a vertex index"),
        ("30000 0 1 2\n", "does not fit"),
    ] {
        let (_, what) = malformed(text.clone() + list);
        assert!(what.contains(part), "{what}");
    }
    let cloud = ReadError::PointCloud {
        format: MeshFormat::Ply,
        points: 8,
    };
    assert_eq!(bad(text + "4 0 1 -1 2\n"), cloud);
}
