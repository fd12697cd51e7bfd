//! The work on a mesh, from its file to its result.

use std::fs::File;
use std::io::{self, Read};
use std::time::{Duration, Instant};

use axum::body::{Body, Bytes};
use axum::http::header::{CONTENT_LENGTH, CONTENT_TYPE};
use axum::http::{Method, StatusCode};
use futures_util::stream::{self, StreamExt, TryStreamExt};
use parking_lot::Mutex;
use serde::Deserialize;
use serde_json::Value;
use sha2::{Digest, Sha256};
use tokio::io::AsyncReadExt;
use tokio::sync::Semaphore;
use tokio_util::io::ReaderStream;
use uuid::Uuid;

use super::error::BatchError;
use super::folder::Folder;
use super::journal::{End, Journal, MeshProgress, Outcome, ResultSummary};
use super::report::{Board, Row};
use super::server::{ANSWER_TIME, Answer, Call, Server};
use crate::wire::{JobState, Problem, text};

/// Number of meshes that are sent at a time.
const UPLOADS: usize = 4;
/// An upload may take as long as any answer, and one second more for each of so many bytes.
const BYTES_PER_SECOND: u64 = 64 * 1024;
/// Number of bytes that are read at a time.
const PIECE_BYTES: usize = 64 * 1024;
/// How often a mesh is sent if its jobs are deleted or expire before their results are read.
const ATTEMPTS: u32 = 3;
/// Most characters of a label, and of a file name, that the server accepts.
const LABEL_CHARS: usize = 200;
/// Seconds for which the server may delay its answer until the job has ended.
const WAIT_S: u32 = 20;
/// Pause after an answer that was not delayed, such as that of a server that is shutting down.
const PAUSE: Duration = Duration::from_millis(500);

/// A mesh file and the name of its result.
pub struct Item {
    /// The path as given.
    pub file: String,
    /// The absolute path.
    pub path: String,
    /// The name of its result.
    pub output: String,
}

/// What the work on each mesh needs.
pub struct Run {
    pub folder: Folder,
    pub journal: Mutex<Journal>,
    pub server: Server,
    /// The settings of each job, except its label.
    pub settings: Value,
}

/// The members of a job that are used here.
#[derive(Deserialize)]
struct Job {
    id: String,
    state: JobState,
    problem: Option<Problem>,
}

/// The outcome of sending a mesh.
enum Submission {
    Job(String),
    /// It was sent before, and its job no longer exists.
    Gone,
    /// It cannot be read or is refused.
    NotAccepted(Outcome),
}

/// Plans all meshes, `in_flight` at a time, and returns their outcomes in order.
pub async fn plan_all(
    run: &Run,
    items: Vec<Item>,
    in_flight: usize,
    board: &Board,
) -> Result<Vec<Row>, BatchError> {
    let uploads = Semaphore::new(UPLOADS);
    let uploads = &uploads;
    let rows = stream::iter(items.into_iter().enumerate())
        .map(|(place, item)| async move {
            let (outcome, is_new) = run.plan(&item, uploads).await?;
            let row = Row {
                file: item.file,
                output: item.output,
                outcome,
            };
            board.ended(&row, is_new);
            Ok((place, row))
        })
        .buffer_unordered(in_flight);
    let mut rows: Vec<(usize, Row)> = rows.try_collect().await?;
    rows.sort_by_key(|(place, _)| *place);
    Ok(rows.into_iter().map(|(_, row)| row).collect())
}

impl Run {
    /// Plans a mesh and returns its outcome, and whether it was reached in this run.
    async fn plan(&self, item: &Item, uploads: &Semaphore) -> Result<(Outcome, bool), BatchError> {
        let path = item.path.clone();
        let hashed = tokio::task::spawn_blocking(move || hash(&path)).await;
        let sha256 = match hashed.map_err(io::Error::other).flatten() {
            Ok(sha256) => sha256,
            Err(fault) => return Ok((unreadable(&fault), true)),
        };
        let before = self.journal.lock().progress(&item.output).cloned();
        // The file may have changed since.
        let before = before.filter(|before| before.sha256 == sha256);
        let (mut attempt, mut job) = (1, None);
        if let Some(MeshProgress {
            attempt: last,
            job: known,
            outcome,
            ..
        }) = before
        {
            if let Some(outcome) = outcome
                && (outcome.found.is_none() || self.folder.path(&item.output).exists())
            {
                return Ok((outcome, false));
            }
            (attempt, job) = (last, known);
        }
        let last = attempt + ATTEMPTS;
        while attempt < last {
            let id = match job.take() {
                Some(id) => id,
                None => {
                    let permit = uploads.acquire().await;
                    let sent = self.submit(item, &sha256, attempt).await?;
                    drop(permit);
                    match sent {
                        Submission::Job(id) => {
                            let mut journal = self.journal.lock();
                            let noted = journal.submitted(&item.output, &sha256, attempt, &id);
                            noted.map_err(BatchError::Unwritable)?;
                            id
                        }
                        Submission::Gone => {
                            attempt += 1;
                            continue;
                        }
                        Submission::NotAccepted(outcome) => {
                            if outcome.state != End::Unreadable {
                                self.record_end(item, &sha256, &outcome)?;
                            }
                            return Ok((outcome, true));
                        }
                    }
                }
            };
            if let Some(outcome) = self.follow(item, &id).await? {
                self.record_end(item, &sha256, &outcome)?;
                return Ok((outcome, true));
            }
            attempt += 1;
        }
        let problem = "its jobs were deleted, or expired, before their results could be read";
        Ok((without_result(End::Failed, problem.to_owned()), true))
    }

    fn record_end(&self, item: &Item, sha256: &str, outcome: &Outcome) -> Result<(), BatchError> {
        let noted = self.journal.lock().ended(&item.output, sha256, outcome);
        noted.map_err(BatchError::Unwritable)
    }

    /// Sends a mesh. All submissions of the same attempt, also those of earlier runs, make one job.
    async fn submit(
        &self,
        item: &Item,
        sha256: &str,
        attempt: u32,
    ) -> Result<Submission, BatchError> {
        let what = Sha256::digest(format!("{}\n{sha256}\n{attempt}", item.output));
        let key = format!("{}-{}", self.journal.lock().run, hexadecimal(&what[..16]));
        let name = item.path.rsplit('/').next().unwrap_or(&item.path);
        let name: String = name
            .chars()
            .filter(|c| !text::is_unsafe(*c))
            .take(LABEL_CHARS)
            .collect();
        let mut settings = self.settings.clone();
        settings["label"] = name.as_str().into();
        let settings = settings.to_string();
        let boundary = Uuid::new_v4().simple().to_string();
        let head = format!(
            "--{boundary}\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{settings}\r\n\
             --{boundary}\r\nContent-Disposition: form-data; name=\"mesh\"; filename=\"{}\"\r\n\
             Content-Type: application/octet-stream\r\n\r\n",
            name.replace('"', "%22")
        );
        let tail = format!("\r\n--{boundary}--\r\n");
        let call = async || {
            let file = tokio::fs::File::open(&item.path).await?;
            let bytes = file.metadata().await?.len();
            let piece = |text: &str| stream::iter([Ok(Bytes::from(text.to_owned()))]);
            // Send no more than Content-Length, should the file grow.
            let mesh = ReaderStream::with_capacity(file.take(bytes), PIECE_BYTES);
            let request = self
                .server
                .request(Method::POST, "/jobs")
                .header("idempotency-key", &key)
                .header(
                    CONTENT_TYPE,
                    format!("multipart/form-data; boundary={boundary}"),
                )
                .header(CONTENT_LENGTH, bytes + (head.len() + tail.len()) as u64)
                .body(Body::from_stream(
                    piece(&head).chain(mesh).chain(piece(&tail)),
                ));
            Ok(Call {
                request: request.map_err(io::Error::other)?,
                time: ANSWER_TIME + Duration::from_secs(bytes / BYTES_PER_SECOND),
            })
        };
        let answer = match self.server.send(call).await? {
            Ok(answer) => answer,
            Err(fault) => return Ok(Submission::NotAccepted(unreadable(&fault))),
        };
        match answer.status.as_u16() {
            202 => Ok(Submission::Job(parsed::<Job>(&answer)?.id)),
            410 => Ok(Submission::Gone),
            400 | 413 | 415 | 422 | 500 => Ok(Submission::NotAccepted(without_result(
                End::Refused,
                answer.message(),
            ))),
            _ => Err(BatchError::Refused(answer.message())),
        }
    }

    /// Waits for the end of a job and writes its result, if it has one. Returns `None` if the job no longer exists.
    async fn follow(&self, item: &Item, id: &str) -> Result<Option<Outcome>, BatchError> {
        let job = loop {
            let start = Instant::now();
            let answer = self.read(&format!("/jobs/{id}?wait={WAIT_S}")).await?;
            match answer.status {
                StatusCode::OK => {}
                StatusCode::NOT_FOUND | StatusCode::GONE => return Ok(None),
                _ => return Err(BatchError::Refused(answer.message())),
            }
            let job: Job = parsed(&answer)?;
            if job.state.is_final() {
                break job;
            }
            if start.elapsed() < PAUSE {
                tokio::time::sleep(PAUSE).await;
            }
        };
        let state = match job.state {
            JobState::Failed => End::Failed,
            JobState::Cancelled => End::Cancelled,
            _ => End::Succeeded,
        };
        let answer = self.read(&format!("/jobs/{id}/result")).await?;
        match answer.status {
            StatusCode::OK => {
                let found: ResultSummary = parsed(&answer)?;
                let written = self.folder.write(&item.output, &answer.body);
                written.map_err(BatchError::Unwritable)?;
                Ok(Some(Outcome {
                    state,
                    found: Some(found),
                    problem: None,
                }))
            }
            StatusCode::CONFLICT => {
                let why = job.problem.map_or_else(
                    || "cancelled before a grasp was found".to_owned(),
                    |problem| format!("{}: {}", problem.title, problem.detail),
                );
                Ok(Some(without_result(state, why)))
            }
            StatusCode::NOT_FOUND | StatusCode::GONE => Ok(None),
            _ => Err(BatchError::Refused(answer.message())),
        }
    }

    async fn read(&self, path: &str) -> Result<Answer, BatchError> {
        let answer = self.server.send(async || self.server.get(path)).await?;
        answer.map_err(|fault| BatchError::Refused(fault.to_string()))
    }
}

fn parsed<'a, T: Deserialize<'a>>(answer: &'a Answer) -> Result<T, BatchError> {
    serde_json::from_slice(&answer.body).map_err(|fault| {
        BatchError::Refused(format!(
            "the answer is not that of a graspd server: {fault}"
        ))
    })
}

fn without_result(state: End, problem: String) -> Outcome {
    Outcome {
        state,
        found: None,
        problem: Some(problem),
    }
}

fn unreadable(fault: &io::Error) -> Outcome {
    without_result(End::Unreadable, fault.to_string())
}

/// Returns the SHA-256 of a file. Blocks.
fn hash(path: &str) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut piece = vec![0; 64 * 1024];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(hexadecimal(&hash.finalize())),
            length => hash.update(&piece[..length]),
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
