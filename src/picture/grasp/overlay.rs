//! Arrows, cones and the weakest wrench over the surface of one view.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use nalgebra::{Point3, Unit, Vector3};

use crate::picture::canvas::Canvas;
use crate::picture::colors::hex;
use crate::picture::marks::{ARROW, BENT, CONE, NEGLIGIBLE, WEAKEST, cone, perpendicular};
use crate::picture::view::View;
use crate::picture::{CONTACT_COLORS, FORCE, TORQUE};
use crate::wire::{ChosenGrasp, PlanResult};
use graspd_core::plan::ContactKind;

/// Radius of the ring that marks a soft finger, in radii of the body.
const SOFT: f64 = 0.06;
/// Number of pieces of a line, each of which is visible or hidden.
const PIECES: usize = 40;
/// Number of corners of a circle.
const CORNERS: usize = 40;
/// Opacity of marks that the body hides, and of the weakest wrench, which is inside it.
const HIDDEN: f64 = 0.28;
const WITHIN: f64 = 0.6;
/// Width of a shaft and of a thin line, and radius of the disc of a number, in the unit of the drawing.
const SHAFT: f64 = 3.4;
const THIN: f64 = 1.2;
const DISC: f64 = 9.5;

/// The starts of the arrows, which must be in the picture together with the body.
pub(super) fn tails(grasp: &ChosenGrasp<'_>, radius: f64) -> impl Iterator<Item = Point3<f64>> {
    grasp.contacts.iter().map(move |contact| {
        Point3::from(contact.position) - Vector3::from(contact.normal) * ((ARROW + 0.04) * radius)
    })
}

/// Marks over one view.
pub(super) struct Overlay<'a> {
    view: &'a View,
    canvas: &'a Canvas,
    /// Length of a sample in the unit of the drawing.
    unit: f64,
    left: f64,
    /// Factor of all widths.
    size: f64,
}

impl<'a> Overlay<'a> {
    /// `unit` is the length of a pixel in the drawing, and `left` the left edge of the view.
    pub fn new(view: &'a View, canvas: &'a Canvas, unit: f64, left: f64, size: f64) -> Self {
        Self {
            view,
            canvas,
            unit: unit / canvas.oversampling() as f64,
            left,
            size,
        }
    }

    /// Returns all marks of a grasp as SVG, the farthest finger first.
    pub fn draw(
        &self,
        result: &PlanResult,
        grasp: &ChosenGrasp<'_>,
        radius: f64,
        numbers: bool,
    ) -> String {
        let mut out = String::new();
        let center = Point3::from(result.center_of_mass);
        self.center(&mut out, &center);
        if let Some(weakest) = grasp.weakest {
            let (force, torque) = (Vector3::from(weakest.force), Vector3::from(weakest.torque));
            if force.norm() > NEGLIGIBLE {
                let tip = center + force * (WEAKEST * radius);
                self.arrow(&mut out, &[center, tip], &hex(FORCE), WITHIN);
            }
            if let Some(axis) = Unit::try_new(torque, NEGLIGIBLE) {
                let bent: Vec<_> = circle(&center, &axis, BENT * radius, 0.75).collect();
                self.arrow(&mut out, &bent, &hex(TORQUE), WITHIN);
            }
        }
        let mut order: Vec<usize> = (0..grasp.contacts.len()).collect();
        let depth = |&index: &usize| self.view.project(&grasp.contacts[index].position.into())[2];
        order.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        for index in order {
            let contact = &grasp.contacts[index];
            let color = hex(CONTACT_COLORS[index % CONTACT_COLORS.len()]);
            let at = Point3::from(contact.position);
            let inward = Unit::new_normalize(Vector3::from(contact.normal));
            let friction = result.friction.filter(|friction| *friction > 0.0);
            if let Some(friction) = friction {
                self.cone(&mut out, &at, &-inward, friction, CONE * radius, &color);
            }
            if result.contact_model == ContactKind::Soft {
                let ring: Vec<_> = circle(&at, &inward, SOFT * radius, 1.0).collect();
                self.line(&mut out, &ring, &color, 1.6 * THIN, HIDDEN);
            }
            let tail = at - inward.into_inner() * (ARROW * radius);
            self.arrow(&mut out, &[tail, at], &color, HIDDEN);
            self.dot(&mut out, &at, &color);
            if numbers {
                self.number(&mut out, &tail, index + 1, contact.fixed, &color);
            }
        }
        out
    }

    /// The position of a point in the drawing.
    fn place(&self, point: &Point3<f64>) -> [f64; 2] {
        let [x, y, _] = self.view.project(point);
        [self.left + x * self.unit, y * self.unit]
    }

    fn is_hidden(&self, point: &Point3<f64>) -> bool {
        self.canvas.hides(self.view.project(point))
    }

    /// Draws a line through points, with opacity `hidden` where it is hidden.
    fn line(&self, out: &mut String, points: &[Point3<f64>], color: &str, width: f64, hidden: f64) {
        let width = width * self.size;
        let fine: Vec<Point3<f64>> = points
            .windows(2)
            .flat_map(|ends| {
                let pieces = (PIECES / (points.len() - 1)).max(1);
                (0..pieces).map(move |piece| {
                    ends[0] + (ends[1] - ends[0]) * (piece as f64 / pieces as f64)
                })
            })
            .chain(points.last().copied())
            .collect();
        let path = |points: &[Point3<f64>]| {
            let mut path = String::new();
            for (index, point) in points.iter().enumerate() {
                let [x, y] = self.place(point);
                let step = if index == 0 { 'M' } else { 'L' };
                // Writing to a string cannot fail.
                let _ = write!(path, "{step}{x:.2} {y:.2}");
            }
            path
        };
        let _ = writeln!(
            out,
            "<path d=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\" \
             stroke-linecap=\"round\" stroke-opacity=\"{hidden}\"/>",
            path(&fine)
        );
        for run in fine.chunk_by(|a, b| self.is_hidden(a) == self.is_hidden(b)) {
            if run.len() > 1 && !self.is_hidden(&run[0]) {
                let _ = writeln!(
                    out,
                    "<path d=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.2}\" \
                     stroke-linecap=\"round\"/>",
                    path(run)
                );
            }
        }
    }

    /// Draws an arrow along points, with its tip at the last one, and with opacity `hidden` where it is hidden.
    fn arrow(&self, out: &mut String, points: &[Point3<f64>], color: &str, hidden: f64) {
        let [before, tip] = [points[points.len() - 2], points[points.len() - 1]];
        let (from, to) = (self.place(&before), self.place(&tip));
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = way[0].hypot(way[1]);
        let head = 4.4 * SHAFT * self.size;
        // Seen along its direction, a straight arrow is a dot.
        if points.len() == 2 && length < 1e-6 {
            return;
        }
        let along = [way[0] / length.max(1e-9), way[1] / length.max(1e-9)];
        let shaft_end = match points.len() {
            // The shaft ends within the head.
            2 => tip + (before - tip) * (0.8 * head / length).min(1.0),
            _ => tip,
        };
        let mut shaft = points[..points.len() - 1].to_vec();
        shaft.push(shaft_end);
        self.line(out, &shaft, color, SHAFT, hidden);
        let (tip_at, base) = match points.len() {
            2 => (to, [to[0] - along[0] * head, to[1] - along[1] * head]),
            _ => ([to[0] + along[0] * head, to[1] + along[1] * head], to),
        };
        let half = 0.42 * head;
        let near_tip = tip + (before - tip) * 0.1;
        let opacity = match self.is_hidden(&near_tip) {
            true => hidden + 0.12,
            false => 1.0,
        };
        let _ = writeln!(
            out,
            "<path d=\"M{:.2} {:.2}L{:.2} {:.2}L{:.2} {:.2}Z\" fill=\"{color}\" fill-opacity=\"{opacity:.2}\"/>",
            tip_at[0],
            tip_at[1],
            base[0] - along[1] * half,
            base[1] + along[0] * half,
            base[0] + along[1] * half,
            base[1] - along[0] * half,
        );
    }

    fn cone(
        &self,
        out: &mut String,
        apex: &Point3<f64>,
        axis: &Unit<Vector3<f64>>,
        friction: f64,
        slant: f64,
        color: &str,
    ) {
        let (height, tangent) = cone(friction, slant);
        let base = apex + axis.into_inner() * height;
        let rim: Vec<Point3<f64>> = circle(&base, axis, height * tangent, 1.0).collect();
        let mut places: Vec<[f64; 2]> = rim.iter().map(|point| self.place(point)).collect();
        places.push(self.place(apex));
        let mut outline = String::new();
        for (index, [x, y]) in convex_hull(places).into_iter().enumerate() {
            let step = if index == 0 { 'M' } else { 'L' };
            let _ = write!(outline, "{step}{x:.2} {y:.2}");
        }
        let faint = if self.is_hidden(&base) { 0.5 } else { 1.0 };
        let _ = writeln!(
            out,
            "<path d=\"{outline}Z\" fill=\"{color}\" fill-opacity=\"{:.2}\"/>",
            0.2 * faint
        );
        self.line(out, &rim, color, THIN, HIDDEN);
    }

    /// Draws the dot at a contact; seen along the arrow, only the dot is visible.
    fn dot(&self, out: &mut String, at: &Point3<f64>, color: &str) {
        let [x, y] = self.place(at);
        let opacity = if self.is_hidden(at) {
            HIDDEN + 0.12
        } else {
            1.0
        };
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.2}\" fill=\"{color}\" fill-opacity=\"{opacity:.2}\"/>",
            1.1 * SHAFT * self.size
        );
    }

    fn number(&self, out: &mut String, at: &Point3<f64>, number: usize, fixed: bool, color: &str) {
        let [x, y] = self.place(at);
        let radius = DISC * self.size;
        let ring = match fixed {
            true => format!(" class=\"ring\" stroke-width=\"{:.2}\"", 2.2 * THIN),
            false => String::new(),
        };
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\" fill=\"{color}\"{ring}/>\
             <text x=\"{x:.2}\" y=\"{:.2}\" text-anchor=\"middle\" fill=\"#ffffff\" font-weight=\"bold\" \
             font-size=\"{:.1}\">{number}</text>",
            y + 0.38 * radius * 1.25,
            1.25 * radius,
        );
    }

    /// Draws the symbol of a centre of mass: a disc in black and white quarters.
    fn center(&self, out: &mut String, at: &Point3<f64>) {
        let [x, y] = self.place(at);
        let r = 7.0 * self.size;
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\" fill=\"#ffffff\" class=\"ring\" \
             stroke-width=\"{:.2}\"/><path d=\"M{x:.2} {y:.2}h{r:.2}a{r:.2} {r:.2} 0 0 0 -{r:.2} -{r:.2}z\
             M{x:.2} {y:.2}h-{r:.2}a{r:.2} {r:.2} 0 0 0 {r:.2} {r:.2}z\" fill=\"#14161a\"/>",
            THIN * self.size
        );
    }
}

/// Returns points on an arc around an axis, right-handed, over a share of the full circle.
fn circle(
    center: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    radius: f64,
    share: f64,
) -> impl Iterator<Item = Point3<f64>> {
    let across = perpendicular(axis).into_inner();
    let beyond = axis.cross(&across);
    let center = *center;
    (0..=CORNERS).map(move |corner| {
        let (sine, cosine) = (TAU * share * corner as f64 / CORNERS as f64).sin_cos();
        center + (across * cosine + beyond * sine) * radius
    })
}

/// Returns the corners of the convex hull of points (Andrew's monotone chain).
fn convex_hull(mut places: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut hull: Vec<[f64; 2]> = Vec::new();
    let backwards: Vec<[f64; 2]> = places.iter().rev().copied().collect();
    for half in [places, backwards] {
        let start = hull.len();
        for place in half {
            while hull.len() >= start + 2
                && turn(hull[hull.len() - 2], hull[hull.len() - 1], place) <= 0.0
            {
                hull.pop();
            }
            hull.push(place);
        }
        hull.pop();
    }
    hull
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn the_hull_of_a_square_has_its_corners_only() {
        let mut places = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]];
        places.extend([[0.5, 0.0], [0.2, 0.9]]);
        assert_eq!(convex_hull(places).len(), 4);
    }

    #[test]
    fn a_circle_turns_right_handed_about_its_axis() {
        let axis = Unit::new_normalize(Vector3::new(1.0, 2.0, -1.0));
        let points: Vec<_> = circle(&Point3::origin(), &axis, 2.0, 0.75).collect();
        let [a, b] = [points[0].coords, points[1].coords];
        assert!(a.cross(&b).dot(&axis) > 0.0);
        let angle = points[0].coords.angle(&points[CORNERS].coords);
        assert!((angle - PI / 2.0).abs() < 1e-9 && (a.norm() - 2.0).abs() < 1e-12);
    }
}
