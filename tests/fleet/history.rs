//! Who ran what, and when, by the logs of the workers.

use std::path::PathBuf;

use jiff::{SignedDuration, Timestamp};
use serde_json::Value;

/// A worker takes a job up, or leaves it.
#[derive(Debug, Clone)]
pub struct Step {
    pub at: Timestamp,
    /// Number of the worker.
    pub worker: usize,
    pub job: String,
    pub begins: bool,
}

/// What the workers have done, in the order of time. `logs` are theirs.
pub fn steps(logs: &[PathBuf]) -> Vec<Step> {
    let mut steps = Vec::new();
    for (worker, log) in logs.iter().enumerate() {
        let text = std::fs::read(log).expect("a log");
        let text = String::from_utf8_lossy(&text);
        // A line that a kill cut off is none.
        let lines = text
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok());
        steps.extend(lines.filter_map(|line: Value| {
            let begins = match line["message"].as_str()? {
                "job starts" => true,
                "job leaves its worker" => false,
                _ => return None,
            };
            Some(Step {
                at: line["timestamp"].as_str()?.parse().ok()?,
                worker,
                job: line["job"].as_str()?.to_owned(),
                begins,
            })
        }));
    }
    steps.sort_by_key(|step| step.at);
    steps
}

/// The job that a worker has at a moment; one that another has begun since is no longer its own.
pub fn holds(steps: &[Step], worker: usize, at: Timestamp) -> Option<&str> {
    let mut past = steps.iter().rev().skip_while(|step| step.at > at);
    let last = past.clone().find(|step| step.worker == worker)?;
    let owner = past.find(|step| step.job == last.job && step.begins)?;
    (last.begins && owner.worker == worker).then_some(last.job.as_str())
}

/// From a moment at which a worker was lost to the moment at which its job began again; `None` when it had none,
/// or that never did, since it had ended or was called off.
pub fn restart(steps: &[Step], worker: usize, lost: Timestamp) -> Option<SignedDuration> {
    let job = holds(steps, worker, lost)?;
    let again = steps
        .iter()
        .find(|step| step.at > lost && step.job == job && step.begins)?;
    Some(again.at.duration_since(lost))
}

#[test]
fn a_restart_is_counted_from_the_loss_to_the_next_beginning() {
    let step = |second, worker, job: &str, begins| Step {
        at: Timestamp::from_second(second).unwrap(),
        worker,
        job: job.to_owned(),
        begins,
    };
    let steps = [
        step(1, 0, "a", true),
        step(2, 1, "b", true),
        step(3, 0, "a", false),
        step(14, 0, "b", true),
    ];
    let lost = |worker, second| restart(&steps, worker, Timestamp::from_second(second).unwrap());
    assert_eq!(lost(1, 4), Some(SignedDuration::from_secs(10)));
    assert_eq!(lost(0, 2), None, "it never began again");
    assert_eq!(lost(0, 4), None, "it had left its job");
    assert_eq!(lost(1, 20), None, "another had its job by then");
    assert_eq!(lost(1, 1), None, "it had none yet");
}
