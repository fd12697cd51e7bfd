//! Analyses of a grasp that are made only on request, because each costs many evaluations: robustness,
//! independent regions, and quality for tasks and gravity.

use std::sync::OnceLock;

use nalgebra::Vector3;

use super::contact::{Contact, Site};
use super::effort::ExternalWrench;
use super::independent::{Fraction, IndependentRegion, Places, independent_regions};
use super::interrupt::{Interrupt, Interrupted};
use super::mesh::{Mesh, Projector};
use super::mismatch::Mismatch;
use super::quality::Margin;
use super::robustness::{Robustness, Scatter, robustness};
use super::task::{TaskQuality, task_quality};
use super::wrench::WrenchModel;

/// The analyses to make of a grasp; none by default.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AnalysisSettings {
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub robustness: Option<Scatter>,
    /// Share of ε that a grasp keeps within its independent regions.
    #[cfg_attr(
        feature = "serde",
        serde(
            default,
            rename = "independent_regions",
            skip_serializing_if = "Option::is_none"
        )
    )]
    pub regions: Option<Fraction>,
    /// Disturbances to resist.
    #[cfg_attr(
        feature = "serde",
        serde(
            default,
            rename = "task_wrenches",
            with = "six_numbers",
            skip_serializing_if = "Vec::is_empty"
        )
    )]
    pub tasks: Vec<ExternalWrench>,
    /// Direction of a force at the centre of mass to resist.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub gravity: Option<Vector3<f64>>,
}

/// Wrenches as lists [fx, fy, fz, tx, ty, tz].
#[cfg(feature = "serde")]
mod six_numbers {
    use nalgebra::Vector3;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::ExternalWrench;

    pub fn serialize<S: Serializer>(
        wrenches: &[ExternalWrench],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(wrenches.iter().map(|ExternalWrench { force, torque }| {
            [force.x, force.y, force.z, torque.x, torque.y, torque.z]
        }))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<ExternalWrench>, D::Error> {
        let wrenches = Vec::<[f64; 6]>::deserialize(deserializer)?.into_iter();
        let wrench = |[fx, fy, fz, tx, ty, tz]: [f64; 6]| ExternalWrench {
            force: Vector3::new(fx, fy, fz),
            torque: Vector3::new(tx, ty, tz),
        };
        Ok(wrenches.map(wrench).collect())
    }
}

/// The results of the analyses that were requested.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Analysis {
    pub robustness: Option<Robustness>,
    /// One region for each contact; `None` also without force closure.
    pub independent_regions: Option<Vec<IndependentRegion>>,
    pub task_quality: Option<TaskQuality>,
    /// The [`task_quality`] of the force along gravity.
    pub gravity_quality: Option<f64>,
}

/// Analyses grasps on one mesh under one model. The structures that depend on the mesh alone are built for
/// the first grasp that needs them.
pub struct Analyst<'a> {
    mesh: &'a Mesh,
    model: &'a WrenchModel,
    closure_floor: f64,
    settings: &'a AnalysisSettings,
    projector: OnceLock<Projector<'a>>,
    places: OnceLock<Places<'a>>,
}

/// Returns the content of the cell, made first if the cell is empty.
fn ready<T, E>(cell: &OnceLock<T>, make: impl FnOnce() -> Result<T, E>) -> Result<&T, E> {
    if let Some(made) = cell.get() {
        return Ok(made);
    }
    let made = make()?;
    Ok(cell.get_or_init(|| made))
}

impl<'a> Analyst<'a> {
    /// Prepares the analyses. A margin above `closure_floor` counts as force closure.
    ///
    /// # Errors
    /// [`Mismatch::Sigma`] when contacts are to be scattered by more than the size of the mesh.
    pub fn new(
        mesh: &'a Mesh,
        model: &'a WrenchModel,
        closure_floor: f64,
        settings: &'a AnalysisSettings,
    ) -> Result<Self, Mismatch> {
        if let Some(Scatter { sigma, .. }) = settings.robustness {
            let radii = sigma / mesh.report().bounding_radius;
            if radii > 1.0 {
                return Err(Mismatch::Sigma { radii });
            }
        }
        Ok(Self {
            mesh,
            model,
            closure_floor,
            settings,
            projector: OnceLock::new(),
            places: OnceLock::new(),
        })
    }

    /// Whether [`analyse`](Self::analyse) has anything to do, given whether the grasp is force closure.
    pub fn has_work(&self, force_closure: bool) -> bool {
        let AnalysisSettings {
            robustness,
            regions,
            tasks,
            gravity,
        } = self.settings;
        robustness.is_some()
            || (regions.is_some() && force_closure)
            || !tasks.is_empty()
            || gravity.is_some()
    }

    /// Analyses one grasp, on the current rayon pool; `closed` is its margin if it is force closure.
    ///
    /// The same on any number of threads. `interrupt` is checked many times a second.
    pub fn analyse(
        &self,
        sites: &[Site],
        closed: Option<&Margin>,
        interrupt: Interrupt<'_>,
    ) -> Result<Analysis, Interrupted> {
        let AnalysisSettings {
            robustness: scatter,
            regions,
            tasks,
            gravity,
        } = self.settings;
        let (mesh, model, floor) = (self.mesh, self.model, self.closure_floor);
        let mut found = Analysis::default();
        if let Some(scatter) = scatter {
            let made = || Projector::interruptible(mesh, interrupt);
            let projector = ready(&self.projector, made)?;
            found.robustness = Some(robustness(
                model, projector, sites, floor, scatter, interrupt,
            )?);
        }
        if let (Some(fraction), Some(margin)) = (regions, closed) {
            let places = ready(&self.places, || Places::new(mesh, interrupt))?;
            found.independent_regions = Some(independent_regions(
                places, model, sites, margin, floor, *fraction, interrupt,
            )?);
        }
        let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
        let epsilon = closed.map_or(0.0, |margin| margin.value);
        let resisted = task_quality(model, &contacts, tasks, epsilon, interrupt)?;
        found.task_quality = TaskQuality::new(resisted);
        if let Some(direction) = gravity {
            let weight = ExternalWrench {
                force: *direction,
                torque: Vector3::zeros(),
            };
            found.gravity_quality =
                task_quality(model, &contacts, &[weight], epsilon, interrupt)?.pop();
        }
        Ok(found)
    }
}
