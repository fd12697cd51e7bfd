//! The legend: the numbers of a grasp, and the meaning of the marks.

use std::fmt::Write as _;

use crate::picture::colors::hex;
use crate::picture::text::{self, TITLE_SIZE, escape, figure, wrap};
use crate::picture::{CONTACT_COLORS, FORCE, TORQUE};
use crate::wire::{Chosen, ChosenGrasp, PlanResult};
use graspd_core::plan::ContactKind;
use graspd_core::wrench::WrenchSpace;

const MARGIN: f64 = 36.0;
const ROW: f64 = 24.0;
/// Position of the explanations of the marks.
const KEY: f64 = 560.0;

/// Returns the legend below `top`, and the end of the drawing.
pub(super) fn draw(
    result: &PlanResult,
    grasp: &ChosenGrasp<'_>,
    title: &str,
    top: f64,
) -> (String, f64) {
    let mut out = String::new();
    let mut y = top + 34.0;
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<text class=\"text\" x=\"{MARGIN}\" y=\"{y}\" font-size=\"{TITLE_SIZE}\" font-weight=\"bold\">{}</text>",
        text::title(title)
    );
    y += 1.4 * ROW;
    let rows = numbers(result, grasp);
    let keys = meanings(result, grasp);
    for (index, (name, value)) in rows.iter().enumerate() {
        let y = y + index as f64 * ROW;
        let _ = writeln!(
            out,
            "<text class=\"muted\" x=\"{MARGIN}\" y=\"{y}\">{}</text>\
             <text class=\"text\" x=\"{}\" y=\"{y}\">{}</text>",
            escape(name),
            MARGIN + 150.0,
            escape(value)
        );
    }
    for (index, (symbol, meaning)) in keys.iter().enumerate() {
        let y = y + index as f64 * ROW;
        let _ = writeln!(
            out,
            "<g transform=\"translate({KEY} {})\">{symbol}</g>\
             <text class=\"text\" x=\"{}\" y=\"{y}\">{meaning}</text>",
            y - 5.0,
            KEY + 44.0
        );
    }
    y += rows.len().max(keys.len()) as f64 * ROW;
    let explanation = result
        .explanation
        .as_ref()
        .filter(|_| grasp.quality.is_none());
    for line in explanation.map(|e| wrap(&e.detail)).unwrap_or_default() {
        let _ = writeln!(
            out,
            "<text class=\"warning\" x=\"{MARGIN}\" y=\"{y}\">{}</text>",
            escape(&line)
        );
        y += ROW;
    }
    (out, y)
}

fn numbers(result: &PlanResult, grasp: &ChosenGrasp<'_>) -> Vec<(&'static str, String)> {
    let is_best = grasp.chosen == Chosen::Best;
    let mut rows = vec![(
        "Grasp",
        match grasp.chosen {
            Chosen::Best if grasp.quality.is_none() => {
                "no force closure; what came nearest".to_owned()
            }
            Chosen::Best => "the best found".to_owned(),
            Chosen::Initial => "the first found".to_owned(),
            Chosen::Top(number) => format!(
                "number {number} of {}",
                result.top.as_ref().map_or(1, Vec::len)
            ),
        },
    )];
    match (grasp.quality, result.margin) {
        (Some(quality), _) => rows.push(("Quality ε", figure(quality))),
        (None, Some(margin)) => rows.push(("Margin", figure(margin))),
        (None, None) => {}
    }
    let has_cone = result.contact_model != ContactKind::Frictionless;
    if let (true, Some([lower, upper])) = (is_best && has_cone, result.bounds) {
        let [lower, upper] = [lower, upper].map(figure);
        let quality = match lower == upper {
            true => lower,
            false => format!("{lower} to {upper}"),
        };
        rows.push(("With round cones", quality));
    }
    let count = grasp.contacts.len();
    let model = match (result.contact_model, result.friction) {
        (ContactKind::Frictionless, _) | (_, None) => "no friction".to_owned(),
        (ContactKind::Hard, Some(friction)) => format!("hard, friction {friction}"),
        (ContactKind::Soft, Some(friction)) => format!("soft, friction {friction}"),
    };
    rows.push(("Contacts", format!("{count}, {model}")));
    let space = match result.wrench_space {
        WrenchSpace::L1 => "forces sum to one",
        WrenchSpace::Linf => "each force at most one",
    };
    rows.push(("Wrench space", space.to_owned()));
    let scale = &result.torque_scale;
    rows.push((
        "Torque scale",
        format!("{} ({})", figure(scale.value), scale.kind),
    ));
    let method = serde_json::to_value(result.method).ok();
    let method = method
        .as_ref()
        .and_then(|name| name.as_str())
        .unwrap_or_default();
    rows.push(("Search", format!("{method}, seed {}", result.seed)));
    rows
}

fn meanings(result: &PlanResult, grasp: &ChosenGrasp<'_>) -> Vec<(String, &'static str)> {
    let [blue, orange, ..] = CONTACT_COLORS.map(hex);
    let arrow = |color: &str| {
        format!(
            "<path d=\"M0 0H24\" stroke=\"{color}\" stroke-width=\"3\"/><path d=\"M34 0L22 -5V5Z\" fill=\"{color}\"/>"
        )
    };
    let mut keys = vec![(arrow(&blue), "a finger, pushing along the inward normal")];
    if result.contact_model != ContactKind::Frictionless && result.friction.is_some_and(|f| f > 0.0)
    {
        keys.push((
            format!(
                "<path d=\"M34 0L4 -8V8Z\" fill=\"{orange}\" fill-opacity=\"0.25\" stroke=\"{orange}\" stroke-width=\"1\"/>"
            ),
            "from where friction lets it push as well",
        ));
    }
    if result.contact_model == ContactKind::Soft {
        keys.push((
            format!("<ellipse cx=\"17\" cy=\"0\" rx=\"9\" ry=\"5\" fill=\"none\" stroke=\"{blue}\" stroke-width=\"2\"/>"),
            "soft: holds against turning on the spot",
        ));
    }
    if grasp.contacts.iter().any(|contact| contact.fixed) {
        keys.push((
            format!("<circle cx=\"17\" cy=\"0\" r=\"7\" fill=\"{blue}\" class=\"ring\" stroke-width=\"2.5\"/>"),
            "a finger that was given",
        ));
    }
    keys.push((
        "<circle cx=\"17\" cy=\"0\" r=\"7\" fill=\"#ffffff\" class=\"ring\" stroke-width=\"1.2\"/>\
         <path d=\"M17 0h7a7 7 0 0 0 -7 -7zM17 0h-7a7 7 0 0 0 7 7z\" fill=\"#14161a\"/>"
            .to_owned(),
        "centre of mass",
    ));
    if let Some(weakest) = grasp.weakest {
        let is_there = |vector: [f64; 3]| vector.iter().any(|part| part.abs() > 1e-3);
        if is_there(weakest.force) {
            keys.push((arrow(&hex(FORCE)), "the force of the weakest wrench"));
        }
        if is_there(weakest.torque) {
            let color = hex(TORQUE);
            keys.push((
                format!(
                    "<path d=\"M8 5A10 9 0 1 1 27 4\" fill=\"none\" stroke=\"{color}\" stroke-width=\"3\"/>\
                     <path d=\"M25 11L21 2L31 3Z\" fill=\"{color}\"/>"
                ),
                "its torque",
            ));
        }
    }
    keys.push((
        "<path d=\"M0 0H34\" class=\"mean\" stroke-width=\"3\" stroke-opacity=\"0.35\"/>"
            .to_owned(),
        "faint: behind or within the body",
    ));
    keys
}
