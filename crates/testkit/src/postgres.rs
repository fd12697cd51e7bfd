//! A private PostgreSQL cluster for tests: Debian's server on a folder of its own, under a user without
//! rights, never the cluster of the machine.
//!
//! It ends with the process that started it, however that ends: a shell waits on a pipe whose other end only
//! that process holds, then stops the server and removes the folder.

use std::fs::{self, File};
use std::io::Read;
use std::net::TcpListener;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::install::install;

/// The superuser of the cluster.
const USER: &str = "graspd";
/// The folder in which Debian installs its servers, with one folder per version.
const SERVERS: &str = "/usr/lib/postgresql";
/// The user `nobody`, and its group, under which the server runs where the tests run as root: it refuses root.
const NOBODY: (u32, u32) = (65534, 65534);
/// Ports that a server is tried on: below those that Linux gives to clients, so that no client takes the port
/// while the server is down, and none connects to itself.
const PORTS: std::ops::Range<u16> = 15_000..32_000;
/// Ports between those that processes with neighbouring numbers try first.
const PORT_STEP: u16 = 16;
/// Starts of a server before it is given up.
const TRIES: usize = 10;
/// Longest time that a server may take to start, including recovery from a crash, or to stop.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pause between two looks whether it has.
const PAUSE: Duration = Duration::from_millis(20);
/// Waits for the end of the pipe, then stops the server and removes the folder. `$1` is the folder.
const WATCHDOG: &str = r#"
read -r _
if postmaster=$(head -n 1 "$1/data/postmaster.pid" 2>/dev/null); then
    kill -CONT "$postmaster" 2>/dev/null
    kill -QUIT "$postmaster" 2>/dev/null
    while kill -0 "$postmaster" 2>/dev/null && [ -e "$1/data/postmaster.pid" ]; do sleep 0.02; done
fi
rm -rf "$1"
"#;

/// A running server with nothing in it, durable as in production. Dropping it stops it and removes its folder.
pub struct Cluster {
    /// Programs of the server.
    programs: PathBuf,
    /// Everything of the cluster: `data`, the socket and `log`.
    folder: PathBuf,
    port: u16,
    password: String,
    /// As `NAME=VALUE`, beside those that all clusters have.
    settings: Vec<String>,
    /// None while it is stopped.
    server: Mutex<Option<Child>>,
    /// Its standard input is the pipe that it waits on.
    watchdog: Child,
    /// Databases made so far.
    databases: AtomicU32,
}

/// A database of a cluster.
pub struct Database {
    pub name: String,
    /// With user and password, over TCP.
    pub url: String,
}

impl Cluster {
    /// The cluster that all tests of this process share. It ends with the process.
    ///
    /// # Panics
    /// As [`Cluster::start`].
    pub fn shared() -> &'static Self {
        static SHARED: LazyLock<Cluster> = LazyLock::new(Cluster::start);
        &SHARED
    }

    /// Makes and starts one, in a second or two. Debian's server is installed when it is missing.
    /// `GRASPD_POSTGRES_BIN` names the folder of another one's programs.
    ///
    /// # Panics
    /// When there is no server to be had, or it does not start.
    pub fn start() -> Self {
        Self::start_with(&[])
    }

    /// The same with settings of the server besides, as `NAME=VALUE`.
    ///
    /// # Panics
    /// As [`Cluster::start`].
    pub fn start_with(settings: &[&str]) -> Self {
        let programs = programs();
        let folder = tempfile::Builder::new()
            .prefix("graspd-postgres-")
            .tempdir();
        let folder = folder.expect("a temporary folder").keep();
        if is_root() {
            chown(&folder, Some(NOBODY.0), Some(NOBODY.1)).expect("the folder changes hands");
        }
        let watchdog = Command::new("sh")
            .args(["-c", WATCHDOG, "sh"])
            .arg(&folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            // Signals of a terminal end the tests, not what cleans up after them.
            .process_group(0)
            .spawn();
        let mut cluster = Self {
            programs,
            folder,
            port: 0,
            password: password(),
            settings: settings
                .iter()
                .map(|setting| (*setting).to_owned())
                .collect(),
            server: Mutex::new(None),
            watchdog: watchdog.expect("sh"),
            databases: AtomicU32::new(0),
        };
        cluster.initialise();
        let mut port = PORTS.start + (std::process::id() % 1_000) as u16 * PORT_STEP;
        for _ in 0..TRIES {
            while TcpListener::bind(("127.0.0.1", port)).is_err() {
                port = if port < PORTS.end {
                    port + 1
                } else {
                    PORTS.start
                };
            }
            cluster.port = port;
            if cluster.launch().is_ok() {
                return cluster;
            }
            // Another cluster was quicker to take the port.
            port += 1;
        }
        panic!("PostgreSQL does not start; its log: {}", cluster.log());
    }

    fn initialise(&self) {
        let secret = self.folder.join("password");
        fs::write(&secret, &self.password).expect("the password is written");
        fs::set_permissions(&secret, fs::Permissions::from_mode(0o644)).expect("it is readable");
        let made = self
            .command("initdb")
            .arg("--pgdata")
            .arg(self.data())
            .arg("--pwfile")
            .arg(&secret)
            .args(["--username", USER, "--encoding", "UTF8", "--locale", "C"])
            // The folder that holds the socket is open to nobody else.
            .args(["--auth-local", "trust", "--auth-host", "scram-sha-256"])
            .arg("--no-sync")
            .output();
        succeeds("initdb", &made.expect("initdb"));
        fs::remove_file(&secret).expect("the password is removed");
    }

    /// A command of the server's programs, as a user that it accepts.
    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(self.programs.join(program));
        command.current_dir(&self.folder).stdin(Stdio::null());
        if is_root() {
            command.uid(NOBODY.0).gid(NOBODY.1);
        }
        command
    }

    fn data(&self) -> PathBuf {
        self.folder.join("data")
    }

    /// Returns the log of the server.
    pub fn log(&self) -> String {
        fs::read_to_string(self.folder.join("log")).unwrap_or_default()
    }

    /// The port on 127.0.0.1 on which it listens, which never changes.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// The URL of the database `postgres`, of which `database()` is independent.
    pub fn url(&self) -> String {
        self.url_of("postgres", self.port)
    }

    /// The URL of a database, as reached on another port of 127.0.0.1 that leads to the server.
    pub fn url_of(&self, database: &str, port: u16) -> String {
        let password = &self.password;
        format!("postgres://{USER}:{password}@127.0.0.1:{port}/{database}")
    }

    /// Makes a new, empty database.
    ///
    /// # Panics
    /// When the server is stopped.
    pub fn database(&self) -> Database {
        let name = format!("test_{}", self.databases.fetch_add(1, Ordering::Relaxed));
        self.ask("postgres", &format!("CREATE DATABASE {name}"));
        let url = self.url_of(&name, self.port);
        Database { name, url }
    }

    /// Carries out SQL and gives what it answers: a line for each row, its columns apart by `|`.
    ///
    /// # Panics
    /// When the server is stopped or refuses the SQL.
    pub fn ask(&self, database: &str, sql: &str) -> String {
        let answer = self
            .command("psql")
            .arg("--host")
            .arg(&self.folder)
            .args(["--port", &self.port.to_string(), "--username", USER])
            .args(["--dbname", database, "--no-psqlrc", "--quiet"])
            .args(["--tuples-only", "--no-align", "--set", "ON_ERROR_STOP=1"])
            .args(["--command", sql])
            .output();
        let answer = answer.expect("psql");
        succeeds(sql, &answer);
        String::from_utf8_lossy(&answer.stdout)
            .trim_end()
            .to_owned()
    }

    /// Stops it in order, as an administrator does: connections are ended, what they were at is rolled back.
    pub fn stop(&self) {
        self.halt("-INT");
    }

    /// Stops it at once, as a crash does: the next start recovers from the log.
    pub fn crash(&self) {
        self.halt("-QUIT");
    }

    /// Starts it again on the same port with the same data.
    ///
    /// # Panics
    /// When it runs already or does not start.
    pub fn resume(&self) {
        if let Err(fault) = self.launch() {
            panic!(
                "PostgreSQL does not start: {fault}; its log: {}",
                self.log()
            );
        }
    }

    /// The number of the process that is the parent of all of the server; `None` while it is stopped.
    pub fn process(&self) -> Option<u32> {
        self.server().as_ref().map(Child::id)
    }

    fn server(&self) -> MutexGuard<'_, Option<Child>> {
        self.server.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn halt(&self, signal: &str) {
        let mut server = self.server();
        let Some(mut child) = server.take() else {
            return;
        };
        let sent = Command::new("kill")
            .arg(signal)
            .arg(child.id().to_string())
            .status();
        assert!(sent.expect("kill").success(), "the server is gone");
        let end = Instant::now() + PATIENCE;
        while child.try_wait().expect("the server's end").is_none() {
            assert!(
                Instant::now() < end,
                "PostgreSQL does not stop on {signal}: {}",
                self.log()
            );
            sleep(PAUSE);
        }
    }

    /// Starts the server and waits until it takes connections.
    fn launch(&self) -> Result<(), String> {
        let mut server = self.server();
        assert!(server.is_none(), "PostgreSQL runs already");
        let log = File::options()
            .create(true)
            .append(true)
            .open(self.folder.join("log"));
        let mut child = self
            .command("postgres")
            .arg("-D")
            .arg(self.data())
            .arg("-k")
            .arg(&self.folder)
            .args(["-h", "127.0.0.1", "-p", &self.port.to_string()])
            .args(["-c", "max_connections=300"])
            .args(self.settings.iter().flat_map(|setting| ["-c", setting]))
            .stdout(Stdio::null())
            .stderr(log.expect("the log opens"))
            .process_group(0)
            .spawn()
            .map_err(|fault| fault.to_string())?;
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(status) = child.try_wait().map_err(|fault| fault.to_string())? {
                return Err(status.to_string());
            }
            if self.is_ready() {
                break;
            }
            assert!(
                Instant::now() < end,
                "PostgreSQL is never ready: {}",
                self.log()
            );
            sleep(PAUSE);
        }
        *server = Some(child);
        Ok(())
    }

    fn is_ready(&self) -> bool {
        let ready = self
            .command("pg_isready")
            .arg("--quiet")
            .arg("--host")
            .arg(&self.folder)
            .args(["--port", &self.port.to_string()])
            .status();
        ready.expect("pg_isready").success()
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        drop(self.watchdog.stdin.take());
        if let Some(mut server) = self.server().take() {
            // It is a zombie until this process takes notice of its end.
            let _ = server.wait();
        }
        let _ = self.watchdog.wait();
    }
}

fn succeeds(what: &str, output: &Output) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{what} fails: {said}");
}

fn is_root() -> bool {
    fs::metadata("/proc/self").is_ok_and(|process| process.uid() == 0)
}

/// 32 random letters and digits.
fn password() -> String {
    let mut bytes = [0; 16];
    let random = File::open("/dev/urandom").and_then(|mut file| file.read_exact(&mut bytes));
    random.expect("random bytes");
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The folder of the server's programs.
fn programs() -> PathBuf {
    if let Some(named) = std::env::var_os("GRASPD_POSTGRES_BIN") {
        return named.into();
    }
    newest(Path::new(SERVERS)).unwrap_or_else(|| {
        install("postgresql");
        newest(Path::new(SERVERS)).expect("Debian's PostgreSQL is in its folder")
    })
}

/// The programs of the newest version in a folder of versions.
fn newest(servers: &Path) -> Option<PathBuf> {
    let versions = fs::read_dir(servers).ok()?.filter_map(|entry| {
        let folder = entry.ok()?.path();
        let version: u32 = folder.file_name()?.to_str()?.parse().ok()?;
        let programs = folder.join("bin");
        programs
            .join("postgres")
            .exists()
            .then_some((version, programs))
    });
    Some(versions.max()?.1)
}
