//! Findings about the data directory.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::time::Duration;

use jiff::Timestamp;
use rustix::fs::Access;

use super::Finding;
use crate::config::Config;
use crate::host;
use crate::store::StoreError;
use crate::store::sqlite::{Survey, VERSION, is_in_use, is_trusted_sqlite, lock_file};
use crate::wire::MeshId;

/// How long a mesh may lack its row or its file while a server adds or deletes it.
const MOMENT: Duration = Duration::from_millis(500);
/// How far in the future the newest job may appear to be.
const SKEW_MICROSECONDS: i64 = 5_000_000;
/// File systems on which locks or shared memory do not work as SQLite needs them.
const REMOTE: [&str; 6] = ["nfs", "nfs4", "cifs", "smb3", "9p", "fuse.sshfs"];

/// Examines the data directory and everything in it.
pub async fn findings(config: &Config, deep: bool) -> Vec<Finding> {
    let data = &config.store.data_dir;
    if let Err(error) = fs::read_dir(data) {
        return vec![missing(data, &error)];
    }
    let mut findings = vec![
        directory(data),
        room(data, config.min_free_disk),
        lock(data),
    ];
    if !data.join("graspd.db").exists() {
        findings.push(Finding::ok(
            "database",
            "none yet; the first start creates it",
        ));
        return findings;
    }
    match database(data, deep).await {
        Ok(found) => findings.extend(found),
        Err(fault) => findings.push(Finding::wrong(
            "database",
            fault,
            "run this as the user of the server; if the file is damaged, restore a backup",
        )),
    }
    findings
}

fn missing(data: &Path, error: &io::Error) -> Finding {
    let detail = format!("{}: {error}", data.display());
    match error.kind() {
        io::ErrorKind::NotFound => Finding::ok(
            "data directory",
            format_args!("{} is missing; the first start creates it", data.display()),
        ),
        _ => Finding::wrong(
            "data directory",
            detail,
            "name a folder that the user of the server may read and write",
        ),
    }
}

fn directory(data: &Path) -> Finding {
    let kind = host::file_system(data).unwrap_or_else(|| "an unknown file system".to_owned());
    let detail = format!("{} on {kind}", data.display());
    let check = "data directory";
    match rustix::fs::access(data, Access::WRITE_OK | Access::EXEC_OK) {
        Err(error) => Finding::wrong(
            check,
            format_args!("{detail} cannot be written: {error}"),
            "give the user of the server write permission, or mount it writable",
        ),
        Ok(()) if REMOTE.contains(&kind.as_str()) => Finding::wrong(
            check,
            detail,
            "use a local disk: over a network neither the lock nor the database is safe",
        ),
        Ok(()) => Finding::ok(check, detail),
    }
}

fn room(data: &Path, least: u64) -> Finding {
    let check = "free space";
    match host::free_bytes(data) {
        Err(error) => Finding::wrong(check, error, "check that the file system is mounted"),
        Ok(free) if free < least => Finding::wrong(
            check,
            format_args!("{} of at least {}", mebibytes(free), mebibytes(least)),
            "free some space: with less, no new work is accepted; or lower --min-free-disk",
        ),
        Ok(free) => Finding::ok(check, mebibytes(free)),
    }
}

fn lock(data: &Path) -> Finding {
    match is_in_use(data) {
        Ok(false) => Finding::ok("lock", "free; no server runs on this directory"),
        Ok(true) => Finding::ok(
            "lock",
            match host::lock_holder(&lock_file(data)) {
                Some(process) => format!("held by process {process}"),
                None => "held by a server".to_owned(),
            },
        ),
        Err(error) => Finding::wrong("lock", error, "run this as the user of the server"),
    }
}

async fn database(data: &Path, deep: bool) -> Result<Vec<Finding>, StoreError> {
    let mut survey = Survey::open(data).await?;
    let mut findings = vec![
        version(&survey.sqlite_version().await?),
        journal(data)?,
        schema(survey.schema_version().await?),
        faults(&survey.faults(deep).await?, deep),
    ];
    if survey.schema_version().await? == 0 {
        return Ok(findings);
    }
    findings.push(meshes(&mut survey).await?);
    if deep {
        let damaged = survey.damaged_meshes().await?;
        findings.push(match damaged.is_empty() {
            true => Finding::ok("mesh files", "each has the content that was uploaded"),
            false => Finding::wrong(
                "mesh files",
                damaged.join("; "),
                "restore a backup, or delete these meshes and upload them again",
            ),
        });
    }
    findings.push(newest_job(survey.newest_job().await?));
    Ok(findings)
}

fn version(found: &str) -> Finding {
    match is_trusted_sqlite(found) {
        true => Finding::ok("SQLite", found),
        false => Finding::wrong("SQLite", found, "build graspd with a later SQLite"),
    }
}

/// Reads from the header of the file whether it uses a write-ahead log (SQLite file format, 1.3), which is a lasting
/// property of the file.
fn journal(data: &Path) -> io::Result<Finding> {
    let mut header = [0; 20];
    File::open(data.join("graspd.db"))?.read_exact(&mut header)?;
    Ok(Finding::ok(
        "journal",
        match header[18..] {
            [2, 2] => "write-ahead log",
            _ => "no write-ahead log; the next start turns it on",
        },
    ))
}

fn schema(found: i64) -> Finding {
    let detail = format!("version {found}; this program has version {VERSION}");
    match found {
        found if found > VERSION => Finding::wrong(
            "tables",
            detail,
            "use the version of graspd that created them, or a later one",
        ),
        _ => Finding::ok("tables", detail),
    }
}

fn faults(found: &[String], deep: bool) -> Finding {
    let check = if deep {
        "integrity check"
    } else {
        "quick check"
    };
    match found.is_empty() {
        true => Finding::ok(check, "no fault"),
        false => Finding::wrong(
            check,
            found.join("; "),
            "stop the server, keep a copy of the directory, and restore a backup",
        ),
    }
}

async fn meshes(survey: &mut Survey) -> Result<Finding, StoreError> {
    let mut found = survey.unpaired().await?;
    if !found.rows_without_file.is_empty() || !found.files_without_row.is_empty() {
        // A mesh that a server is adding or deleting is complete or gone by then.
        tokio::time::sleep(MOMENT).await;
        let again = survey.unpaired().await?;
        let still = |before: &[MeshId], now: Vec<MeshId>| {
            let before: HashSet<_> = before.iter().collect();
            now.into_iter().filter(|id| before.contains(id)).collect()
        };
        found.rows_without_file = still(&found.rows_without_file, again.rows_without_file);
        found.files_without_row = still(&found.files_without_row, again.files_without_row);
    }
    let check = "meshes";
    let (lost, left) = (found.rows_without_file.len(), found.files_without_row.len());
    Ok(match (lost, left) {
        (0, 0) => Finding::ok(check, "every row has its file, and every file its row"),
        (0, left) => Finding::warning(
            check,
            format_args!("{left} files without a row"),
            "nothing: the next start removes them",
        ),
        (lost, _) => Finding::wrong(
            check,
            format_args!(
                "{lost} rows without a file, the first {}",
                found.rows_without_file[0]
            ),
            "upload these meshes again, or restore a backup; the next start deletes the rows",
        ),
    })
}

fn newest_job(newest: Option<i64>) -> Finding {
    let now = Timestamp::now().as_microsecond();
    let check = "newest job";
    match newest {
        None => Finding::ok(check, "none"),
        Some(newest) if newest > now + SKEW_MICROSECONDS => Finding::wrong(
            check,
            format_args!("submitted {} s in the future", (newest - now) / 1_000_000),
            "set the clock: it was ahead then or is behind now, and jobs are queued in the order of time",
        ),
        Some(newest) => Finding::ok(
            check,
            format_args!("submitted {} s ago", (now - newest) / 1_000_000),
        ),
    }
}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes >> 20)
}
