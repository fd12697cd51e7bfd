//! Pictures of grasps: what they must show.

use resvg::usvg::roxmltree::Document;

use super::*;
use crate::picture::tests::decoded;
use crate::picture::{CONTACT_COLORS, FORCE};
use crate::wire::{Chosen, ContactPoint, Explanation, Reason, WeakestWrench};
use graspd_core::mesh::solids;

/// A ball of radius one, held by two fingers from left and right and one from behind.
fn ball() -> (Mesh, PlanResult) {
    let mesh = Mesh::prepare(solids::sphere(1.0, 24, 48)).unwrap();
    let text = include_str!("../../../openapi/examples/result.json");
    let mut result: PlanResult = serde_json::from_str(text).unwrap();
    let template = result.contacts[0].clone();
    let contact = |[x, y, z]: [f64; 3]| ContactPoint {
        position: [x, y, z],
        normal: [-x, -y, -z],
        approach: [x, y, z],
        ..template.clone()
    };
    let sides = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    result.contacts = sides.map(contact).to_vec();
    result.center_of_mass = [0.0; 3];
    result.weakest_wrench = Some(WeakestWrench {
        force: [0.0, 0.0, 1.0],
        torque: [0.0; 3],
        description: String::new(),
    });
    result.initial = None;
    result.top = None;
    (mesh, result)
}

fn options(view: &str, width: u32, legend: bool) -> GraspOptions {
    GraspOptions {
        width,
        background: Background::Light,
        view: Viewpoint::named(view).unwrap(),
        legend,
    }
}

/// Width, height and the pixels of the picture of the best grasp.
fn pixels(mesh: &Mesh, result: &PlanResult, options: &GraspOptions) -> (u32, u32, Vec<[u8; 3]>) {
    let grasp = Chosen::Best.of(result).unwrap();
    let png = grasp_png(mesh, result, &grasp, "a ball", options).unwrap();
    let (width, height, pixels) = decoded(png);
    let pixels = pixels.into_iter().map(|[red, green, blue, opacity]| {
        assert_eq!(opacity, 255, "opaque");
        [red, green, blue]
    });
    (width, height, pixels.collect())
}

fn count(pixels: &[[u8; 3]], color: [u8; 3]) -> usize {
    pixels.iter().filter(|pixel| **pixel == color).count()
}

/// The columns of the pixels of a colour, as shares of the width.
fn columns(pixels: &[[u8; 3]], width: u32, color: [u8; 3]) -> (f64, f64) {
    let found = pixels
        .iter()
        .enumerate()
        .filter(|(_, pixel)| **pixel == color);
    let columns = found.map(|(at, _)| (at as u32 % width) as f64 / f64::from(width));
    columns.fold((1.0, 0.0), |(low, high), x| {
        (f64::min(low, x), f64::max(high, x))
    })
}

#[test]
fn the_axes_are_complete_in_every_view() {
    let (mesh, result) = ball();
    for view in ["iso", "front", "back", "left", "right", "top", "bottom"] {
        let (width, _, pixels) = pixels(&mesh, &result, &options(view, 400, true));
        let edge = pixels.iter().step_by(width as usize);
        assert!(edge.copied().all(|pixel| pixel == [255; 3]), "{view}");
    }
}

#[test]
fn fingers_are_at_their_contacts_and_faint_behind_the_body() {
    let (mesh, result) = ball();
    let (width, height, seen) = pixels(&mesh, &result, &options("front", 800, false));
    assert_eq!((width, height), (800, 600));
    let (low, high) = columns(&seen, width, CONTACT_COLORS[0]);
    assert!(low < 0.2 && high < 0.45, "from the left: {low} to {high}");
    let (low, high) = columns(&seen, width, CONTACT_COLORS[1]);
    assert!(low > 0.55 && high > 0.8, "from the right: {low} to {high}");
    // The third comes from behind, directly towards the viewer.
    assert_eq!(count(&seen, CONTACT_COLORS[2]), 0);
    let (.., behind) = pixels(&mesh, &result, &options("back", 800, false));
    assert!(count(&behind, CONTACT_COLORS[2]) > 50);
    let (low, high) = columns(&behind, width, CONTACT_COLORS[0]);
    assert!(low > 0.55, "the other way round: {low} to {high}");
}

#[test]
fn two_views_are_half_as_high_as_wide_and_a_legend_stands_below() {
    let (mesh, result) = ball();
    let (width, height, _) = pixels(&mesh, &result, &options("both", 500, false));
    assert_eq!((width, height), (500, 250));
    let (width, height, with) = pixels(&mesh, &result, &options("both", 500, true));
    assert!(width == 500 && height > 330);
    let dark = GraspOptions {
        background: Background::Dark,
        ..options("both", 500, true)
    };
    let (.., dark) = pixels(&mesh, &result, &dark);
    let corner = (with[0], dark[0]);
    assert_eq!(corner, ([255; 3], [0x16, 0x18, 0x1c]));
    // Both contain text.
    let below = |pixels: &[[u8; 3]]| {
        let paper = pixels[0];
        let rest = &pixels[500 * 255..];
        rest.iter().filter(|pixel| **pixel != paper).count()
    };
    assert!(below(&with) > 3_000 && below(&dark) > 3_000);
}

#[test]
fn only_the_best_grasp_shows_the_weakest_force() {
    let (mesh, mut result) = ball();
    let top = crate::wire::TopGrasp {
        quality: 0.1,
        distance_to_best: 1.0,
        contacts: result.contacts.clone(),
    };
    result.top = Some(vec![top.clone(), top]);
    let svg = |chosen: Chosen, result: &PlanResult| {
        let grasp = chosen.of(result).unwrap();
        grasp_svg(&mesh, result, &grasp, "a ball", &options("iso", 300, true)).unwrap()
    };
    let red = crate::picture::colors::hex(FORCE);
    assert!(svg(Chosen::Best, &result).contains(&red));
    assert!(svg(Chosen::Top(1), &result).contains(&red));
    assert!(!svg(Chosen::Top(2), &result).contains(&red));
    assert!(Chosen::Top(3).of(&result).is_none() && Chosen::Initial.of(&result).is_none());
    assert_eq!(svg(Chosen::Best, &result), svg(Chosen::Best, &result));
}

#[test]
fn markup_in_titles_is_shown_as_text() {
    let (mesh, mut result) = ball();
    let words = "</text><script>alert(1)</script>&\"'\u{0}\u{202e}\u{ffff}";
    result.quality = None;
    result.explanation = Some(Explanation {
        reason: Reason::OneSided,
        proven: true,
        detail: words.repeat(20),
    });
    let grasp = Chosen::Best.of(&result).unwrap();
    let svg = grasp_svg(&mesh, &result, &grasp, words, &options("both", 128, true)).unwrap();
    let document = Document::parse(&svg).unwrap();
    let names: Vec<_> = document
        .descendants()
        .map(|node| node.tag_name().name())
        .collect();
    assert!(!names.contains(&"script"));
    let texts: String = document
        .descendants()
        .filter_map(|node| node.text())
        .collect();
    assert!(texts.contains("<script>alert(1)") && texts.contains("no force closure"));
    assert!(!texts.contains('\u{202e}'));
}

#[test]
fn every_direction_of_view_works() {
    let (mesh, result) = ball();
    for view in [
        "top", "bottom", "left", "right", "0,90", "-360,-90", "12.5,-3", "iso",
    ] {
        let (.., seen) = pixels(&mesh, &result, &options(view, 64, false));
        let body = seen.iter().filter(|pixel| **pixel != [255; 3]).count();
        assert!(body > 300, "{view}: {body}");
    }
    for wrong in ["", "up", "1", "1,2,3", "NaN,0", "0,91", "361,0", "a,b"] {
        assert_eq!(Viewpoint::named(wrong), None, "{wrong}");
    }
}
