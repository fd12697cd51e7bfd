//! One process of a fleet: a server that plans nothing, or a worker.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use jiff::Timestamp;
use procfs::process::Process;
use testkit::process::graspd;

/// Longest that a member may take to come up, while its database may be out of reach.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pause before a member that did not come up is started again.
const PAUSE: Duration = Duration::from_millis(300);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Server,
    Worker,
}

/// A process that is killed when this is dropped.
pub struct Member {
    pub role: Role,
    /// Where its database is.
    store: String,
    /// Its own: it shares nothing with others but the database.
    folder: PathBuf,
    flags: Vec<String>,
    child: Option<Child>,
    /// When it was started last.
    pub born: Timestamp,
    /// How often it was started.
    pub lives: usize,
    /// Where it listens, if it is a server that runs.
    pub url: String,
}

impl Member {
    /// One that does not run yet, with these flags besides.
    pub fn new(role: Role, store: &str, folder: PathBuf, flags: &[&str]) -> Self {
        std::fs::create_dir_all(&folder).expect("a folder");
        Self {
            role,
            store: store.to_owned(),
            folder,
            flags: flags.iter().map(|flag| (*flag).to_owned()).collect(),
            child: None,
            born: Timestamp::UNIX_EPOCH,
            lives: 0,
            url: String::new(),
        }
    }

    /// What it logs in all its lives, a JSON object a line.
    pub fn log(&self) -> PathBuf {
        self.folder.join("log")
    }

    fn command(&self) -> Command {
        let mut command = match self.role {
            Role::Server => graspd(&["serve", "--listen", "127.0.0.1:0"]),
            Role::Worker => graspd(&["worker"]),
        };
        let workers = match self.role {
            Role::Server => "0",
            Role::Worker => "1",
        };
        let log = File::options()
            .create(true)
            .append(true)
            .open(self.log())
            .expect("a log");
        command
            .args(&self.flags)
            .env("GRASPD_STORE", &self.store)
            .env("GRASPD_WORKERS", workers)
            .env("GRASPD_THREADS_PER_JOB", "1")
            .env("GRASPD_DATA_DIR", self.folder.join("data"))
            .env("GRASPD_LOG_FORMAT", "json")
            .env("GRASPD_LOG_LEVEL", "info")
            .stderr(log);
        command
    }

    /// Starts it, again and again as a supervisor does, until it is up: a server listens, a worker plans. Blocks.
    pub fn start(&mut self) {
        let end = Instant::now() + PATIENCE;
        loop {
            let mut command = self.command();
            self.born = Timestamp::now();
            self.lives += 1;
            let child = command.stdout(Stdio::piped()).spawn();
            let mut child = child.expect("the binary");
            let out = child.stdout.take().expect("standard output");
            let mut line = String::new();
            let _ = BufReader::new(out).read_line(&mut line);
            let up = match self.role {
                Role::Server => "graspd listening on ",
                Role::Worker => "graspd worker ",
            };
            if let Some(rest) = line.trim().strip_prefix(up) {
                self.url = rest.to_owned();
                self.child = Some(child);
                return;
            }
            let status = child.wait().expect("an end");
            assert!(
                Instant::now() < end,
                "{:?} does not start: {status}, {}",
                self.role,
                self.last_words()
            );
            sleep(PAUSE);
        }
    }

    /// The end of its log.
    pub fn last_words(&self) -> String {
        let log = std::fs::read_to_string(self.log()).unwrap_or_default();
        let lines: Vec<&str> = log.lines().collect();
        lines[lines.len().saturating_sub(5)..].join("\n")
    }

    /// Starts it again if it has ended by itself; says with which last words it did.
    pub fn revive(&mut self) -> Option<String> {
        let child = self.child.as_mut()?;
        let status = child.try_wait().expect("a state")?;
        let words = format!(
            "{:?} ended by itself: {status}, {}",
            self.role,
            self.last_words()
        );
        self.start();
        Some(words)
    }

    /// Processor time that it has taken in this life, in ticks of a hundredth of a second.
    pub fn ticks(&self) -> u64 {
        let child = self.child.as_ref().expect("a process");
        let process = Process::new(child.id() as i32);
        let state = process.and_then(|process| process.stat());
        let state = state.expect("its state");
        state.utime + state.stime
    }

    /// Sends a signal, such as `-STOP`.
    pub fn send(&self, signal: &str) {
        let child = self.child.as_ref().expect("a process");
        let sent = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        assert!(sent.expect("kill").success());
    }

    /// Sends a signal and waits for the end. Blocks.
    pub fn end(&mut self, signal: &str) -> ExitStatus {
        self.send(signal);
        let mut child = self.child.take().expect("a process");
        child.wait().expect("an end")
    }
}

impl Drop for Member {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
