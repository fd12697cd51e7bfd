//! A job that has ended, with its result: what pictures and exports are made of.

use crate::http::app::App;
use crate::http::response::error::Error;
use crate::http::response::json::POLL_S;
use crate::jobs::{self, Owner};
use crate::wire::{Chosen, ChosenGrasp, JobRecord, JobState, PlanResult};
use graspd_core::mesh::Mesh;

/// Bytes of a result from which on parsing it would keep other requests waiting.
const LARGE: usize = 1 << 16;

/// A job that has ended, with its result.
pub struct JobResult {
    /// The job without the result.
    pub record: JobRecord,
    pub result: PlanResult,
}

impl JobResult {
    /// Reads a job and its result. Refuses with 409 a job without one, with Retry-After where it may come
    /// to have one.
    pub async fn of(app: &App, owner: &Owner, id: &str) -> Result<Self, Error> {
        let mut record = app.service.job(owner, id).await?;
        if !record.state.is_final() {
            return Err(Error::conflict("this job has not ended yet").retry_after(POLL_S));
        }
        let Some(result) = record.result.take() else {
            return Err(Error::conflict(match record.state {
                JobState::Failed => "this job failed; its problem says why",
                _ => "this job was cancelled before anything was found",
            }));
        };
        let is_large = result.get().len() > LARGE;
        let parse = move || serde_json::from_str(result.get());
        let result = match is_large {
            false => parse(),
            true => tokio::task::spawn_blocking(parse)
                .await
                .map_err(Error::internal)?,
        };
        Ok(Self {
            record,
            result: result.map_err(Error::internal)?,
        })
    }

    /// Returns a grasp of the result, or refuses with 409 one that it does not have.
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

    /// Returns the label of the job, or a name made of its id.
    pub fn title(&self) -> String {
        let label = self.record.label.clone();
        label.unwrap_or_else(|| format!("Job {}", self.record.id))
    }

    /// Calls `make` with the mesh of the job on a thread that may block; `pixels` is what it draws. Refuses
    /// with 410 when the mesh was deleted.
    pub async fn with_mesh<T: Send + 'static>(
        self,
        app: &App,
        owner: &Owner,
        pixels: u64,
        make: impl FnOnce(&Mesh, &Self) -> T + Send + 'static,
    ) -> Result<T, Error> {
        let id = self.record.mesh_id.clone();
        let made = app
            .service
            .draw(owner, &id, pixels, move |mesh| make(mesh, &self));
        match made.await {
            Err(jobs::Error::NotFound) => Err(Error::gone(
                "the mesh of this job has been deleted; its result and its tables can still be read",
            )),
            made => Ok(made?),
        }
    }
}
