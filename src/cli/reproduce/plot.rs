//! Line plots as SVG.
//!
//! They are written here and not by a plotting crate: a page of formatting makes the same bytes on every machine, and needs
//! neither fonts nor a drawing backend.

use std::fmt::Write as _;

/// A curve.
pub struct Curve {
    pub name: String,
    pub points: Vec<[f64; 2]>,
}

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 400.0;
const MARGIN: [f64; 4] = [70.0, 40.0, 150.0, 50.0];
const COLORS: [&str; 6] = [
    "#1b6ca8", "#d1495b", "#7a7a7a", "#2e8b57", "#b8860b", "#6a4c93",
];

/// Plots curves over axes from zero to the greatest value.
pub fn plot(title: &str, x_label: &str, y_label: &str, curves: &[Curve]) -> String {
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let greatest = |axis: usize| all().map(|p| p[axis]).fold(f64::MIN_POSITIVE, f64::max);
    let (x_step, y_step) = (step(greatest(0)), step(greatest(1)));
    let x_end = (greatest(0) / x_step).ceil() * x_step;
    let y_end = (greatest(1) / y_step).ceil() * y_step;
    let [left, top, right, bottom] = MARGIN;
    let x = |value: f64| left + value / x_end * (WIDTH - left - right);
    let y = |value: f64| HEIGHT - bottom - value / y_end * (HEIGHT - top - bottom);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{left}\" y=\"24\" font-size=\"15\">{title}</text>\n"
    );
    for i in 0..=(x_end / x_step).round() as u32 {
        let at = f64::from(i) * x_step;
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{at}</text>",
            x(at),
            HEIGHT - bottom + 18.0
        );
    }
    for i in 0..=(y_end / y_step).round() as u32 {
        let at = f64::from(i) * y_step;
        let _ = writeln!(
            out,
            "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            WIDTH - right,
            left - 6.0,
            y(at) + 4.0,
            (at * 1e6).round() / 1e6,
            y = y(at)
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{x_label}</text>\
         <text transform=\"translate(18 {:.1}) rotate(-90)\" text-anchor=\"middle\">{y_label}</text>",
        (left + WIDTH - right) / 2.0,
        HEIGHT - 12.0,
        (top + HEIGHT - bottom) / 2.0
    );
    for (i, curve) in curves.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let points = curve.points.iter();
        let points: Vec<String> = points
            .map(|p| format!("{:.1},{:.1}", x(p[0]), y(p[1])))
            .collect();
        let _ = writeln!(
            out,
            "<polyline fill=\"none\" stroke=\"{color}\" stroke-width=\"2\" points=\"{}\"/>",
            points.join(" ")
        );
        let line = top + 14.0 + 18.0 * i as f64;
        let _ = writeln!(
            out,
            "<line x1=\"{x1:.1}\" x2=\"{x2:.1}\" y1=\"{line}\" y2=\"{line}\" stroke=\"{color}\" \
             stroke-width=\"2\"/><text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            WIDTH - right + 40.0,
            line + 4.0,
            curve.name,
            x1 = WIDTH - right + 12.0,
            x2 = WIDTH - right + 34.0
        );
    }
    out + "</svg>\n"
}

/// Returns a round step that divides an axis into four to ten parts.
fn step(greatest: f64) -> f64 {
    let power = 10_f64.powf(greatest.log10().floor());
    let steps = [0.1, 0.2, 0.5, 1.0].map(|share| share * power);
    let fits = steps.into_iter().find(|step| greatest / step <= 10.0);
    fits.unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_few_round_steps() {
        for (greatest, expected) in [
            (30.0, 5.0),
            (20.0, 2.0),
            (0.11, 0.02),
            (400.0, 50.0),
            (1.0, 0.1),
        ] {
            let found = step(greatest);
            assert!((found - expected).abs() < 1e-12, "{greatest} {found}");
        }
    }

    #[test]
    fn every_curve_is_drawn_inside_the_axes() {
        let curve = Curve {
            name: "a".to_owned(),
            points: vec![[0.0, 0.0], [10.0, 0.5]],
        };
        let svg = plot("t", "x", "y", &[curve]);
        assert!(svg.contains("points=\"70.0,350.0 490.0,40.0\""), "{svg}");
    }
}
