//! Draws triangles and strokes into samples with a depth, and samples into pixels.

use super::Background;

/// Samples along each side of a pixel, and the most pixels of a canvas with that many: at eight bytes a sample, 134 MB.
/// In a larger canvas a pixel is one sample.
const OVERSAMPLING: usize = 2;
const MAX_OVERSAMPLED: usize = 1 << 22;
/// Most samples that all triangles, and all strokes, may touch: a fixed number, which is a second of work, and a multiple
/// of those of the canvas.
const BUDGET: u64 = 1 << 27;
const LAYERS: u64 = 24;
/// Distance from an edge, in samples, within which rounding may put a sample outside both adjacent triangles.
const SLACK: f64 = 1e-6;
/// Half the width, in samples, of the lines around triangles.
const LINE: f64 = 0.75;
/// Heights of a triangle, in samples, from which these lines begin to show and show in full.
const LINE_FADE: [f64; 2] = [8.0, 32.0];
/// Height and length, in samples, of a thin triangle that may fall between the samples, so that a needle or an edge of a
/// plate would vanish.
const THIN: f64 = 1.0;
const LONG: f64 = 2.0;
/// How much darker these lines are than their triangle.
const LINE_DEPTH: f64 = 0.26;
/// Step in depth, as a share of the height, behind which the surface is darkened, so that one part of the body stands out
/// from another.
const STEP: f32 = 0.025;
/// Brightness of the darkened surface.
const STEP_LIGHT: f32 = 0.72;
/// By how many samples a stroke may lie behind the surface on which it is drawn: the surface may be slanted, and the
/// stroke is a few samples wide.
const STROKE_BIAS: f64 = 6.0;

/// Red, green, blue.
pub(super) type Color = [u8; 3];

/// Layers over the surface, in the order in which they are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Ink {
    None,
    HiddenBorder,
    HiddenNonManifold,
    Border,
    NonManifold,
    Dark,
    Light,
    AxisX,
    AxisY,
    AxisZ,
}

impl Ink {
    /// Colour and opacity.
    pub(super) fn paint(self) -> (Color, f32) {
        match self {
            Self::None => ([0; 3], 0.0),
            Self::HiddenBorder => ([255, 0, 32], 0.45),
            Self::HiddenNonManifold => ([224, 0, 255], 0.45),
            Self::Border => ([255, 0, 32], 1.0),
            Self::NonManifold => ([224, 0, 255], 1.0),
            Self::Dark => ([20, 22, 26], 1.0),
            Self::Light => ([255, 255, 255], 1.0),
            Self::AxisX => ([206, 68, 58], 1.0),
            Self::AxisY => ([62, 150, 66], 1.0),
            Self::AxisZ => ([58, 116, 214], 1.0),
        }
    }
}

/// The samples of one view. Coordinates are in samples: x to the right, y down, z towards the viewer.
#[derive(Debug)]
pub(super) struct Canvas {
    /// Samples along each side of a pixel.
    oversampling: usize,
    width: usize,
    height: usize,
    /// Depth of the surface nearest to the viewer; −∞ where there is none.
    depth: Vec<f32>,
    color: Vec<Color>,
    ink: Vec<Ink>,
    for_triangles: u64,
    for_strokes: u64,
}

impl Canvas {
    /// Creates a canvas of a number of pixels.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let oversampling = oversampling(width, height);
        let samples = (width * height * oversampling * oversampling) as u64;
        Self::within(BUDGET + LAYERS * samples, width, height)
    }

    /// Creates a canvas on which triangles and strokes may touch `budget` samples each; whatever is drawn later becomes
    /// points.
    fn within(budget: u64, width: usize, height: usize) -> Self {
        let oversampling = oversampling(width, height);
        let (width, height) = (width * oversampling, height * oversampling);
        Self {
            oversampling,
            width,
            height,
            depth: vec![f32::NEG_INFINITY; width * height],
            color: vec![[0; 3]; width * height],
            ink: vec![Ink::None; width * height],
            for_triangles: budget,
            for_strokes: budget,
        }
    }

    /// Samples along each side of a pixel.
    pub(super) fn oversampling(&self) -> usize {
        self.oversampling
    }

    /// Number of samples across and down.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Fills a triangle where nothing is nearer. `color` is called only if a sample may be in the triangle.
    pub(super) fn triangle(&mut self, corners: [[f64; 3]; 3], color: impl FnOnce() -> Color) {
        let [columns, rows] = [(0, self.width), (1, self.height)].map(|(axis, size)| {
            let along = corners.map(|corner| corner[axis]);
            let least = along.into_iter().fold(f64::INFINITY, f64::min);
            let greatest = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
            samples(least, greatest, size)
        });
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        let [a, b, c] = corners;
        let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if !twice_area.is_normal() {
            return;
        }
        let color = color();
        if self.for_triangles == 0 {
            self.point(
                [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0),
                color,
            );
            return;
        }
        let edges = [(b, c), (c, a), (a, b)].map(|(from, to)| Edge::new(from, to, twice_area));
        let longest = edges.iter().fold(0.0, |most, edge| edge.length.max(most));
        let height = twice_area.abs() / longest;
        // Turned away (down is positive), it is drawn no wider than it is: the outline belongs to the front.
        if height < THIN && longest >= LONG && twice_area < 0.0 {
            self.outline(corners, color);
        }
        let lines = ((height - LINE_FADE[0]) / (LINE_FADE[1] - LINE_FADE[0])).clamp(0.0, 1.0);
        // Of a triangle seen nearly edge-on little but rounding is left in the weights of its corners.
        let nearest = a[2].max(b[2]).max(c[2]);
        let farthest = a[2].min(b[2]).min(c[2]);
        let line_color = color.map(|part| (f64::from(part) * (1.0 - lines * LINE_DEPTH)) as u8);
        for row in rows {
            let y = row as f64 + 0.5;
            let span = edges
                .iter()
                .try_fold((f64::NEG_INFINITY, f64::INFINITY), |(left, right), edge| {
                    edge.clip(y, left, right)
                });
            let Some((left, right)) = span else { continue };
            let span = samples(left, right, self.width);
            self.for_triangles = self.for_triangles.saturating_sub(1 + span.len() as u64);
            for column in span {
                let x = column as f64 + 0.5;
                let [p, q, r] = edges.each_ref().map(|edge| edge.distance(x, y));
                let weights = [
                    p * edges[0].length,
                    q * edges[1].length,
                    r * edges[2].length,
                ];
                let z =
                    (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) / twice_area.abs();
                let on_line = lines > 0.0 && p.min(q).min(r) < LINE;
                let z = z.clamp(farthest, nearest);
                let color = if on_line { line_color } else { color };
                self.cover(row * self.width + column, z, color);
            }
        }
    }

    /// The sides of a triangle.
    fn outline(&mut self, corners: [[f64; 3]; 3], color: Color) {
        let [a, b, c] = corners;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).ceil();
            self.for_triangles = self.for_triangles.saturating_sub(steps as u64);
            for step in 0..=steps as u32 {
                let share = f64::from(step) / steps.max(1.0);
                let [x, y, z] = [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * share);
                self.point([x, y, z], color);
            }
        }
    }

    /// The sample around a point, if it is on the canvas.
    fn point(&mut self, [x, y, z]: [f64; 3], color: Color) {
        if let Some(at) = self.index(x, y) {
            self.cover(at, z, color);
        }
    }

    fn cover(&mut self, at: usize, z: f64, color: Color) {
        if z as f32 > self.depth[at] {
            self.depth[at] = z as f32;
            self.color[at] = color;
        }
    }

    /// Draws a line on the surface, `width` samples wide: in `ink` where it is visible, and half as wide in `hidden` where the
    /// surface is in front of it.
    pub(super) fn edge(&mut self, ends: [[f64; 3]; 2], width: f64, ink: Ink, hidden: Ink) {
        let thin = (width / 2.0).max(1.0);
        self.step_along(ends, width, |canvas, [x, y, z]| {
            let at = canvas.index(x, y);
            let seen = at.is_none_or(|at| z + STROKE_BIAS >= f64::from(canvas.depth[at]));
            match seen {
                true => canvas.disc([x, y], width / 2.0, |_, _| ink),
                false => canvas.disc([x, y], thin / 2.0, |_, _| hidden),
            }
        });
    }

    /// Whether the surface is in front of a point by more than the tolerance for points on the surface.
    pub(super) fn hides(&self, [x, y, z]: [f64; 3]) -> bool {
        let at = self.index(x, y);
        at.is_some_and(|at| z + STROKE_BIAS < f64::from(self.depth[at]))
    }

    /// Draws a line over everything, `width` samples wide.
    pub(super) fn stroke(&mut self, ends: [[f64; 2]; 2], width: f64, ink: Ink) {
        let ends = ends.map(|[x, y]| [x, y, 0.0]);
        self.step_along(ends, width, |canvas, [x, y, _]| {
            canvas.disc([x, y], width / 2.0, |_, _| ink)
        });
    }

    /// Calls `visit` with points so close that discs `width` wide around them make a line, the ends among them.
    fn step_along(&mut self, ends: [[f64; 3]; 2], width: f64, visit: impl Fn(&mut Self, [f64; 3])) {
        let [from, to] = ends;
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        // A length that is no number makes no step.
        let steps = (length / (width / 6.0).max(0.8)).ceil() as u32;
        for step in 0..=steps {
            if self.for_strokes == 0 && step > 0 {
                break;
            }
            let share = f64::from(step) / f64::from(steps.max(1));
            let at = [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * share);
            visit(self, at);
        }
    }

    /// Draws a disc over everything; `ink` is called with the offset from the centre.
    pub(super) fn disc(&mut self, [x, y]: [f64; 2], radius: f64, ink: impl Fn(f64, f64) -> Ink) {
        for row in samples(y - radius, y + radius, self.height) {
            let down = row as f64 + 0.5 - y;
            let reach = (radius * radius - down * down).max(0.0).sqrt();
            let span = samples(x - reach, x + reach, self.width);
            self.for_strokes = self.for_strokes.saturating_sub(1 + span.len() as u64);
            for column in span {
                let over = &mut self.ink[row * self.width + column];
                *over = ink(column as f64 + 0.5 - x, down).max(*over);
            }
        }
    }

    /// The index of the sample around a point, if there is one.
    fn index(&self, x: f64, y: f64) -> Option<usize> {
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then(|| y as usize * self.width + x as usize)
    }

    /// Mixes the samples of each pixel and writes it, red, green, blue and opacity, into the picture
    /// `pixels`, which is `stride` pixels wide, from column `left` on.
    pub(super) fn resolve(
        &self,
        background: Background,
        pixels: &mut [u8],
        left: usize,
        stride: usize,
    ) {
        let oversampling = self.oversampling;
        let behind = match background {
            Background::Light => [255.0, 255.0, 255.0, 1.0],
            Background::Dark => [22.0, 24.0, 28.0, 1.0],
            Background::Transparent => [0.0; 4],
        };
        let (columns, rows) = (
            self.width / self.oversampling,
            self.height / self.oversampling,
        );
        for row in 0..rows {
            let start = 4 * (row * stride + left);
            let line = pixels[start..start + 4 * columns].chunks_exact_mut(4);
            for (column, pixel) in line.enumerate() {
                // Colours are weighted by their opacity while they are mixed.
                let mut sum = [0.0_f32; 4];
                for sample in 0..oversampling * oversampling {
                    let x = column * oversampling + sample % oversampling;
                    let y = row * oversampling + sample / oversampling;
                    let seen = self.seen(y * self.width + x, behind);
                    sum = [0, 1, 2, 3].map(|part| sum[part] + seen[part]);
                }
                let [red, green, blue, opacity] = sum;
                if opacity > 0.0 {
                    let all = (oversampling * oversampling) as f32;
                    let parts = [red, green, blue].map(|part| part / opacity);
                    let [red, green, blue] = parts.map(|part| part.round() as u8);
                    let opacity = (opacity / all * 255.0).round() as u8;
                    pixel.copy_from_slice(&[red, green, blue, opacity]);
                }
            }
        }
    }

    /// The colour of a sample: red, green and blue multiplied by opacity, and opacity.
    fn seen(&self, at: usize, behind: [f32; 4]) -> [f32; 4] {
        let under = match self.depth[at] {
            f32::NEG_INFINITY => behind,
            _ if self.is_behind_a_step(at) => {
                opaque(self.color[at].map(|part| (f32::from(part) * STEP_LIGHT) as u8))
            }
            _ => opaque(self.color[at]),
        };
        let (color, opacity) = self.ink[at].paint();
        let over = opaque(color);
        [0, 1, 2, 3].map(|part| over[part] * opacity + under[part] * (1.0 - opacity))
    }

    /// Whether the surface in a neighbouring sample is much nearer.
    fn is_behind_a_step(&self, at: usize) -> bool {
        let limit = self.depth[at] + STEP * self.height as f32;
        let beside = [
            at.wrapping_sub(1),
            at + 1,
            at.wrapping_sub(self.width),
            at + self.width,
        ];
        let mut beside = beside.into_iter().filter_map(|at| self.depth.get(at));
        beside.any(|depth| *depth > limit)
    }
}

fn oversampling(width: usize, height: usize) -> usize {
    match width * height <= MAX_OVERSAMPLED {
        true => OVERSAMPLING,
        false => 1,
    }
}

fn opaque([red, green, blue]: Color) -> [f32; 4] {
    [red.into(), green.into(), blue.into(), 1.0]
}

/// The samples, of `size` in all, whose centres are between two coordinates.
fn samples(least: f64, greatest: f64, size: usize) -> std::ops::Range<usize> {
    let bound = |at: f64| at.clamp(0.0, size as f64) as usize;
    bound((least - 0.5).ceil())..bound((greatest - 0.5).floor() + 1.0)
}

/// The line through two corners of a triangle, with the triangle on its positive side.
struct Edge {
    /// Unit normal into the triangle.
    normal: [f64; 2],
    offset: f64,
    length: f64,
}

impl Edge {
    fn new(from: [f64; 3], to: [f64; 3], twice_area: f64) -> Self {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        let side = twice_area.signum() / length.max(f64::MIN_POSITIVE);
        let normal = [-along[1] * side, along[0] * side];
        Self {
            normal,
            offset: -(normal[0] * from[0] + normal[1] * from[1]),
            length,
        }
    }

    /// The signed distance of a point from the line, positive inside.
    fn distance(&self, x: f64, y: f64) -> f64 {
        self.normal[0] * x + self.normal[1] * y + self.offset
    }

    /// The part of a row from `left` to `right` that is inside.
    fn clip(&self, y: f64, left: f64, right: f64) -> Option<(f64, f64)> {
        let rest = self.normal[1] * y + self.offset + SLACK;
        let (left, right) = match self.normal[0] {
            slope if slope > 0.0 => (left.max(-rest / slope), right),
            slope if slope < 0.0 => (left, right.min(-rest / slope)),
            _ if rest >= 0.0 => (left, right),
            _ => return None,
        };
        (left <= right).then_some((left, right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]];

    /// How many pixels of a picture 40 wide and 40 high have this colour.
    fn count(canvas: &Canvas, color: Color) -> usize {
        let mut pixels = vec![0; 4 * 40 * 40];
        canvas.resolve(Background::Light, &mut pixels, 0, 40);
        pixels
            .chunks_exact(4)
            .filter(|pixel| pixel[..3] == color)
            .count()
    }

    #[test]
    fn the_nearer_triangle_is_seen_in_whatever_order() {
        let (near, far) = ([0, 0, 200], [200, 0, 0]);
        let behind = WALL.map(|[x, y, z]| [x, y, z - 1.0]);
        for swapped in [false, true] {
            let mut canvas = Canvas::new(40, 40);
            let mut both = [(WALL, near), (behind, far)];
            if swapped {
                both.reverse();
            }
            for (corners, color) in both {
                canvas.triangle(corners, || color);
            }
            assert!(count(&canvas, near) > 100);
            assert_eq!(count(&canvas, far), 0);
        }
    }

    #[test]
    fn triangles_and_strokes_beyond_the_budget_are_points() {
        let mut canvas = Canvas::within(2000, 40, 40);
        let (first, second) = ([0, 0, 200], [200, 0, 0]);
        canvas.triangle(WALL, || first);
        let before = count(&canvas, first);
        canvas.triangle(WALL.map(|[x, y, z]| [x, y, z + 1.0]), || second);
        let point = canvas.index(100.0 / 3.0, 100.0 / 3.0).unwrap();
        assert_eq!(canvas.color[point], second);
        // The pixel that contains the point is now a mixture.
        assert_eq!(count(&canvas, first), before - 1);

        for row in 0..80 {
            canvas.stroke(
                [[0.0, f64::from(row)], [80.0, f64::from(row)]],
                2.0,
                Ink::Dark,
            );
        }
        assert!(canvas.ink[0] == Ink::Dark && canvas.ink[79 * 80 + 79] == Ink::None);
    }

    #[test]
    fn shapes_outside_the_canvas_draw_nothing() {
        let mut canvas = Canvas::new(40, 40);
        for [x, y] in [[-300.0, 0.0], [300.0, 0.0], [0.0, -300.0], [0.0, 300.0]] {
            canvas.triangle(WALL.map(|[a, b, z]| [a + x, b + y, z]), || [0; 3]);
            canvas.edge([[x, y, 0.0], [x + 9.0, y, 0.0]], 3.0, Ink::Dark, Ink::Light);
        }
        assert_eq!(count(&canvas, [255; 3]), 40 * 40);
    }
}
