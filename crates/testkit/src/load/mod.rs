//! Clients that use every operation of a service until they are stopped, and what it promised them.

pub mod client;
pub mod ledger;
pub mod oracle;
pub mod random;
pub mod verdict;

use std::sync::Arc;
use std::time::Duration;

use reqwest::Method;
use serde_json::{Value, json};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::stl::cuboid;
use client::{Answer, Body, Caller};
use ledger::{Job, Ledger};
use oracle::Order;
use random::SplitMix64;

const CLIENTS: u64 = 8;

/// How much the clients want.
pub struct Habits {
    /// How long jobs are, the shortest being 1.
    pub size: usize,
    /// Mean pause of a client between two wishes, of which every other one is a job.
    pub pause: Duration,
    /// Longest time that a client waits for a server before it sends the request again.
    pub patience: Duration,
}

impl Default for Habits {
    fn default() -> Self {
        Self {
            size: 1,
            pause: Duration::from_millis(120),
            patience: Duration::from_secs(20),
        }
    }
}

/// The clients of the servers, and what they have been promised.
pub struct Load {
    pub ledger: Arc<Ledger>,
    pub orders: Arc<Vec<Order>>,
    pub caller: Caller,
    pause: Duration,
    urls: watch::Sender<Vec<String>>,
    stop: CancellationToken,
    clients: JoinSet<()>,
}

impl Load {
    /// Everything but a server.
    pub fn prepare(habits: &Habits) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let orders = oracle::orders(folder.path(), habits.size);
        let (urls, watcher) = watch::channel(Vec::new());
        Self {
            ledger: Arc::default(),
            orders: Arc::new(orders),
            caller: Caller::new(watcher, habits.patience),
            pause: habits.pause,
            urls,
            stop: CancellationToken::new(),
            clients: JoinSet::new(),
        }
    }

    /// Changes where the clients look for the servers.
    pub fn serve_at(&self, urls: &[&str]) {
        let urls = urls.iter().map(|url| (*url).to_owned()).collect();
        self.urls.send_replace(urls);
    }

    /// Starts the clients.
    pub fn start(&mut self, random: &mut SplitMix64) {
        for _ in 0..CLIENTS {
            let client = Visitor {
                caller: self.caller.clone(),
                ledger: Arc::clone(&self.ledger),
                orders: Arc::clone(&self.orders),
                random: SplitMix64::new(random.next_u64()),
                pause: self.pause,
            };
            self.clients.spawn(client.visit(self.stop.clone()));
        }
    }

    /// Waits until every client has finished what it does.
    pub async fn stop(&mut self) {
        self.stop.cancel();
        while let Some(ended) = self.clients.join_next().await {
            if let Err(fault) = ended {
                self.ledger.fault(format!("a client panicked: {fault}"));
            }
        }
    }
}

/// One client.
struct Visitor {
    caller: Caller,
    ledger: Arc<Ledger>,
    orders: Arc<Vec<Order>>,
    random: SplitMix64,
    pause: Duration,
}

impl Visitor {
    async fn visit(mut self, stop: CancellationToken) {
        while !stop.is_cancelled() {
            let outcome = match self.random.below(100) {
                0..50 => self.submit().await,
                50..60 => self.cancel().await,
                60..66 => self.delete().await,
                66..74 => self.list().await,
                74..80 => self.evaluate().await,
                80..86 => self.come_and_go().await,
                _ => self.read().await,
            };
            if let Err(fault) = outcome {
                self.ledger.fault(fault);
            }
            // From a sixth to eleven sixths of the mean.
            let share = self.random.below(1000) as f64 / 1000.0;
            let pause = self.pause.mul_f64(1.0 / 6.0 + share * 5.0 / 3.0);
            tokio::time::sleep(pause).await;
        }
    }

    /// The id of the mesh of an order; uploading it again changes nothing.
    async fn mesh(&self, bytes: &[u8]) -> Result<String, String> {
        let answer = self
            .call(Method::POST, "/meshes", &Body::Mesh(bytes))
            .await?;
        expect(&answer, &[200, 201])?;
        Ok(text(&answer.body, "id"))
    }

    async fn submit(&mut self) -> Result<(), String> {
        let number = self.random.below(self.orders.len());
        let order = &self.orders[number];
        let key = format!("key-{:016x}", self.random.next_u64());
        let mut request = order.request.clone();
        request["label"] = key.as_str().into();
        let answer = if self.random.below(2) == 0 {
            request["mesh_id"] = self.mesh(&order.mesh).await?.into();
            let body = Body::Json(&request, Some(&key));
            self.call(Method::POST, "/jobs", &body).await?
        } else {
            let mesh = headed(&order.mesh, &key);
            let body = Body::Form(&request, &mesh, &key);
            self.call(Method::POST, "/jobs", &body).await?
        };
        expect(&answer, &[202])?;
        let job = Job {
            key,
            order: number,
            ..Job::default()
        };
        self.ledger.jobs().insert(text(&answer.body, "id"), job);
        Ok(())
    }

    /// One of the youngest jobs that are known.
    fn any(&mut self, among: usize) -> Option<String> {
        let jobs = self.ledger.jobs();
        let mut ids: Vec<&String> = jobs
            .iter()
            .filter(|(_, job)| !job.delete_asked)
            .map(|(id, _)| id)
            .collect();
        // A map has no order that a seed repeats.
        ids.sort();
        let first = ids.len().saturating_sub(among);
        let ids = &ids[first..];
        (!ids.is_empty()).then(|| ids[self.random.below(ids.len())].clone())
    }

    fn note(&self, id: &str, note: impl FnOnce(&mut Job)) {
        if let Some(job) = self.ledger.jobs().get_mut(id) {
            note(job);
        }
    }

    async fn cancel(&mut self) -> Result<(), String> {
        let Some(id) = self.any(6) else { return Ok(()) };
        // Before it is sent: it may be done although no answer comes back.
        self.note(&id, |job| job.cancel_asked = true);
        let path = format!("/jobs/{id}/cancel");
        let answer = self.call(Method::POST, &path, &Body::Nothing).await?;
        self.expect_known(&id, &answer, &[200, 202])
    }

    async fn delete(&mut self) -> Result<(), String> {
        let Some(id) = self.any(30) else {
            return Ok(());
        };
        self.note(&id, |job| job.delete_asked = true);
        let path = format!("/jobs/{id}");
        let answer = self.call(Method::DELETE, &path, &Body::Nothing).await?;
        // Two clients may have chosen the same, or the first answer was lost.
        expect(&answer, &[204, 404])?;
        self.note(&id, |job| job.deleted = true);
        Ok(())
    }

    async fn read(&mut self) -> Result<(), String> {
        let Some(id) = self.any(usize::MAX) else {
            return Ok(());
        };
        let path = format!("/jobs/{id}");
        let had_ended = self.ledger.has_ended(&id);
        let answer = self.call(Method::GET, &path, &Body::Nothing).await?;
        self.expect_known(&id, &answer, &[200])?;
        if answer.status == 200 {
            self.ledger.saw(&id, had_ended, &answer.body);
        }
        Ok(())
    }

    async fn list(&mut self) -> Result<(), String> {
        let state = ["queued", "running", "succeeded", "failed", "cancelled"][self.random.below(5)];
        let path = format!("/jobs?state={state}&limit=20");
        let answer = self.call(Method::GET, &path, &Body::Nothing).await?;
        expect(&answer, &[200])
    }

    async fn evaluate(&mut self) -> Result<(), String> {
        let number = self.random.below(self.orders.len());
        let mesh = self.mesh(&self.orders[number].mesh).await?;
        let grasps = json!({"mesh_id": mesh, "grasps": [[{"triangle": 1}, {"triangle": 40}, {"triangle": 99}]]});
        let answer = self
            .call(Method::POST, "/evaluations", &Body::Json(&grasps, None))
            .await?;
        expect(&answer, &[200])
    }

    /// A mesh of its own, uploaded and forgotten.
    async fn come_and_go(&mut self) -> Result<(), String> {
        let bytes = cuboid([1.0, 1.0, 1.0 + self.random.below(1 << 20) as f32 / 1e6], 3);
        let id = self.mesh(&bytes).await?;
        let path = format!("/meshes/{id}");
        let answer = self.call(Method::DELETE, &path, &Body::Nothing).await?;
        let gone: &[u16] = if answer.tries > 1 {
            &[204, 404]
        } else {
            &[204]
        };
        expect(&answer, gone)
    }

    async fn call(&self, method: Method, path: &str, body: &Body<'_>) -> Result<Answer, String> {
        self.caller.call(method, path, body).await
    }

    /// As [`expect`], and 404 if someone has asked to delete the job.
    fn expect_known(&self, id: &str, answer: &Answer, good: &[u16]) -> Result<(), String> {
        let deleted = self
            .ledger
            .jobs()
            .get(id)
            .is_some_and(|job| job.delete_asked);
        if answer.status == 404 && deleted {
            return Ok(());
        }
        expect(answer, good).map_err(|fault| format!("job {id}: {fault}"))
    }
}

/// Fails unless the status is one of `good`.
pub fn expect(answer: &Answer, good: &[u16]) -> Result<(), String> {
    match good.contains(&answer.status) {
        true => Ok(()),
        false => Err(format!(
            "{} instead of {good:?}: {}",
            answer.status, answer.body
        )),
    }
}

/// A binary STL that another has the same triangles as, but not the same bytes.
fn headed(mesh: &[u8], head: &str) -> Vec<u8> {
    let mut mesh = mesh.to_vec();
    mesh[..head.len()].copy_from_slice(head.as_bytes());
    mesh
}

fn text(value: &Value, member: &str) -> String {
    value[member].as_str().unwrap_or_default().to_owned()
}
