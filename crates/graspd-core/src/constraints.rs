//! What a grasp has to keep besides force closure: where contacts may be, which are given, how
//! fingers come, and how far apart contacts are.

use std::collections::BTreeSet;
use std::fmt;

use nalgebra::{Point3, UnitVector3};
use rayon::prelude::*;

use super::contact::Contact;
use super::interrupt::{Interrupt, Interrupted};
use super::mesh::Candidate;

/// An angle may be this much above its limit, radians: the normal of a triangle is rounded by some units
/// of 2⁻⁵², and a limit of 0 or 90 degrees is meant to include what is parallel or perpendicular.
pub const ANGLE_TOLERANCE: f64 = 1e-11;

/// Candidates looked at between two checks of the interrupt of [`Constraints::filter`]: some 50 ms with the most rules on
/// one thread.
const BLOCK: usize = 1 << 16;

/// What every grasp has to keep; the default allows everything. Lengths in the mesh's unit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Constraints {
    /// A candidate must be in one of these, when there are any.
    pub include: Vec<Region>,
    /// And in none of these.
    pub exclude: Vec<Region>,
    /// How a finger must come.
    pub approach: Option<Approach>,
    /// How far apart any two contacts must be, but two fixed ones.
    pub spacing: Spacing,
    /// Contacts that are part of every grasp.
    pub fixed: Vec<Contact>,
}

/// A part of the surface: the candidates whose position, or triangle, is in it. Borders belong to it.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// Between two corners of an axis-aligned box.
    Box {
        min: Point3<f64>,
        max: Point3<f64>,
    },
    /// The side of the plane through `point` that `normal` points to.
    HalfSpace {
        point: Point3<f64>,
        normal: UnitVector3<f64>,
    },
    Sphere {
        center: Point3<f64>,
        radius: f64,
    },
    /// By the triangles' index in the file as uploaded, from 0.
    Triangles(BTreeSet<u32>),
}

impl Region {
    /// Whether a candidate is in the region.
    pub fn contains(&self, candidate: &Candidate) -> bool {
        let position = &candidate.position;
        match self {
            Self::Box { min, max } => {
                (0..3).all(|axis| (min[axis]..=max[axis]).contains(&position[axis]))
            }
            Self::HalfSpace { point, normal } => (position - point).dot(normal) >= 0.0,
            Self::Sphere { center, radius } => (position - center).norm() <= *radius,
            Self::Triangles(indices) => indices.contains(&candidate.triangle),
        }
    }
}

/// How a finger must come: moving in one of `directions`, to within an angle of the inward normal.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// Directions in which a finger moves towards the body.
    pub directions: Vec<UnitVector3<f64>>,
    /// Radians, 0 to π.
    pub max_angle: f64,
}

impl Approach {
    /// Whether a finger may come to a contact with this inward normal.
    pub fn allows(&self, normal: &UnitVector3<f64>) -> bool {
        let limit = self.max_angle + ANGLE_TOLERANCE;
        // The arc cosine has half the digits near 0 and π.
        let angle = |d: &UnitVector3<f64>| d.cross(normal).norm().atan2(d.dot(normal));
        self.directions.iter().any(|d| angle(d) <= limit)
    }
}

/// Bounds on the distance between two contacts, inclusive.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spacing {
    pub min: Option<f64>,
    pub max: Option<f64>,
}

impl Spacing {
    /// Whether there is any bound.
    pub fn is_bounded(&self) -> bool {
        self.min.is_some() || self.max.is_some()
    }

    /// Whether contacts at these two places may be in one grasp.
    pub fn allows(&self, a: &Point3<f64>, b: &Point3<f64>) -> bool {
        let distance = (a - b).norm();
        self.min.is_none_or(|min| distance >= min) && self.max.is_none_or(|max| distance <= max)
    }
}

/// A rule that decides about one candidate alone, called by the member of a request that sets it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "String", try_from = "String"))]
pub enum Rule {
    /// In none of the regions to be in.
    Include,
    /// In this one of the regions not to be in.
    Exclude(usize),
    /// The inward normal is too far from every approach direction.
    MaxNormalAngle,
    /// A fixed contact is at the very place.
    FixedContacts,
    /// Too near to a fixed contact.
    MinContactDistance,
    /// Too far from a fixed contact.
    MaxContactDistance,
}

impl fmt::Display for Rule {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Include => formatter.write_str("include"),
            Self::Exclude(index) => write!(formatter, "exclude[{index}]"),
            Self::MaxNormalAngle => formatter.write_str("max_normal_angle"),
            Self::FixedContacts => formatter.write_str("fixed_contacts"),
            Self::MinContactDistance => formatter.write_str("min_contact_distance"),
            Self::MaxContactDistance => formatter.write_str("max_contact_distance"),
        }
    }
}

impl From<Rule> for String {
    fn from(rule: Rule) -> Self {
        rule.to_string()
    }
}

impl TryFrom<String> for Rule {
    type Error = &'static str;

    /// The rule that [`Display`](fmt::Display) writes so.
    fn try_from(name: String) -> Result<Self, Self::Error> {
        let index = name.strip_prefix("exclude[");
        let index = index.and_then(|rest| rest.strip_suffix(']')?.parse().ok());
        [
            Self::Include,
            Self::Exclude(index.unwrap_or_default()),
            Self::MaxNormalAngle,
            Self::FixedContacts,
            Self::MinContactDistance,
            Self::MaxContactDistance,
        ]
        .into_iter()
        .find(|rule| rule.to_string() == name)
        .ok_or("not the name of a rule")
    }
}

/// The number of candidates that a rule of the constraints removed, of those that the rules before it left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct RuleReport {
    /// The member of the constraints that sets the rule, one region of `exclude` by its index. Distances
    /// remove places too near to a fixed contact or too far from one; `fixed_contacts` those that a fixed
    /// contact takes.
    #[cfg_attr(feature = "schema", schema(value_type = String, example = "exclude[0]"))]
    pub rule: Rule,
    /// Candidates it removed.
    #[cfg_attr(feature = "schema", schema(value_type = u64))]
    pub removed: usize,
}

/// Candidates that may be contacts, and why the others may not.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Filtered {
    /// In the order they came in.
    pub kept: Vec<Candidate>,
    /// One for each rule there is, in the order they were applied, also of those that removed nothing.
    pub removals: Vec<RuleReport>,
}

impl Constraints {
    /// Sorts out the candidates that can be in no grasp, whatever the other contacts are; two planned
    /// contacts may still be too near to each other or too far apart. O(n · rules) on the current rayon
    /// pool; `interrupt` is checked between blocks of candidates.
    pub fn filter(
        &self,
        candidates: Vec<Candidate>,
        interrupt: Interrupt<'_>,
    ) -> Result<Filtered, Interrupted> {
        let rules = self.rules();
        if rules.is_empty() {
            return Ok(Filtered {
                kept: candidates,
                removals: Vec::new(),
            });
        }
        let refusing = |candidate: &Candidate| {
            let mut rules = rules.iter();
            rules.position(|&rule| self.refuses(rule, candidate))
        };
        let mut removed = vec![0; rules.len()];
        let mut kept = Vec::new();
        for block in candidates.chunks(BLOCK) {
            interrupt.check()?;
            let refused: Vec<Option<usize>> =
                block.par_iter().with_min_len(512).map(refusing).collect();
            for (candidate, refused) in block.iter().zip(refused) {
                match refused {
                    Some(rule) => removed[rule] += 1,
                    None => kept.push(*candidate),
                }
            }
        }
        let removals = rules.into_iter().zip(removed);
        Ok(Filtered {
            kept,
            removals: removals
                .map(|(rule, removed)| RuleReport { rule, removed })
                .collect(),
        })
    }

    /// Whether contacts may be where these candidates are: each by itself, beside the fixed contacts, and all
    /// of them together.
    pub fn allow(&self, candidates: &[Candidate]) -> bool {
        let rules = self.rules();
        candidates.iter().enumerate().all(|(i, candidate)| {
            let mut rules = rules.iter();
            let mut before = candidates[..i].iter();
            rules.all(|rule| !self.refuses(*rule, candidate))
                && before.all(|other| self.spacing.allows(&candidate.position, &other.position))
        })
    }

    /// The rules there are about single candidates, in the order they are applied.
    fn rules(&self) -> Vec<Rule> {
        let mut rules = Vec::new();
        if !self.include.is_empty() {
            rules.push(Rule::Include);
        }
        rules.extend((0..self.exclude.len()).map(Rule::Exclude));
        if self.approach.is_some() {
            rules.push(Rule::MaxNormalAngle);
        }
        if !self.fixed.is_empty() {
            rules.push(Rule::FixedContacts);
            rules.extend(self.spacing.min.map(|_| Rule::MinContactDistance));
            rules.extend(self.spacing.max.map(|_| Rule::MaxContactDistance));
        }
        rules
    }

    fn refuses(&self, rule: Rule, candidate: &Candidate) -> bool {
        let within = |region: &Region| region.contains(candidate);
        let apart = |spacing: Spacing| {
            let mut fixed = self.fixed.iter();
            fixed.all(|contact| spacing.allows(&contact.position, &candidate.position))
        };
        let Spacing { min, max } = self.spacing;
        match rule {
            Rule::Include => !self.include.iter().any(within),
            Rule::Exclude(index) => self.exclude.get(index).is_some_and(within),
            Rule::MaxNormalAngle => self
                .approach
                .as_ref()
                .is_some_and(|approach| !approach.allows(&candidate.normal)),
            Rule::FixedContacts => self
                .fixed
                .iter()
                .any(|contact| contact.position == candidate.position),
            Rule::MinContactDistance => !apart(Spacing { min, max: None }),
            Rule::MaxContactDistance => !apart(Spacing { min: None, max }),
        }
    }
}

mod apart;

pub(crate) use apart::any_apart;

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// Five by five places of the plane z = 0 from the origin, a unit apart, numbered along y first.
    fn plane() -> Vec<Candidate> {
        (0..25)
            .map(|i| Candidate {
                position: Point3::new(f64::from(i / 5), f64::from(i % 5), 0.0),
                normal: -Vector3::z_axis(),
                triangle: i,
                barycentric: [1.0 / 3.0; 3],
            })
            .collect()
    }

    fn filter(constraints: &Constraints) -> (Vec<u32>, Vec<(String, usize)>) {
        let filtered = constraints.filter(plane(), Interrupt::never());
        let Filtered { kept, removals } = filtered.unwrap();
        let removals = removals.iter().map(|r| (r.rule.to_string(), r.removed));
        (
            kept.iter().map(|c| c.triangle).collect(),
            removals.collect(),
        )
    }

    fn fixed(x: f64, y: f64) -> Contact {
        Contact {
            position: Point3::new(x, y, 0.0),
            normal: -Vector3::z_axis(),
        }
    }

    #[test]
    fn each_rule_removes_and_counts_what_is_its_own() {
        let column = Region::Box {
            min: Point3::new(1.0, -1.0, 0.0),
            max: Point3::new(2.0, 9.0, 0.0),
        };
        let half = Region::HalfSpace {
            point: Point3::new(0.0, 3.0, 7.0),
            normal: Vector3::y_axis(),
        };
        let ball = Region::Sphere {
            center: Point3::new(1.0, 1.0, 0.0),
            radius: 1.0,
        };
        let single = Region::Triangles(BTreeSet::from([5, 6, 24]));
        let constraints = Constraints {
            include: vec![column],
            exclude: vec![half, ball, single],
            ..Constraints::default()
        };
        let (kept, removals) = filter(&constraints);
        assert_eq!(kept, [10, 12]);
        let named = |name: &str, removed| (name.to_owned(), removed);
        assert_eq!(
            removals,
            [
                named("include", 15),
                named("exclude[0]", 4),
                named("exclude[1]", 4),
                named("exclude[2]", 0),
            ]
        );
        let constraints = Constraints {
            fixed: vec![fixed(0.0, 0.0), fixed(0.0, 0.5)],
            spacing: Spacing {
                min: Some(1.0),
                max: Some(3.0),
            },
            ..Constraints::default()
        };
        let (kept, removals) = filter(&constraints);
        assert_eq!(kept, [2, 3, 5, 6, 7, 10, 11, 12]);
        assert_eq!(
            removals,
            [
                named("fixed_contacts", 1),
                named("min_contact_distance", 1),
                named("max_contact_distance", 15),
            ]
        );
        assert_eq!(filter(&Constraints::default()).0.len(), 25);
    }

    #[test]
    fn limits_of_the_angle_are_included() {
        let down = -Vector3::z_axis();
        for (direction, degrees, allowed) in [
            (down, 0.0, true),
            (Vector3::x_axis(), 90.0, true),
            (Vector3::x_axis(), 89.999, false),
            (Vector3::z_axis(), 179.999, false),
            (Vector3::z_axis(), 180.0, true),
            (
                UnitVector3::new_normalize(Vector3::new(1.0, 0.0, -1.0)),
                45.0,
                true,
            ),
            (
                UnitVector3::new_normalize(Vector3::new(1.0, 0.0, -1.0)),
                44.999,
                false,
            ),
        ] {
            let approach = Approach {
                directions: vec![direction],
                max_angle: f64::to_radians(degrees),
            };
            assert_eq!(approach.allows(&down), allowed, "{direction:?} {degrees}");
        }
        let either = Approach {
            directions: vec![Vector3::x_axis(), down],
            max_angle: 0.1,
        };
        assert!(either.allows(&down) && !either.allows(&Vector3::z_axis()));
    }

    #[test]
    fn the_filter_can_be_interrupted() {
        let constraints = Constraints {
            include: vec![Region::Triangles(BTreeSet::from([1]))],
            ..Constraints::default()
        };
        let cancelled = || Some(Interrupted::Cancelled);
        let filtered = constraints.filter(plane(), Interrupt::new(&cancelled));
        assert_eq!(filtered, Err(Interrupted::Cancelled));
    }
}
