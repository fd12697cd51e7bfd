//! Log lines on standard error that can neither delay nor break what they report.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

/// Most lines that wait to be written; further lines are dropped.
const MAX_WAITING: usize = 4096;
/// Longest time that writing the last lines may take.
const LAST_LINES: Duration = Duration::from_millis(500);

enum Message {
    Line(Vec<u8>),
    /// Answered once all lines before it are written.
    Flush(SyncSender<()>),
}

/// Sends lines to a dedicated thread, which writes them to standard error. Logging never blocks and never fails, even if
/// the pipe is closed, full or not read.
#[derive(Clone)]
pub struct Logs(SyncSender<Message>);

impl Logs {
    /// Starts the thread.
    pub fn start() -> io::Result<Self> {
        let (sender, receiver) = sync_channel(MAX_WAITING);
        std::thread::Builder::new()
            .name("logs".to_owned())
            .spawn(move || write_all(&receiver))?;
        Ok(Self(sender))
    }

    /// Waits a moment for the lines so far to be written.
    pub fn flush(&self) {
        let (done, written) = sync_channel(1);
        // If the queue is full, nobody reads.
        if self.0.try_send(Message::Flush(done)).is_ok() {
            let _ = written.recv_timeout(LAST_LINES);
        }
    }
}

/// Takes one whole line per call, as the subscriber writes them.
impl Write for Logs {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let _ = self.0.try_send(Message::Line(line.to_vec()));
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn write_all(messages: &Receiver<Message>) {
    for message in messages {
        // A failure to write to standard error can be reported nowhere.
        let _ = match message {
            Message::Line(line) => io::stderr().write_all(&line),
            Message::Flush(done) => done.send(()).map_err(io::Error::other),
        };
    }
}
