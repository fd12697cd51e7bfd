//! Log lines on standard error that can neither hold up nor harm what they tell of.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

/// Lines that may wait to be written; while so many do, further ones are lost.
const MAX_WAITING: usize = 4096;
/// Longest that the last lines are waited for.
const LAST_LINES: Duration = Duration::from_millis(500);

enum Message {
    Line(Vec<u8>),
    /// Answered once all lines before it are written.
    Flush(SyncSender<()>),
}

/// The way to a thread of its own that writes to standard error. Whoever logs never waits, and
/// never hears of a pipe that is closed, full or not read.
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

    /// Gives the lines so far a moment to be written.
    pub fn flush(&self) {
        let (done, written) = sync_channel(1);
        // A queue that is full is one that nobody reads.
        if self.0.try_send(Message::Flush(done)).is_ok() {
            let _ = written.recv_timeout(LAST_LINES);
        }
    }
}

/// Takes one whole line at a time, as the subscriber hands them over.
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
        // There is no better place to complain at.
        let _ = match message {
            Message::Line(line) => io::stderr().write_all(&line),
            Message::Flush(done) => done.send(()).map_err(io::Error::other),
        };
    }
}
