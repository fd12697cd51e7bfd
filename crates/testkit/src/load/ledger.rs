//! A ledger of what the server has acknowledged to the clients, and of what they have seen.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard};

use serde_json::Value;

/// A job that a client knows of.
#[derive(Debug, Default, Clone)]
pub struct Job {
    /// Its Idempotency-Key, which is its label too.
    pub key: String,
    /// Which order it carries out.
    pub order: usize,
    pub cancel_asked: bool,
    pub delete_asked: bool,
    pub deleted: bool,
    /// The job as it was first read after its end.
    pub ended: Option<Value>,
}

/// Jobs by id, and what went wrong.
#[derive(Debug, Default)]
pub struct Ledger {
    jobs: Mutex<HashMap<String, Job>>,
    faults: Mutex<Vec<String>>,
}

impl Ledger {
    pub fn jobs(&self) -> MutexGuard<'_, HashMap<String, Job>> {
        self.jobs.lock().expect("a whole ledger")
    }

    pub fn fault(&self, what: impl Into<String>) {
        self.faults
            .lock()
            .expect("a whole ledger")
            .push(what.into());
    }

    /// The faults found so far.
    pub fn faults(&self) -> Vec<String> {
        self.faults.lock().expect("a whole ledger").clone()
    }

    /// Whether some client has read that a job has ended.
    pub fn has_ended(&self, id: &str) -> bool {
        self.jobs().get(id).is_some_and(|job| job.ended.is_some())
    }

    /// Takes note of a job as a client read it; once it has ended it must never change again. `had_ended` is
    /// what was known before the client asked: another may have read a later state meanwhile.
    pub fn saw(&self, id: &str, had_ended: bool, view: &Value) {
        if lives(view) {
            if had_ended {
                self.fault(format!("job {id} lives again: {view}"));
            }
            return;
        }
        let mut jobs = self.jobs();
        let Some(job) = jobs.get_mut(id) else { return };
        let before = job.ended.get_or_insert_with(|| view.clone());
        let mut before = before.clone();
        drop(jobs);
        // The mesh of an ended job may be forgotten, and its report with it.
        let mut now = view.clone();
        for view in [&mut before, &mut now] {
            if let Some(object) = view.as_object_mut() {
                object.remove("mesh_report");
            }
        }
        if before != now {
            self.fault(format!(
                "job {id} changed after its end: {before} became {now}"
            ));
        }
    }
}

/// Whether a job, as it was read, waits or runs.
pub fn lives(view: &Value) -> bool {
    ["queued", "running"].contains(&view["state"].as_str().unwrap_or_default())
}
