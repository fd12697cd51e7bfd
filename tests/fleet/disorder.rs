//! The great disorder: members killed and frozen, the database restarted, crashed and out of reach, under load.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};
use tempfile::TempDir;
use testkit::environment::number;
use testkit::load::ledger::Ledger;
use testkit::load::random::SplitMix64;
use testkit::load::verdict;
use testkit::load::{Habits, Load};
use testkit::postgres::Cluster;
use testkit::proxy::Proxy;
use tokio::task::{JoinSet, spawn_blocking};

use crate::history::{holds, restart, steps};
use crate::member::{Member, Role};

const SERVERS: usize = 3;
const WORKERS: usize = 6;
/// Jobs that the clients submit a second, together.
const RATE: f64 = 4.0;
/// For so long the database cannot be reached.
const OUTAGE: Duration = Duration::from_secs(20);
/// For so long after an outage it still counts: connections have to be made again.
const AFTERMATH: SignedDuration = SignedDuration::from_secs(5);
/// Longest from the loss of a worker to the moment at which its job begins again.
const RESTART: SignedDuration = SignedDuration::from_secs(15);

/// Every job ends once, and what has ended never changes.
const AUDIT: &str = "
    CREATE TABLE test_ends (job text PRIMARY KEY);
    CREATE TABLE test_late (job text);
    CREATE FUNCTION test_end() RETURNS trigger LANGUAGE plpgsql
        AS $$ BEGIN INSERT INTO test_ends VALUES (NEW.id); RETURN NULL; END $$;
    CREATE FUNCTION test_late() RETURNS trigger LANGUAGE plpgsql
        AS $$ BEGIN INSERT INTO test_late VALUES (NEW.id); RETURN NULL; END $$;
    CREATE TRIGGER test_end AFTER UPDATE ON jobs FOR EACH ROW
        WHEN (OLD.finished_at IS NULL AND NEW.finished_at IS NOT NULL) EXECUTE FUNCTION test_end();
    CREATE TRIGGER test_late AFTER UPDATE ON jobs FOR EACH ROW
        WHEN (OLD.finished_at IS NOT NULL) EXECUTE FUNCTION test_late();
";

/// What is done to a member.
#[derive(Debug, Clone, Copy)]
enum Deed {
    /// SIGKILL, and a new start after a pause.
    Kill(Duration),
    /// SIGSTOP, and SIGCONT after a while.
    Freeze(Duration),
}

/// What is done to the database.
#[derive(Debug, Clone, Copy)]
enum Trouble {
    Restart,
    Crash,
    OutOfReach,
}

/// A worker that was killed or frozen.
#[derive(Debug, Clone, Copy)]
struct Loss {
    worker: usize,
    at: Timestamp,
    killed: bool,
}

/// All processes, and what has been done to them.
struct Scene {
    cluster: Cluster,
    proxy: Proxy,
    database: String,
    /// Workers first.
    members: Vec<Mutex<Member>>,
    /// Of the workers.
    logs: Vec<PathBuf>,
    losses: Mutex<Vec<Loss>>,
    /// When the database was not to be had, from and to.
    outages: Mutex<Vec<(Timestamp, Timestamp)>>,
    /// Where the servers are, or were last.
    urls: Mutex<Vec<String>>,
    _folder: TempDir,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Scene {
    /// Starts everything. Blocks.
    fn start() -> Self {
        let cluster = Cluster::start();
        let database = cluster.database().name;
        let proxy = Proxy::start(cluster.port());
        let store = cluster.url_of(&database, proxy.port());
        let folder = tempfile::tempdir().expect("a folder");
        let mut members = Vec::new();
        let mut urls = Vec::new();
        for number in 0..WORKERS + SERVERS {
            let role = match number < WORKERS {
                true => Role::Worker,
                false => Role::Server,
            };
            let place = folder.path().join(number.to_string());
            let mut member = Member::new(role, &store, place, &[]);
            member.start();
            if role == Role::Server {
                urls.push(member.url.clone());
            }
            members.push(member);
        }
        cluster.ask(&database, AUDIT);
        Self {
            cluster,
            proxy,
            database,
            logs: members[..WORKERS].iter().map(Member::log).collect(),
            members: members.into_iter().map(Mutex::new).collect(),
            losses: Mutex::default(),
            outages: Mutex::default(),
            urls: Mutex::new(urls),
            _folder: folder,
        }
    }

    fn update_urls(&self, load: &Load) {
        let urls = lock(&self.urls);
        let urls: Vec<&str> = urls.iter().map(String::as_str).collect();
        load.serve_at(&urls);
    }

    /// The member to which something is done next, every other time a worker that has a job; but none whose job was
    /// begun a second time: a job that loses its worker three times fails, and the database takes its part.
    fn victim(&self, random: &mut SplitMix64) -> Option<usize> {
        let anyone = random.below(WORKERS + SERVERS);
        let (steps, now) = (steps(&self.logs), Timestamp::now());
        let begun = |worker: usize| {
            let job = holds(&steps, worker, now)?;
            let begins = steps.iter().filter(|step| step.begins && step.job == job);
            Some(begins.count())
        };
        let fresh: Vec<usize> = (0..WORKERS)
            .filter(|worker| begun(*worker) == Some(1))
            .collect();
        let chosen = match random.below(2 * fresh.len().max(1)) {
            chosen if chosen < fresh.len() => fresh[chosen],
            _ => anyone,
        };
        (chosen >= WORKERS || begun(chosen).is_none_or(|times| times < 2)).then_some(chosen)
    }

    /// Does something to a member, unless something is being done to it already. Blocks.
    fn disturb(&self, number: usize, deed: Deed) {
        let Ok(mut member) = self.members[number].try_lock() else {
            return;
        };
        let at = Timestamp::now();
        match deed {
            Deed::Kill(pause) => {
                member.end("-KILL");
                std::thread::sleep(pause);
                member.start();
                if number >= WORKERS {
                    lock(&self.urls)[number - WORKERS] = member.url.clone();
                }
            }
            Deed::Freeze(time) => {
                member.send("-STOP");
                std::thread::sleep(time);
                member.send("-CONT");
            }
        }
        if number < WORKERS {
            let killed = matches!(deed, Deed::Kill(_));
            lock(&self.losses).push(Loss {
                worker: number,
                at,
                killed,
            });
        }
    }

    /// Kills a worker as soon as one has a job that was never begun before: jobs are short, so that chance alone may
    /// spare every worker that has one. Blocks for a few seconds at most.
    fn kill_busy_worker(&self) {
        let end = Instant::now() + Duration::from_secs(5);
        while Instant::now() < end {
            let steps = steps(&self.logs);
            let begun = |job: &str| {
                steps
                    .iter()
                    .filter(|step| step.begins && step.job == job)
                    .count()
            };
            let now = Timestamp::now();
            let busy = (0..WORKERS)
                .find(|worker| holds(&steps, *worker, now).is_some_and(|job| begun(job) == 1));
            if let Some(worker) = busy {
                return self.disturb(worker, Deed::Kill(Duration::ZERO));
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Does something to the database. Blocks until it can be had again.
    fn trouble(&self, trouble: Trouble) {
        lock(&self.outages).push((Timestamp::now(), Timestamp::MAX));
        match trouble {
            Trouble::Restart => {
                self.cluster.stop();
                self.cluster.resume();
            }
            Trouble::Crash => {
                self.cluster.crash();
                self.cluster.resume();
            }
            Trouble::OutOfReach => {
                self.proxy.vanish();
                std::thread::sleep(OUTAGE);
                self.proxy.appear();
            }
        }
        if let Some((_, to)) = lock(&self.outages).last_mut() {
            *to = Timestamp::now() + AFTERMATH;
        }
    }

    /// No member may have ended by itself, unless the database was away when it started. Blocks.
    fn check_alive(&self, ledger: &Ledger) {
        for member in &self.members {
            let Ok(mut member) = member.try_lock() else {
                continue;
            };
            let (from, to) = (member.born - AFTERMATH, member.born);
            let was_hard = lock(&self.outages)
                .iter()
                .any(|outage| outage.0 <= to && from <= outage.1);
            if let Some(words) = member.revive()
                && !was_hard
            {
                ledger.fault(words);
            }
        }
    }

    /// Times from the loss of a worker to the moment at which its job began again: of those that were killed, of
    /// those that were frozen, and of those whose job waited for the database too.
    fn restarts(&self) -> [Vec<SignedDuration>; 3] {
        let steps = steps(&self.logs);
        let outages = lock(&self.outages);
        let mut times = [Vec::new(), Vec::new(), Vec::new()];
        let losses = lock(&self.losses);
        for loss in losses.iter() {
            let Some(time) = restart(&steps, loss.worker, loss.at) else {
                continue;
            };
            // One that woke in time kept its job until it was lost again.
            let again = |later: &Loss| {
                later.worker == loss.worker
                    && (loss.at..loss.at + time).contains(&later.at)
                    && later.at != loss.at
            };
            if losses.iter().any(again) {
                continue;
            }
            let overlaps =
                |(from, to): &(Timestamp, Timestamp)| loss.at < *to && *from < loss.at + time;
            let kind = match (outages.iter().any(overlaps), loss.killed) {
                (true, _) => 2,
                (false, true) => 0,
                (false, false) => 1,
            };
            times[kind].push(time);
        }
        times.each_mut().map(|times| {
            times.sort();
            std::mem::take(times)
        })
    }

    fn ask(&self, sql: &str) -> String {
        self.cluster.ask(&self.database, sql)
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_fleet_in_disorder_loses_nothing_and_does_nothing_twice() {
    let wanted = number("GRASPD_FLEET_JOBS", 300) as usize;
    let mut random = SplitMix64::seeded();
    let mut load = Load::prepare(&Habits {
        size: 60,
        pause: Duration::from_secs_f64(8.0 * 0.5 / RATE),
        patience: Duration::from_secs(5),
    });
    let scene = Arc::new(spawn_blocking(Scene::start).await.expect("a fleet"));
    scene.update_urls(&load);
    load.start(&mut random);
    let mut troubles = [
        (0.2, Trouble::Restart),
        (0.4, Trouble::OutOfReach),
        (0.8, Trouble::Crash),
    ]
    .into_iter()
    .peekable();
    let mut deeds: JoinSet<()> = JoinSet::new();
    let mut kept_busy: Option<tokio::task::JoinHandle<()>> = None;
    loop {
        let submitted = load.ledger.jobs().len();
        let is_calm = kept_busy.as_ref().is_none_or(|task| task.is_finished());
        let due = |(share, _): &(f64, Trouble)| submitted as f64 >= share * wanted as f64;
        if is_calm && let Some((_, trouble)) = troubles.next_if(due) {
            println!("{submitted} jobs: {trouble:?}");
            let scene = Arc::clone(&scene);
            kept_busy = Some(spawn_blocking(move || scene.trouble(trouble)));
        } else if is_calm && submitted >= wanted && troubles.peek().is_none() {
            let [killed, ..] = scene.restarts();
            if !killed.is_empty() || submitted >= 4 * wanted {
                break;
            }
            let scene = Arc::clone(&scene);
            deeds.spawn_blocking(move || scene.kill_busy_worker());
        }
        let pause = 300 + random.below(2500) as u64;
        tokio::time::sleep(Duration::from_millis(pause)).await;
        let victim = scene.victim(&mut random);
        let deed = match random.below(10) {
            0..6 => Deed::Kill(Duration::from_millis(random.below(1500) as u64)),
            _ => Deed::Freeze(Duration::from_millis(1000 + random.below(14_000) as u64)),
        };
        let (stage, ledger) = (Arc::clone(&scene), Arc::clone(&load.ledger));
        deeds.spawn_blocking(move || {
            stage.check_alive(&ledger);
            if let Some(number) = victim {
                stage.disturb(number, deed);
            }
        });
        scene.update_urls(&load);
    }
    while let Some(done) = deeds.join_next().await {
        done.expect("a deed");
    }
    scene.update_urls(&load);
    load.stop().await;
    let jobs = verdict::check_jobs(&load, 3).await;
    assert!(!jobs.contains("failed"), "{jobs}");

    for member in &scene.members {
        let status = lock(member).end("-TERM");
        assert!(status.success(), "{status}");
    }
    let lives = "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')";
    assert_eq!(scene.ask(lives), "0");
    assert_eq!(scene.ask("SELECT job FROM test_late"), "");
    assert_ne!(scene.ask("SELECT count(*) FROM test_ends"), "0");

    println!("{jobs}");
    let [killed, frozen, apart] = scene.restarts();
    for (what, times) in [
        ("killed", &killed),
        ("frozen", &frozen),
        ("lost while the database was away", &apart),
    ] {
        let at = |place: usize| times.get(place).map_or(0.0, SignedDuration::as_secs_f64);
        let (count, median) = (times.len(), at(times.len() / 2));
        let longest = at(count.saturating_sub(1));
        println!(
            "{count} jobs of workers {what} began again: median {median:.1} s, longest {longest:.1} s"
        );
    }
    assert!(!killed.is_empty(), "no kill hit a job");
    // The short form runs beside other tests.
    let factor = if wanted < 2000 { 2 } else { 1 };
    let longest = killed.iter().chain(&frozen).max().expect("a restart");
    assert!(*longest <= RESTART * factor, "{killed:?} {frozen:?}");
}
