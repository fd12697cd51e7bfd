//! What an ended job has found, for those who show or export it.

use utoipa::IntoParams;

use super::App;
use super::error::Error;
use super::query::Parameters;
use super::reply::POLL_S;
use crate::jobs::{self, Owner};
use crate::wire::{Chosen, ChosenGrasp, JobRecord, JobState, PlanResult};
use graspd_core::mesh::Mesh;

/// Bytes of a result from which on reading it would keep others waiting.
const LARGE: usize = 1 << 16;

/// A job that has ended, with its result.
pub struct Outcome {
    /// Without the result.
    pub job: JobRecord,
    pub result: PlanResult,
}

impl Outcome {
    /// Refused with 409 while the job has no result, with Retry-After where it may come to have one.
    pub async fn of(app: &App, owner: &Owner, id: &str) -> Result<Self, Error> {
        let mut job = app.service.job(owner, id).await?;
        if !job.state.is_final() {
            return Err(Error::conflict("this job has not ended yet").retry_after(POLL_S));
        }
        let Some(result) = job.result.take() else {
            return Err(Error::conflict(match job.state {
                JobState::Failed => "this job failed; its problem tells why",
                _ => "this job was cancelled before anything was found",
            }));
        };
        let is_large = result.get().len() > LARGE;
        let read = move || serde_json::from_str(result.get());
        let result = match is_large {
            false => read(),
            true => tokio::task::spawn_blocking(read)
                .await
                .map_err(Error::internal)?,
        };
        Ok(Self {
            job,
            result: result.map_err(Error::internal)?,
        })
    }

    /// The grasp that is asked for.
    pub fn grasp(&self, chosen: Chosen) -> Result<ChosenGrasp<'_>, Error> {
        chosen.of(&self.result).ok_or_else(|| {
            let top = self.result.top.as_ref().map_or(1, Vec::len);
            Error::conflict(match chosen {
                Chosen::Best => match &self.result.explanation {
                    Some(explanation) => {
                        format!("the result has no contacts: {}", explanation.detail)
                    }
                    None => "the result has no contacts".to_owned(),
                },
                Chosen::Initial => "no first force-closure grasp was found".to_owned(),
                Chosen::Top(_) => format!(
                    "the result has {top} grasp{}; ask for more with the setting top",
                    if top == 1 { "" } else { "s" }
                ),
            })
        })
    }

    /// What the job is called.
    pub fn title(&self) -> String {
        let label = self.job.label.clone();
        label.unwrap_or_else(|| format!("Job {}", self.job.id))
    }

    /// The entity tag of something made of the result, which does not change any more, by this program.
    pub fn tag(&self, what: &str) -> String {
        format!("\"{}-{what}-{}\"", self.job.id, env!("CARGO_PKG_VERSION"))
    }

    /// What `make` makes of the mesh and this, `pixels` where it is a picture, on a thread that may block. Refused
    /// with 410 when the mesh is gone.
    pub async fn with_mesh<T: Send + 'static>(
        self,
        app: &App,
        owner: &Owner,
        pixels: u64,
        make: impl FnOnce(&Mesh, &Self) -> T + Send + 'static,
    ) -> Result<T, Error> {
        let id = self.job.mesh_id.clone();
        let made = app
            .service
            .draw(owner, &id, pixels, move |mesh| make(mesh, &self));
        match made.await {
            Err(jobs::Error::NotFound) => Err(Error::gone(
                "the mesh of this job has been deleted; its result and its tables are still here",
            )),
            made => Ok(made?),
        }
    }
}

/// How a query names a grasp.
#[derive(IntoParams)]
#[into_params(parameter_in = Query)]
#[allow(dead_code, reason = "only described; the query is read as a Chosen")]
pub struct GraspParameter {
    /// `best` (default), `initial`, or the number of one of the `top` grasps from 1 on
    grasp: Option<String>,
}

/// Which grasp a query means.
pub fn chosen(query: &Parameters) -> Result<Chosen, Error> {
    let chosen = query.parse("grasp", Chosen::NAMES, Chosen::named)?;
    Ok(chosen.unwrap_or_default())
}
