//! The journal of a run, from which an interrupted run resumes: one JSON document per line, to which lines are only ever
//! appended.

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use uuid::Uuid;

use super::folder::{Folder, output_name};

/// The name of the file in the folder of the results.
const JOURNAL: &str = "journal.ndjson";

/// A line of the journal.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Entry {
    /// The first line; `run` is part of the key of every submission.
    Begun { run: String, settings: Value },
    /// The result of `file`, an absolute path, is named `output`.
    Named { file: String, output: String },
    /// The server has accepted the mesh with this hash under the key of this attempt.
    Submitted {
        output: String,
        sha256: String,
        attempt: u32,
        job: String,
    },
    /// The work on the mesh is finished, and its result, if any, is written.
    Ended {
        output: String,
        sha256: String,
        outcome: Outcome,
    },
}

/// The outcome for a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub state: End,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<ResultSummary>,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// How the work on a mesh ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    Succeeded,
    Failed,
    Cancelled,
    /// The server refuses the mesh, or the settings for it.
    Refused,
    /// The file cannot be read.
    Unreadable,
}

impl End {
    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
            Self::Refused => "refused",
            Self::Unreadable => "unreadable",
        }
    }
}

/// The members of a result that the summary shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResultSummary {
    pub force_closure: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<f64>,
    pub evaluations: u64,
    pub elapsed_s: f64,
}

/// The progress of the work on a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshProgress {
    /// Hash of the file that was sent.
    pub sha256: String,
    /// Number of the attempt, which is part of the key of the submission.
    pub attempt: u32,
    pub job: Option<String>,
    pub outcome: Option<Outcome>,
}

/// The journal of a run, locked for as long as this lives.
pub struct Journal {
    file: File,
    /// The random id of the run.
    pub run: String,
    outputs: HashMap<String, String>,
    meshes: HashMap<String, MeshProgress>,
}

/// The outcome of opening a journal.
pub enum Opened {
    Ready(Journal),
    /// Another process has locked it.
    InUse,
    /// It belongs to a run with other settings; contains the differences as text.
    OtherSettings(String),
}

impl Journal {
    /// Opens the journal in a folder, or creates one. A last line that was cut off when the process was killed is dropped:
    /// the step that it recorded is repeated.
    pub fn open(folder: &Folder, settings: &Value) -> io::Result<Opened> {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(folder.path(JOURNAL))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(Opened::InUse),
            Err(TryLockError::Error(fault)) => return Err(fault),
        }
        folder.remove_unfinished()?;
        let mut text = Vec::new();
        file.read_to_end(&mut text)?;
        let complete = text
            .iter()
            .rposition(|byte| *byte == b'\n')
            .map_or(0, |at| at + 1);
        file.set_len(complete as u64)?;
        file.seek(SeekFrom::End(0))?;
        let mut journal = Self {
            file,
            run: String::new(),
            outputs: HashMap::new(),
            meshes: HashMap::new(),
        };
        let lines = text[..complete].split(|byte| *byte == b'\n');
        for (number, line) in lines.filter(|line| !line.is_empty()).enumerate() {
            let entry = serde_json::from_slice(line).map_err(|fault| {
                let place = number + 1;
                io::Error::other(format!("line {place} of its {JOURNAL} is damaged: {fault}"))
            })?;
            match entry {
                Entry::Begun {
                    settings: others, ..
                } if others != *settings => {
                    return Ok(Opened::OtherSettings(differences(&others, settings)));
                }
                entry => journal.apply(entry),
            }
        }
        if journal.run.is_empty() {
            let run = Uuid::new_v4().simple().to_string();
            let settings = settings.clone();
            journal.append([Entry::Begun { run, settings }])?;
            journal.file.sync_all()?;
        }
        Ok(Opened::Ready(journal))
    }

    /// Returns the name of the result of each of these absolute paths. Names are unique, and a path keeps its name in later
    /// runs.
    pub fn name(&mut self, files: &[String]) -> io::Result<Vec<String>> {
        let mut new = Vec::new();
        let mut taken: std::collections::HashSet<String> = self.outputs.values().cloned().collect();
        for file in files
            .iter()
            .filter(|file| !self.outputs.contains_key(*file))
        {
            let name = file.rsplit('/').next().unwrap_or(file);
            let output = output_name(name, |name| taken.contains(name));
            taken.insert(output.clone());
            let file = file.clone();
            new.push(Entry::Named { file, output });
        }
        self.append(new)?;
        self.file.sync_all()?;
        let named = files
            .iter()
            .filter_map(|file| self.outputs.get(file).cloned());
        Ok(named.collect())
    }

    /// Returns the progress of the mesh whose result has this name.
    pub fn progress(&self, output: &str) -> Option<&MeshProgress> {
        self.meshes.get(output)
    }

    pub fn submitted(
        &mut self,
        output: &str,
        sha256: &str,
        attempt: u32,
        job: &str,
    ) -> io::Result<()> {
        self.append([Entry::Submitted {
            output: output.to_owned(),
            sha256: sha256.to_owned(),
            attempt,
            job: job.to_owned(),
        }])
    }

    pub fn ended(&mut self, output: &str, sha256: &str, outcome: &Outcome) -> io::Result<()> {
        self.append([Entry::Ended {
            output: output.to_owned(),
            sha256: sha256.to_owned(),
            outcome: outcome.clone(),
        }])
    }

    fn append(&mut self, entries: impl IntoIterator<Item = Entry>) -> io::Result<()> {
        let entries: Vec<Entry> = entries.into_iter().collect();
        let mut lines = Vec::new();
        for entry in &entries {
            serde_json::to_writer(&mut lines, entry)?;
            lines.push(b'\n');
        }
        self.file.write_all(&lines)?;
        for entry in entries {
            self.apply(entry);
        }
        Ok(())
    }

    fn apply(&mut self, entry: Entry) {
        match entry {
            Entry::Begun { run, .. } => self.run = run,
            Entry::Named { file, output } => drop(self.outputs.insert(file, output)),
            Entry::Submitted {
                output,
                sha256,
                attempt,
                job,
            } => {
                let progress = MeshProgress {
                    sha256,
                    attempt,
                    job: Some(job),
                    outcome: None,
                };
                self.meshes.insert(output, progress);
            }
            Entry::Ended {
                output,
                sha256,
                outcome,
            } => {
                let before = self
                    .meshes
                    .get(&output)
                    .filter(|before| before.sha256 == sha256);
                let progress = MeshProgress {
                    attempt: before.map_or(1, |before| before.attempt),
                    job: before.and_then(|before| before.job.clone()),
                    sha256,
                    outcome: Some(outcome),
                };
                self.meshes.insert(output, progress);
            }
        }
    }
}

/// Describes which settings differ.
fn differences(there: &Value, here: &Value) -> String {
    let mut found = Vec::new();
    compare("", there, here, &mut found);
    found.join(", ")
}

fn compare(name: &str, there: &Value, here: &Value, found: &mut Vec<String>) {
    if there == here {
        return;
    }
    let (Value::Object(a), Value::Object(b)) = (there, here) else {
        found.push(format!("{name}: {there} there, {here} here"));
        return;
    };
    let mut names: Vec<&String> = a.keys().chain(b.keys()).collect();
    names.sort();
    names.dedup();
    for name in names {
        let of =
            |object: &serde_json::Map<String, Value>| object.get(name).cloned().unwrap_or_default();
        compare(name, &of(a), &of(b), found);
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn open(folder: &Folder, settings: &Value) -> Opened {
        Journal::open(folder, settings).unwrap()
    }

    fn ready(opened: Opened) -> Journal {
        match opened {
            Opened::Ready(journal) => journal,
            _ => panic!("it is free and of these settings"),
        }
    }

    fn outcome() -> Outcome {
        Outcome {
            state: End::Refused,
            found: None,
            problem: Some("flat".to_owned()),
        }
    }

    #[test]
    fn entries_are_read_back_and_an_incomplete_line_is_dropped() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path()).unwrap();
        let settings = json!({"request": {"contacts": 4}});
        let files = ["/a/x.stl".to_owned(), "/b/x.stl".to_owned()];
        let mut journal = ready(open(&folder, &settings));
        let run = journal.run.clone();
        assert_eq!(
            journal.name(&files).unwrap(),
            ["x.stl.json", "x.stl-2.json"]
        );
        journal.submitted("x.stl.json", "aa", 1, "job").unwrap();
        journal.submitted("x.stl-2.json", "bb", 2, "other").unwrap();
        journal.ended("x.stl-2.json", "bb", &outcome()).unwrap();
        assert!(matches!(open(&folder, &settings), Opened::InUse));
        drop(journal);
        let path = folder.path(JOURNAL);
        let text = std::fs::read(&path).unwrap();
        std::fs::write(&path, [&text, &b"{\"event\":\"ended\",\"outp"[..]].concat()).unwrap();

        let mut journal = ready(open(&folder, &settings));
        assert_eq!(journal.run, run);
        // Names stay with their files, whatever comes before them now.
        let more = ["/c/x.stl".to_owned(), files[1].clone(), files[0].clone()];
        let names = ["x.stl-3.json", "x.stl-2.json", "x.stl.json"];
        assert_eq!(journal.name(&more).unwrap(), names);
        let first = journal.progress("x.stl.json").unwrap();
        assert_eq!(
            (first.job.as_deref(), first.attempt, &first.outcome),
            (Some("job"), 1, &None)
        );
        let second = journal.progress("x.stl-2.json").unwrap();
        assert_eq!((second.attempt, &second.outcome), (2, &Some(outcome())));
        assert_eq!(journal.progress("x.stl-3.json"), None);
        drop(journal);
        assert_eq!(ready(open(&folder, &settings)).run, run);
    }

    #[test]
    fn different_settings_and_damaged_lines_are_reported() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path()).unwrap();
        drop(open(
            &folder,
            &json!({"request": {"contacts": 4, "friction": 0.5}}),
        ));
        let other = open(
            &folder,
            &json!({"request": {"contacts": 5, "friction": 0.5, "seed": 1}}),
        );
        let Opened::OtherSettings(words) = other else {
            panic!("they differ");
        };
        assert_eq!(words, "contacts: 4 there, 5 here, seed: null there, 1 here");
        std::fs::write(folder.path(JOURNAL), "no JSON\n").unwrap();
        let damaged = Journal::open(&folder, &json!({})).err().unwrap();
        assert!(damaged.to_string().contains("line 1"), "{damaged}");
    }
}
