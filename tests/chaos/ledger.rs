//! What the clients have been promised, and what they have seen.

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

    /// What went wrong so far.
    pub fn faults(&self) -> Vec<String> {
        self.faults.lock().expect("a whole ledger").clone()
    }

    /// Takes note of a job as a client read it; once it has ended it must never change again.
    pub fn saw(&self, id: &str, view: Value) {
        let state = view["state"].as_str().unwrap_or_default();
        if ["queued", "running"].contains(&state) {
            if self.jobs()[id].ended.is_some() {
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
        let mut now = view;
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
