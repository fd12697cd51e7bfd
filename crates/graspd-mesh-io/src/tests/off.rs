//! OFF files, whose lines matter little.

use graspd_core::mesh::WarningKind;

use super::*;

fn triangles(text: &str) -> RawMesh {
    read(text.as_bytes(), Some(MeshFormat::Off), &LIMITS)
        .unwrap()
        .1
}

#[test]
fn counts_may_be_glued_to_the_header_word() {
    let plain = off(&l_shape());
    let glued = plain.replace("OFF\n# made by code\n", "OFF");
    assert!(glued.starts_with("OFF12 20 0\n"), "{glued}");
    assert_eq!(good(&glued), (MeshFormat::Off, l_shape()));
    assert_eq!(triangles(&glued), l_shape());
    not_a_mesh("OFFICE 12 20 0\n0 0 0\n");
}

#[test]
fn words_count_and_not_lines() {
    let own = l_shape();
    let head = "OFF 12 20 0";
    let vertices: Vec<String> = own
        .vertices
        .iter()
        .map(|v| format!("{} {} {}", v.x, v.y, v.z))
        .collect();
    let faces: Vec<String> = own
        .triangles
        .iter()
        .map(|t| format!("3 {} {} {}", t[0], t[1], t[2]))
        .collect();
    let (a, b) = (vertices.join("\n"), faces.join("\n"));
    for text in [
        format!("{head}\n{a}\n{b}\n"),
        // Everything on one line, or every word on its own.
        format!("{head} {} {}", vertices.join(" "), faces.join(" ")),
        format!("{head}\n{a}\n{b}\n").replace(' ', "\n"),
        // Several vertices on a line, several faces on a line.
        format!("{head}\n{}\n{b}\n", vertices.join("  ")),
        format!("{head}\n{a}\n{}\n", faces.join(" ")),
        format!(
            "{head}\n{}\n{}",
            vertices.join(" "),
            faces.join(" # comment\n")
        ),
        // Colours behind positions and faces, without a word in the header.
        format!(
            "{head}\n{}\n{}\n",
            vertices.join(" 0.5 0.5 0.5 1\n"),
            faces.join(" 255 0 0\n")
        ),
        // Normals that the header announces, on the line and without lines.
        format!("N{head}\n{}\n{b}\n", a.replace('\n', " 0 0 1\n") + " 0 0 1"),
        format!(
            "N{head} {} 0 0 1 {}",
            vertices.join(" 0 0 1 "),
            faces.join(" ")
        ),
        format!(
            "# first\n\n{head}\r\n{}\r\n\r\n{}",
            a.replace('\n', "\r\n"),
            b.replace('\n', "\r\n")
        ),
    ] {
        let (_, raw) = good(&text);
        assert!(raw == own, "{text}: {:?}", raw.warnings);
    }
}

#[test]
fn what_is_left_over_is_counted_and_what_is_missing_is_named() {
    let text = off(&l_shape()).replace("  255 0 0", "");
    let raw = good(text.clone() + "3 0 1 2\n\n7\n").1;
    assert_eq!(raw.triangles.len(), 20);
    let [warning] = &raw.warnings[..] else {
        panic!("{:?}", raw.warnings);
    };
    assert!(warning.kind == WarningKind::File && warning.detail.starts_with("2 lines"));
    let short: String = text
        .lines()
        .take(20)
        .map(|line| format!("{line}\n"))
        .collect();
    let (_, what) = malformed(short);
    assert!(what.contains("ends before face 5 of 20"), "{what}");
    for (from, to, part) in [
        ("\n3 0 2 1", "\n3 0 2 12", "vertex 12"),
        ("\n3 0 2 1", "\n3 0 2 x", "`x`"),
        ("\n12 20 0", "\n12 -20 0", "`-20`"),
        ("\n3 0 2 1", "\n3 0 2", "vertex number is missing"),
        ("\n2 0 0\n", "\n2 0\n", "coordinate is missing"),
        ("\n12 20 0", "\n12", "number of faces is missing"),
        ("OFF\n", "4OFF\n", "other than three"),
        ("OFF\n", "nOFF\n", "other than three"),
        ("OFF\n", "OFF BINARY\n", "binary OFF"),
        ("\n12 20 0", "\n12 4000000000 0", "ends before face 20"),
        (
            "\n12 20 0",
            "\n18446744073709551615 18446744073709551615 0",
            "ends before",
        ),
    ] {
        assert!(text.contains(from), "{text}");
        let (_, what) = malformed(text.replacen(from, to, 1));
        assert!(what.contains(part), "{what}");
    }
}
