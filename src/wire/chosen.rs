//! One of the grasps in a result, chosen by name.

use super::{ContactPoint, PlanResult, WeakestWrench};

/// The greatest number of grasps that a request can ask for with `top`.
const MAX_TOP: usize = 1000;

/// Selects a grasp of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Chosen {
    /// The best grasp, or the one that came nearest to force closure.
    #[default]
    Best,
    /// The first force-closure grasp, by Algorithm 1.
    Initial,
    /// One of the distinct grasps by its number; 1 is the best.
    Top(usize),
}

/// A grasp of a result.
#[derive(Debug, Clone, Copy)]
pub struct ChosenGrasp<'a> {
    pub chosen: Chosen,
    pub contacts: &'a [ContactPoint],
    /// ε; absent without force closure.
    pub quality: Option<f64>,
    /// Present for the best grasp only.
    pub weakest: Option<&'a WeakestWrench>,
}

impl Chosen {
    /// The accepted names, for messages.
    pub const NAMES: &str = "best, initial, or the number of one of the top grasps from 1 on";

    /// Returns the choice with this name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "best" => Some(Self::Best),
            "initial" => Some(Self::Initial),
            number => {
                let number = number.parse().ok()?;
                (1..=MAX_TOP).contains(&number).then_some(Self::Top(number))
            }
        }
    }

    /// Returns its name.
    pub fn name(self) -> String {
        match self {
            Self::Best => "best".to_owned(),
            Self::Initial => "initial".to_owned(),
            Self::Top(number) => number.to_string(),
        }
    }

    /// Returns the grasp, if the result has it and it has contacts.
    pub fn of(self, result: &PlanResult) -> Option<ChosenGrasp<'_>> {
        let best = ChosenGrasp {
            chosen: self,
            contacts: &result.contacts,
            quality: result.quality,
            weakest: result.weakest_wrench.as_ref(),
        };
        let other = |contacts, quality| ChosenGrasp {
            chosen: self,
            contacts,
            quality: Some(quality),
            weakest: None,
        };
        let grasp = match self {
            Self::Best => best,
            Self::Initial => {
                let initial = result.initial.as_ref()?;
                other(&initial.contacts, initial.quality)
            }
            Self::Top(number) => match &result.top {
                // The first is the best grasp, and only `best` has its weakest wrench.
                _ if number == 1 => best,
                Some(top) => {
                    let grasp = top.get(number - 1)?;
                    other(&grasp.contacts, grasp.quality)
                }
                None => return None,
            },
        };
        (!grasp.contacts.is_empty()).then_some(grasp)
    }
}
