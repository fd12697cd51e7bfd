//! The promises of the contract, each tested against both engines.

mod batches;
mod bench;
mod earlier;
mod keys;
mod leases;
mod lists;
mod meshes;
mod retention;
mod submissions;
mod turns;
mod webhooks;

use std::collections::HashSet;

use serde_json::value::to_raw_value;

use super::*;
use crate::wire::{JobId, JobRecord, JobState, MeshId, Priority, Problem, Progress};
pub use bench::Bench;
use graspd_core::mesh::MeshReport;
use graspd_core::search::Phase;
use graspd_mesh_io::MeshFormat;

/// Makes a test of each engine out of each of these functions.
macro_rules! contract {
    ($($subject:ident: $($promise:ident),+;)+) => {
        mod sqlite {
            $($(
                #[tokio::test(flavor = "multi_thread")]
                async fn $promise() {
                    super::$subject::$promise(super::Bench::folder().await).await;
                }
            )+)+
        }
        mod postgres {
            $($(
                #[tokio::test(flavor = "multi_thread")]
                async fn $promise() {
                    super::$subject::$promise(super::Bench::database().await).await;
                }
            )+)+
        }
    };
}

contract! {
    batches: a_batch_is_queued_as_one_and_counted, a_batch_that_cannot_be_queued_leaves_nothing,
        a_batch_is_stopped_and_forgotten_as_one, batches_belong_to_their_owners,
        results_come_in_order_and_by_piece, a_batch_expires_with_the_last_of_its_jobs,
        a_key_makes_one_batch;
    keys: a_key_is_good_until_it_expires_or_is_revoked, what_is_no_key_lets_nobody_in,
        owners_share_a_file_and_nothing_else, quotas_bound_each_owner_alone;
    leases: every_job_is_claimed_once_and_in_order,
        a_job_survives_two_crashes_and_fails_at_the_third, a_cancellation_outlives_a_crash,
        a_stale_lease_changes_nothing, a_cancelled_run_keeps_what_it_found_and_an_ended_one_stays,
        a_job_put_back_loses_neither_attempt_nor_place, times_stay_in_order_when_the_clock_is_set_back,
        illegal_transitions_are_refused_whoever_asks,
        a_lease_that_is_renewed_is_held_until_its_job_is_stopped, revisions_are_those_of_the_records;
    lists: the_queue_never_holds_more_than_its_capacity, jobs_are_counted_in_each_state,
        pages_are_complete_and_without_duplicates;
    meshes: a_mesh_is_kept_once_and_read_back_to_the_byte,
        a_mesh_in_use_stays_and_a_refused_job_takes_its_mesh_along;
    retention: ended_jobs_and_unused_meshes_go_and_the_rest_stays, a_mesh_that_is_used_does_not_expire,
        thousands_expire_in_one_sweep;
    submissions: a_key_makes_one_job_across_a_restart, a_refused_submission_leaves_its_key_free,
        a_key_is_free_again_after_a_day;
    turns: owners_take_turns_however_much_one_submits, who_has_fewer_running_goes_first,
        each_class_goes_first_in_its_turn_and_never_makes_the_other_wait_for_nothing,
        jobs_of_one_owner_and_class_keep_the_order_of_submission;
    webhooks: every_end_of_a_job_is_to_be_delivered_and_nothing_else,
        a_delivery_is_in_one_hand_until_its_lease_is_over,
        what_failed_waits_for_its_time_or_is_given_up,
        hosts_that_are_busy_are_passed_over_and_forgotten_jobs_are_not_delivered;
}

pub fn new_mesh() -> NewMesh {
    let report: MeshReport = serde_json::from_value(serde_json::json!({
        "vertices_read": 8, "triangles_read": 12, "vertices": 8, "triangles": 12,
        "degenerate_triangles": 0, "components": 1, "flipped_triangles": 0, "border_edges": 0,
        "non_manifold_edges": 0, "watertight": true, "mass_from": "solid", "volume": 1.0,
        "area": 6.0, "center_of_mass": [0.0, 0.0, 0.0],
        "bounds": [[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]], "bounding_radius": 0.87,
        "candidates": 12, "area_ratio": 1.0
    }))
    .unwrap();
    NewMesh {
        owner: Owner::ANONYMOUS,
        max_owner_bytes: None,
        format: MeshFormat::Stl,
        units: None,
        scale: 1.0,
        file_name: Some("box.stl".to_owned()),
        report,
    }
}

pub fn new_job(capacity: u32) -> NewJob {
    NewJob {
        owner: Owner::ANONYMOUS,
        request: "{}".to_owned(),
        label: None,
        priority: Priority::Interactive,
        capacity,
        owner_capacity: None,
        submission: None,
    }
}

pub async fn receive(store: &dyn Store, bytes: &[u8]) -> Received {
    let mut upload = store.begin_upload().await.unwrap();
    for piece in bytes.chunks(3) {
        upload.write(piece).await.unwrap();
    }
    upload.finish().await.unwrap()
}

pub async fn add_mesh(store: &dyn Store, bytes: &[u8]) -> MeshId {
    let received = receive(store, bytes).await;
    let added = store.add_mesh(received, &new_mesh()).await.unwrap();
    added.unwrap().0.id
}

pub async fn submit(store: &dyn Store, mesh: &MeshId) -> JobRecord {
    store.submit(mesh, &new_job(1000)).await.unwrap().unwrap()
}

/// Takes the next job off the queue.
pub async fn claim(store: &dyn Store) -> Claim {
    let claim = store.claim(Priority::Interactive).await.unwrap();
    claim.expect("a job that waits")
}

pub async fn job(store: &dyn Store, id: JobId) -> JobRecord {
    store.job(&Owner::ANONYMOUS, id).await.unwrap().unwrap()
}

pub fn progress() -> Progress {
    Progress {
        phase: Phase::Search,
        generation: 3,
        generations: 30,
        evaluations: 1200,
        best_quality: Some(0.1),
        best_contacts: None,
        elapsed_s: 0.5,
    }
}

pub fn found() -> RunOutcome {
    RunOutcome::Result(to_raw_value(&serde_json::json!({"quality": 0.1})).unwrap())
}

pub fn exhausted() -> Problem {
    Problem::new(500, "interrupted", "Interrupted too often", "three times")
}
