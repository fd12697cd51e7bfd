//! From what a client sent to a [`PlanRequest`]: one validation for JSON, forms and flags.

use std::ops::RangeInclusive;

use serde::Serialize;
use serde_json::{Map, Value};

use super::analysis::Analyses;
use super::candidates::CandidateSettings;
use super::constraints::{Constraints, MAX_CONSTRAINTS_BYTES};
use super::defaults::SearchDefaults;
use super::fields::{FIELDS, Field, form_value};
use super::priority::Priority;
use super::request::{
    ContactModel, EdgeNorm, InitialMode, Method, PlanRequest, QualitySettings, TorqueScale, Units,
    WrenchSpace,
};
use super::{FieldError, callback, json, text};

/// Individuals that one request may ask for: population times (generations + 1).
const MAX_INDIVIDUALS: u64 = 1_000_000_000;
const MAX_LABEL_CHARS: usize = 200;
pub(super) const MAX_COORDINATE: f64 = 1e12;

impl PlanRequest {
    /// Validates a JSON object, fills in the defaults, and reports every field at fault.
    pub fn from_json(value: &Value, default_seed: u64) -> Result<Self, Vec<FieldError>> {
        let Value::Object(object) = value else {
            return Err(vec![FieldError {
                pointer: String::new(),
                detail: "the planning request must be a JSON object".to_owned(),
            }]);
        };
        Reader::new(object).request(default_seed)
    }

    /// Validates simple form fields or flags: each text becomes the JSON value its field wants,
    /// then the rules of [`Self::from_json`] hold.
    pub fn from_form(
        fields: impl IntoIterator<Item = (String, String)>,
        default_seed: u64,
    ) -> Result<Self, Vec<FieldError>> {
        let (mut object, repeated) = form_object(fields);
        let is_document = |field: &&Field| {
            let text = object.get(field.name).and_then(Value::as_str);
            text.is_some_and(|text| field.reads_as_json(text))
        };
        let documents = FIELDS.iter().filter(is_document).map(|field| field.name);
        let documents: Vec<&str> = documents.collect();
        read_texts(&mut object, documents, MAX_CONSTRAINTS_BYTES)?;
        let mut reader = Reader::new(&object);
        reader.refuse_repeated(&repeated);
        reader.request(default_seed)
    }
}

/// The JSON object that simple form fields mean, and the names that came more than once.
pub(super) fn form_object(
    fields: impl IntoIterator<Item = (String, String)>,
) -> (Map<String, Value>, Vec<String>) {
    let mut object = Map::new();
    let mut repeated = Vec::new();
    for (name, text) in fields {
        let value = form_value(&name, &text);
        if object.contains_key(&name) {
            repeated.push(name.clone());
        }
        object.insert(name, value);
    }
    (object, repeated)
}

/// Reads the JSON documents that some form fields are, strictly.
pub(super) fn read_texts(
    object: &mut Map<String, Value>,
    names: impl IntoIterator<Item = &'static str>,
    limit: usize,
) -> Result<(), Vec<FieldError>> {
    for name in names {
        let Some(Value::String(text)) = object.get(name) else {
            continue;
        };
        let read = json::read_up_to(text.as_bytes(), limit).map_err(|problem| {
            vec![FieldError {
                pointer: text::pointer(name),
                detail: problem.detail,
            }]
        })?;
        object.insert(name.to_owned(), read);
    }
    Ok(())
}

/// Takes fields out of an object and collects what is wrong with them.
pub(super) struct Reader<'a> {
    object: &'a Map<String, Value>,
    /// Pointer of the object in the document.
    place: String,
    errors: Vec<FieldError>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(object: &'a Map<String, Value>) -> Self {
        Self::within(object, String::new())
    }

    /// For an object that is a part of a document, with its pointer.
    pub(super) fn within(object: &'a Map<String, Value>, place: String) -> Self {
        Self {
            object,
            place,
            errors: Vec::new(),
        }
    }

    /// The value of a field, as it came.
    pub(super) fn value(&self, name: &str) -> Option<&'a Value> {
        self.object.get(name)
    }

    /// The pointer of a field.
    pub(super) fn pointer(&self, name: &str) -> String {
        format!("{}{}", self.place, text::pointer(name))
    }

    /// Takes over what is wrong with a part.
    pub(super) fn absorb(&mut self, part: Reader<'_>) {
        self.errors.extend(part.errors);
    }

    pub(super) fn refuse_repeated(&mut self, repeated: &[String]) {
        for name in repeated {
            self.fail(name, "given more than once; give it once");
        }
    }

    fn request(mut self, default_seed: u64) -> Result<PlanRequest, Vec<FieldError>> {
        let known: Vec<_> = FIELDS.iter().map(|field| field.name).collect();
        self.refuse_unknown(&known);
        let QualitySettings {
            contact_model,
            friction,
            cone_edges,
            torsional_friction,
            edge_norm,
            wrench_space,
            torque_scale,
            center_of_mass,
            units,
        } = self.quality();
        let Analyses {
            robustness,
            independent_regions,
            task_wrenches,
            gravity,
        } = self.analyses();
        let default_contacts = match contact_model {
            ContactModel::Hard | ContactModel::Soft => 4,
            ContactModel::Frictionless => 7,
        };
        let methods = [
            Method::Memetic,
            Method::ModifiedGa,
            Method::Local,
            Method::Random,
        ];
        let method = self.choice("method", &methods).unwrap_or(Method::Memetic);
        let default = SearchDefaults::of(method);
        let population = self.integer("population", 2..=100_000);
        let population = population.unwrap_or(default.population);
        let generations = self.integer("generations", 0..=100_000);
        let generations = generations.unwrap_or(default.generations);
        let contacts = self.integer("contacts", 1..=64).unwrap_or(default_contacts);
        if population * (generations + 1) > MAX_INDIVIDUALS {
            self.fail(
                "generations",
                "population times (generations + 1) must be at most 1000000000",
            );
        }
        let elitism = self.integer("elitism", 0..=99_999).unwrap_or(1);
        if elitism >= population {
            self.fail("elitism", "must be less than the population");
        }
        let request = PlanRequest {
            contacts: contacts as u32,
            contact_model,
            friction,
            cone_edges,
            torsional_friction,
            edge_norm,
            wrench_space,
            torque_scale,
            center_of_mass,
            units,
            constraints: Constraints::read(&mut self, contacts),
            candidates: CandidateSettings::read(&mut self),
            method,
            population: population as u32,
            generations: generations as u32,
            crossover_probability: self
                .probability("crossover_probability")
                .unwrap_or(default.crossover),
            mutation_probability: self
                .probability("mutation_probability")
                .unwrap_or(default.mutation),
            elitism: elitism as u32,
            initial: self
                .choice("initial", &[InitialMode::Weak, InitialMode::Strict])
                .unwrap_or(default.initial),
            polish: self.boolean("polish").unwrap_or(default.polish),
            time_limit_s: self.number("time_limit_s", "greater than 0, at most 3600", |x| {
                x > 0.0 && x <= 3600.0
            }),
            evaluation_limit: self.integer("evaluation_limit", 1..=1_000_000_000),
            target_quality: self.number("target_quality", "greater than 0", |x| x > 0.0),
            robustness,
            independent_regions,
            task_wrenches,
            gravity,
            trials: self.integer("trials", 1..=1000).unwrap_or(1) as u32,
            top: self.integer("top", 1..=100).unwrap_or(1) as u32,
            seed: self.integer("seed", 0..=u64::MAX).unwrap_or(default_seed),
            label: self.label(),
            priority: self.choice("priority", &Priority::ALL).unwrap_or_default(),
            callback_url: callback::read_url(&mut self),
        };
        self.finish(request)
    }

    /// What was read, if nothing was wrong with it.
    pub(super) fn finish<T>(self, read: T) -> Result<T, Vec<FieldError>> {
        if self.errors.is_empty() {
            Ok(read)
        } else {
            Err(self.errors)
        }
    }

    /// The settings that the quality of a grasp depends on.
    pub(super) fn quality(&mut self) -> QualitySettings {
        let (contact_model, friction, cone_edges) = self.contact_model();
        let torsional_friction = self.number("torsional_friction", "above 0, up to 1e12", |x| {
            x > 0.0 && x <= MAX_COORDINATE
        });
        if torsional_friction.is_some() && contact_model != ContactModel::Soft {
            self.fail(
                "torsional_friction",
                "only soft contacts have it; leave it out or use contact_model \"soft\"",
            );
        }
        QualitySettings {
            contact_model,
            friction,
            cone_edges,
            torsional_friction,
            edge_norm: self
                .choice("edge_norm", &[EdgeNorm::UnitEdge, EdgeNorm::UnitNormal])
                .unwrap_or(EdgeNorm::UnitEdge),
            wrench_space: self
                .choice("wrench_space", &[WrenchSpace::L1, WrenchSpace::Linf])
                .unwrap_or_default(),
            torque_scale: self.torque_scale(),
            center_of_mass: self.point("center_of_mass"),
            units: self.choice("units", &Units::ALL),
        }
    }

    pub(super) fn get(&self, name: &str) -> Option<&'a Value> {
        self.object.get(name)
    }

    /// Reads an object within the object, of which `known` are all members.
    pub(super) fn nested<T>(
        &mut self,
        name: &str,
        known: &[&str],
        read: impl FnOnce(&mut Reader<'a>) -> T,
    ) -> Option<T> {
        let Some(object) = self.get(name)?.as_object() else {
            let members = known.join(", ");
            self.fail(
                name,
                format!("must be an object; its members are {members}"),
            );
            return None;
        };
        let mut inner = Reader::new(object);
        inner.refuse_unknown(known);
        let read = read(&mut inner);
        for FieldError { pointer, detail } in inner.errors {
            self.fail_at(format!("{}{pointer}", text::pointer(name)), detail);
        }
        Some(read)
    }

    pub(super) fn refuse_unknown(&mut self, known: &[&str]) {
        self.refuse_unknown_besides(known, &known.join(", "));
    }

    /// As [`Self::refuse_unknown`], where `accepted` names more, which has been taken out.
    pub(super) fn refuse_unknown_besides(&mut self, known: &[&str], accepted: &str) {
        let object = self.object;
        let unknown = object.keys().filter(|name| !known.contains(&name.as_str()));
        for (index, name) in unknown.enumerate() {
            // The list is long; once is enough.
            if index == 0 {
                self.fail(name, format!("unknown field; accepted are {accepted}"));
            } else {
                self.fail(name, "unknown field");
            }
        }
    }

    fn contact_model(&mut self) -> (ContactModel, Option<f64>, Option<u32>) {
        let model = self.choice(
            "contact_model",
            &[
                ContactModel::Hard,
                ContactModel::Frictionless,
                ContactModel::Soft,
            ],
        );
        let wanted = "from 0 (frictionless) to 10, the same for all contacts";
        let friction = self.number("friction", wanted, |x| (0.0..=10.0).contains(&x));
        let edges = self.integer("cone_edges", 0..=32);
        if matches!(edges, Some(1 | 2)) {
            self.fail("cone_edges", "must be 0 (the round cone) or from 3 to 32");
        }
        let frictionless = model == Some(ContactModel::Frictionless)
            || (friction == Some(0.0) && model != Some(ContactModel::Soft));
        if model == Some(ContactModel::Soft) && friction == Some(0.0) {
            self.fail("friction", "soft contacts need some; use a number above 0");
        }
        if !frictionless {
            return (
                model.unwrap_or(ContactModel::Hard),
                Some(friction.unwrap_or(0.5)),
                Some(edges.unwrap_or(8) as u32),
            );
        }
        if friction.is_some_and(|mu| mu > 0.0) {
            self.fail(
                "friction",
                "frictionless contacts have none; leave it out or use contact_model \"hard\"",
            );
        }
        if edges.is_some() {
            self.fail(
                "cone_edges",
                "frictionless contacts have no friction cone; leave it out",
            );
        }
        (ContactModel::Frictionless, None, None)
    }

    fn torque_scale(&mut self) -> TorqueScale {
        match self.object.get("torque_scale") {
            None => return TorqueScale::MaxRadius,
            Some(Value::String(name)) if name == "max_radius" => return TorqueScale::MaxRadius,
            Some(Value::String(name)) if name == "none" => return TorqueScale::None,
            Some(value) => {
                if let Some(scale) = value.as_f64().filter(|x| (1e-9..=1e9).contains(x)) {
                    return TorqueScale::Custom(scale);
                }
            }
        }
        self.fail(
            "torque_scale",
            "must be \"max_radius\", \"none\" or a number from 1e-9 to 1e9",
        );
        TorqueScale::MaxRadius
    }

    pub(super) fn point(&mut self, name: &str) -> Option<[f64; 3]> {
        let value = self.object.get(name)?;
        let Some(items) = value.as_array().filter(|items| items.len() == 3) else {
            self.fail(name, "must be three numbers, [x, y, z]");
            return None;
        };
        let mut point = [0.0; 3];
        for (index, item) in items.iter().enumerate() {
            match item.as_f64().filter(|x| x.abs() <= MAX_COORDINATE) {
                Some(x) => point[index] = x,
                None => self.fail_at(
                    format!("{}/{index}", self.pointer(name)),
                    "must be a number from -1e12 to 1e12",
                ),
            }
        }
        Some(point)
    }

    pub(super) fn label(&mut self) -> Option<String> {
        let value = self.object.get("label")?;
        let fit = value.as_str().filter(|label| {
            label.chars().count() <= MAX_LABEL_CHARS && !label.chars().any(text::is_unsafe)
        });
        if fit.is_none() {
            self.fail(
                "label",
                "must be a text of at most 200 characters without control characters or marks \
                 that change the direction of writing",
            );
        }
        fit.map(str::to_owned)
    }

    pub(super) fn integer(&mut self, name: &str, range: RangeInclusive<u64>) -> Option<u64> {
        let value = self.object.get(name)?;
        let whole = value.as_u64().or_else(|| {
            // JSON has one kind of number: 8.0 is the integer 8. Past 2^53 that is a guess.
            value
                .as_f64()
                .filter(|x| x.fract() == 0.0 && (0.0..9_007_199_254_740_992.0).contains(x))
                .map(|x| x as u64)
        });
        let accepted = whole.filter(|whole| range.contains(whole));
        if accepted.is_none() {
            self.fail(
                name,
                format!(
                    "must be a whole number from {} to {}",
                    range.start(),
                    range.end()
                ),
            );
        }
        accepted
    }

    fn boolean(&mut self, name: &str) -> Option<bool> {
        let value = self.object.get(name)?;
        if !value.is_boolean() {
            self.fail(name, "must be true or false");
        }
        value.as_bool()
    }

    fn probability(&mut self, name: &str) -> Option<f64> {
        self.number(name, "from 0 to 1", |x| (0.0..=1.0).contains(&x))
    }

    pub(super) fn number(
        &mut self,
        name: &str,
        wanted: &str,
        accept: fn(f64) -> bool,
    ) -> Option<f64> {
        let value = self.object.get(name)?;
        let accepted = value.as_f64().filter(|x| x.is_finite() && accept(*x));
        if accepted.is_none() {
            self.fail(name, format!("must be a number {wanted}"));
        }
        accepted
    }

    pub(super) fn choice<T: Serialize + Copy>(&mut self, name: &str, options: &[T]) -> Option<T> {
        let value = self.object.get(name)?;
        let named = |option: &T| serde_json::to_value(option).unwrap_or_default();
        let chosen = options.iter().find(|option| named(option) == *value);
        if chosen.is_none() {
            let names: Vec<_> = options.iter().map(|o| named(o).to_string()).collect();
            self.fail(name, format!("must be {}", names.join(" or ")));
        }
        chosen.copied()
    }

    pub(super) fn fail(&mut self, name: &str, detail: impl Into<String>) {
        self.fail_at(self.pointer(name), detail);
    }

    pub(super) fn fail_at(&mut self, pointer: String, detail: impl Into<String>) {
        self.errors.push(FieldError {
            pointer,
            detail: detail.into(),
        });
    }
}

#[cfg(test)]
mod tests;
