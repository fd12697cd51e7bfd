//! The picture of a mesh above the figures of its report, as SVG.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::text::{escape, wrap};
use super::{Background, Options, PictureError, preview};
use crate::run::{figures, mesh_report};
use crate::wire::Units;
use graspd_core::mesh::Mesh;
use graspd_mesh_io::MeshFormat;

/// Width of the sheet and of its picture, in the unit of the drawing.
const WIDTH: usize = 1024;
const MARGIN: usize = 40;
const ROW: usize = 26;

/// Draws an SVG of the [`preview`] with the figures and warnings of the mesh's report below it.
///
/// `title` may be any text, such as the name of the file. With [`Background::Transparent`] the colours follow the preference
/// of the viewer for light or dark. The cost is that of the preview.
///
/// # Errors
/// See [`preview`].
pub fn sheet(
    mesh: &Mesh,
    format: MeshFormat,
    units: Option<Units>,
    title: &str,
    options: &Options,
) -> Result<String, PictureError> {
    let background = Background::Transparent;
    let png = preview(
        mesh,
        &Options {
            background,
            ..*options
        },
    )?;
    let report = mesh_report(mesh, units);
    let figures = figures(format, &report);
    let warnings = report.warnings.iter();
    let warnings: Vec<String> = warnings.flat_map(|warning| wrap(&warning.detail)).collect();

    let rows = figures.len().div_ceil(2);
    let picture_top = 64;
    let table_top = picture_top + WIDTH / 2 + 16;
    let warnings_top = table_top + rows * ROW + 34;
    let height = match warnings.len() {
        0 => table_top + rows * ROW + MARGIN / 2,
        lines => warnings_top + lines * ROW,
    };
    let colors = options.background.style();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
         height=\"{height}\" role=\"img\" font-family=\"system-ui,sans-serif\" font-size=\"15\">\n\
         <style>{colors}\n\
         .value{{text-anchor:end;font-variant-numeric:tabular-nums;white-space:pre}}</style>\n\
         <title>{title}</title>\n\
         <rect class=\"paper\" width=\"100%\" height=\"100%\"/>\n\
         <text class=\"text\" x=\"{MARGIN}\" y=\"44\" font-size=\"22\" font-weight=\"600\">{title}</text>\n\
         <image y=\"{picture_top}\" width=\"{WIDTH}\" height=\"{}\" href=\"data:image/png;base64,{}\"/>\n",
        WIDTH / 2,
        STANDARD.encode(png),
        title = escape(title),
    );
    let column = (WIDTH - 3 * MARGIN) / 2;
    for (n, (name, value)) in figures.iter().enumerate() {
        let left = MARGIN + (n / rows) * (column + MARGIN);
        let right = left + column;
        let base = table_top + (n % rows) * ROW + 18;
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<text class=\"muted\" x=\"{left}\" y=\"{base}\">{}</text>\
             <text class=\"text value\" x=\"{right}\" y=\"{base}\">{}</text>\
             <line class=\"rule\" x1=\"{left}\" x2=\"{right}\" y1=\"{line}\" y2=\"{line}\"/>",
            escape(name),
            escape(value),
            line = base + 8,
        );
    }
    for (n, text) in warnings.iter().enumerate() {
        let base = warnings_top + n * ROW;
        let _ = writeln!(
            out,
            "<text class=\"warning\" x=\"{MARGIN}\" y=\"{base}\">{}</text>",
            escape(text)
        );
    }
    out.push_str("</svg>\n");
    Ok(out)
}
