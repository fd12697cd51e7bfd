//! The data folder of a server, once it is at rest.

use std::path::Path;

use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};

/// Checks a data folder that no server holds: the database is whole, nothing is under way, and
/// every file has its row.
pub async fn check(data: &Path) {
    let options = SqliteConnectOptions::new().filename(data.join("graspd.db"));
    let database = SqlitePool::connect_with(options).await.expect("a database");
    let findings: Vec<String> = sqlx::query_scalar("PRAGMA integrity_check")
        .fetch_all(&database)
        .await
        .expect("a check");
    assert_eq!(findings, ["ok"]);
    let under_way: i64 =
        sqlx::query_scalar("SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')")
            .fetch_one(&database)
            .await
            .expect("a count");
    assert_eq!(under_way, 0);
    let mut rows: Vec<String> = sqlx::query_scalar("SELECT id FROM meshes")
        .fetch_all(&database)
        .await
        .expect("the meshes");
    rows.sort();
    let mut files = names(&data.join("meshes"));
    files.sort();
    assert_eq!(files, rows);
    assert_eq!(names(&data.join("uploads")), [""; 0]);
    database.close().await;
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    entries
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("a name")
        })
        .collect()
}
