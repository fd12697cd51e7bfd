//! The report of a mesh as figures for people to read.

use graspd_core::mesh::{MassSource, MeshReport};
use graspd_mesh_io::MeshFormat;

/// Every figure of the report with its name, the most wanted first.
pub fn figures(format: MeshFormat, report: &MeshReport) -> Vec<(&'static str, String)> {
    let count = |number: usize| grouped(number);
    let [low, high]: [[f64; 3]; 2] = report.bounds.map(Into::into);
    let size = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    vec![
        ("format", format.name().to_owned()),
        ("triangles", count(report.triangles)),
        ("triangles read", count(report.triangles_read)),
        ("vertices", count(report.vertices)),
        ("vertices read", count(report.vertices_read)),
        ("degenerate triangles", count(report.degenerate_triangles)),
        ("duplicate triangles", count(report.duplicate_triangles)),
        ("components", count(report.components)),
        ("bodies", count(report.body_count)),
        ("overlapping parts", count(report.overlapping_parts)),
        ("buried triangles", count(report.buried_triangles)),
        ("enclosed triangles", count(report.enclosed_triangles)),
        ("flipped triangles", count(report.flipped_triangles)),
        ("border edges", count(report.border_edges)),
        ("non-manifold edges", count(report.non_manifold_edges)),
        ("holes", count(report.holes)),
        (
            "watertight",
            if report.watertight { "yes" } else { "no" }.to_owned(),
        ),
        (
            "mass from",
            match report.mass_from {
                MassSource::Solid => "solid",
                MassSource::Capped => "solid with capped holes",
                MassSource::Union => "union of solids",
                MassSource::Surface => "surface",
            }
            .to_owned(),
        ),
        (
            "volume",
            report.volume.map_or_else(|| "-".to_owned(), number),
        ),
        (
            "volume error",
            report.volume_error.map_or_else(|| "-".to_owned(), number),
        ),
        ("area", number(report.area)),
        ("centre of mass", triple(report.center_of_mass.into())),
        ("lowest corner", triple(low)),
        ("highest corner", triple(high)),
        ("size", triple(size)),
        ("bounding radius", number(report.bounding_radius)),
        ("candidates", count(report.candidates)),
        ("area ratio", number(report.area_ratio)),
    ]
}

/// Writes a number with six significant digits.
fn number(value: f64) -> String {
    let power = value.abs().log10().floor();
    if value == 0.0 {
        "0".to_owned()
    } else if (-4.0..7.0).contains(&power) {
        let decimals = (5.0 - power).max(0.0) as usize;
        let text = format!("{value:.decimals$}");
        match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    } else {
        format!("{value:.5e}")
    }
}

fn triple(values: [f64; 3]) -> String {
    values.map(number).join(", ")
}

/// Writes a count with commas between thousands.
fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (n, digit) in digits.chars().enumerate() {
        if n > 0 && (digits.len() - n).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits_in_every_scale() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-24.5, "-24.5"),
            (15_185.682_566, "15185.7"),
            (1_234_567.8, "1234568"),
            (0.000_123_456_78, "0.000123457"),
            (1e-9, "1.00000e-9"),
            (-2.5e12, "-2.50000e12"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn thousands_are_grouped() {
        for (count, text) in [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (1_234_567, "1,234,567"),
        ] {
            assert_eq!(grouped(count), text);
        }
    }
}
