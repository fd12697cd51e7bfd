//! The program `graspd` as a process of its own.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};

use reqwest::Client;
use serde_json::Value;

/// A server that runs as a process of its own; it is killed when this is dropped.
pub struct Graspd {
    child: Child,
    pub url: String,
}

impl Graspd {
    pub fn start(data: &Path) -> Self {
        Self::start_logging_to(data, Stdio::null())
    }

    pub fn start_logging_to(data: &Path, logs: Stdio) -> Self {
        Self::start_with(data, &[], logs)
    }

    /// With these flags of `graspd serve` besides.
    pub fn start_with(data: &Path, flags: &[&str], logs: Stdio) -> Self {
        let mut command = graspd(&[]);
        command.stderr(logs);
        Self::spawn(command, data, flags)
    }

    /// Starts a command that runs the binary.
    pub fn spawn(mut command: Command, data: &Path, flags: &[&str]) -> Self {
        command.args(["serve", "--listen", "127.0.0.1:0", "--data-dir"]);
        command.arg(data).args(flags);
        Self::launch(&mut command)
    }

    /// Starts a command that becomes a server.
    pub fn launch(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("the binary");
        let mut line = String::new();
        let out = child.stdout.take().expect("standard output");
        BufReader::new(out).read_line(&mut line).expect("a line");
        let url = line
            .trim()
            .strip_prefix("graspd listening on ")
            .unwrap_or_else(|| panic!("{line:?}"));
        Self {
            url: url.to_owned(),
            child,
        }
    }

    pub fn id(&self) -> String {
        self.child.id().to_string()
    }

    pub fn url(&self, path: &str) -> String {
        format!("{}{path}", self.url)
    }

    /// Sends a signal, such as `-TERM`, and waits for the end.
    pub fn signal(&mut self, name: &str) -> ExitStatus {
        self.send(name);
        self.child.wait().expect("an end")
    }

    /// Sends a signal.
    pub fn send(&self, name: &str) {
        let sent = Command::new("kill").args([name, &self.id()]).status();
        assert!(sent.expect("kill").success());
    }
}

impl Drop for Graspd {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The program, as cargo built it for the tests that run.
///
/// # Panics
/// When the test is not an integration test or benchmark of the package `graspd` that cargo runs: cargo builds the
/// program for those alone, and gives them its path.
pub fn binary() -> PathBuf {
    std::env::var_os("CARGO_BIN_EXE_graspd")
        .expect("CARGO_BIN_EXE_graspd is set: run this test with cargo test")
        .into()
}

/// The program with these arguments, and no settings from the environment of the tests.
pub fn graspd(arguments: &[&str]) -> Command {
    let mut command = Command::new(binary());
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("GRASPD_") {
            command.env_remove(name);
        }
    }
    command.args(arguments);
    command
}

/// Asserts the exit code of a command, and returns its standard output and standard error.
pub fn ended(output: &Output, code: i32) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("UTF-8");
    let said = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{said:?}");
    said
}

pub async fn get(client: &Client, url: String) -> Value {
    client
        .get(url)
        .send()
        .await
        .expect("an answer")
        .json()
        .await
        .expect("JSON")
}
