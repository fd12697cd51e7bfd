//! Databases of the program before, whose tables several migrations made: they are opened with all that is in them.
//!
//! That program made both: a key, one that was revoked, a mesh, a job with a callback, a batch of two, a job that was
//! cancelled, one that was put back when the server stopped, and one that waits. What is here are their dumps.

use std::collections::BTreeMap;
use std::path::Path;

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Executor, Row};

use super::*;
use crate::store::postgres::{PoolSizes, Postgres};
use crate::store::sqlite::{Sqlite, SqliteKeys, Survey, VERSION};
use testkit::postgres::Cluster;

const FOLDER: &str = include_str!("earlier/sqlite.sql");
const DATABASE: &str = include_str!("earlier/postgres.sql");
/// Keys to what is in them.
const FOLDER_KEY: &str =
    "graspd_dad54f437771_1eb3d51686cf857af590fe9f891a94f2ecbd635ce9205eac9449043c83b388c2";
const DATABASE_KEY: &str =
    "graspd_1eb2ec0432db_4bd798354f47a9ffb0102952de267ca7c63ce1a8228bba30e3d02ce2ab5b8b84";
/// The file of their mesh.
const BOX: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

async fn sqlite(data: &Path) -> SqliteConnection {
    let options = SqliteConnectOptions::new().filename(data.join("graspd.db"));
    options.create_if_missing(true).connect().await.unwrap()
}

async fn postgres(url: &str) -> PgConnection {
    let options: PgConnectOptions = url.parse().unwrap();
    let options = options.options([("search_path", "graspd")]);
    options.connect().await.unwrap()
}

/// A data directory as the program before left it.
async fn folder() -> tempfile::TempDir {
    let data = tempfile::tempdir().unwrap();
    let mut database = sqlite(data.path()).await;
    database.execute(sqlx::raw_sql(FOLDER)).await.unwrap();
    let mesh: String = sqlx::query_scalar("SELECT id FROM meshes")
        .fetch_one(&mut database)
        .await
        .unwrap();
    std::fs::create_dir(data.path().join("meshes")).unwrap();
    std::fs::write(data.path().join("meshes").join(mesh), BOX).unwrap();
    data
}

/// Everything that the program before put in is read.
async fn check(store: &dyn Store, keys: &dyn Keys, key: &str) {
    let owner = store.owner_of(key).await.unwrap().expect("the key is good");
    let keys = keys.list().await.unwrap();
    let revoked = keys.iter().map(|key| key.revoked_at.is_some());
    assert_eq!(revoked.collect::<Vec<_>>(), [false, true]);

    let meshes = store.meshes(&owner, None, 10).await.unwrap().unwrap();
    let [mesh] = &meshes.meshes[..] else {
        panic!("{meshes:?}")
    };
    let file = store.mesh_file(&owner, &mesh.id).await.unwrap();
    assert_eq!(file.unwrap().1, BOX.as_bytes());

    let filter = JobFilter {
        owner: owner.clone(),
        ..JobFilter::default()
    };
    let page = store.jobs(&filter, None, 10).await.unwrap().unwrap();
    let mut jobs: BTreeMap<String, JobState> = BTreeMap::new();
    for job in &page.jobs {
        let record = store.job(&owner, job.id).await.unwrap().unwrap();
        let result = record.result.map(|result| result.get().to_owned());
        assert_eq!(
            result.is_some_and(|result| result.contains("\"quality\"")),
            job.state == JobState::Succeeded
        );
        let place = job.batch_index.map(|index| format!("batch {index}"));
        jobs.insert(place.or(job.label.clone()).unwrap(), job.state);
    }
    let expected = [
        ("batch 0", JobState::Succeeded),
        ("batch 1", JobState::Succeeded),
        ("cancelled", JobState::Cancelled),
        ("first", JobState::Succeeded),
        ("long", JobState::Queued),
        ("waits", JobState::Queued),
    ];
    let expected = expected.map(|(label, state)| (label.to_owned(), state));
    assert_eq!(jobs, BTreeMap::from(expected));
    assert_eq!(store.queued().await.unwrap(), 2);
    let mut ended = store.ended_jobs().await.unwrap();
    ended.retain(|(_, jobs)| *jobs > 0);
    ended.sort_by_key(|(_, jobs)| *jobs);
    assert_eq!(ended, [(JobState::Cancelled, 1), (JobState::Succeeded, 3)]);

    let first = page.jobs.last().expect("the oldest");
    let callback = store.callback(first.id).await.unwrap().unwrap();
    assert_eq!(callback.url, "http://localhost:1/hook");
    assert!(callback.attempts > 0);

    let batches = store.batches(&owner, None, 10).await.unwrap().unwrap();
    let [batch] = &batches.batches[..] else {
        panic!("{batches:?}")
    };
    assert_eq!(
        (batch.label.as_deref(), batch.jobs.total),
        (Some("pair"), 2)
    );
    let results = store.batch_results(&owner, batch.id, None, None, 10).await;
    assert_eq!(results.unwrap().len(), 2);

    // It goes on from there.
    let claim = claim(store).await;
    assert_eq!(claim.mesh_id, mesh.id);
    let (found, progress) = (found(), progress());
    let finished = store.finish(&claim.lease, &found, &progress, claim.revision);
    assert!(finished.await.unwrap());
}

/// The tables as SQLite describes them, whatever order their columns and words have.
async fn sqlite_tables(data: &Path) -> Vec<String> {
    let mut database = sqlite(data).await;
    let statement = "SELECT t.name || ' ' || c.name || ' ' || c.type || ' ' || c.\"notnull\" || ' ' \
        || coalesce(c.dflt_value, '') || ' ' || c.pk || ' ' || c.hidden \
        FROM sqlite_master AS t, pragma_table_xinfo(t.name) AS c WHERE t.type = 'table' \
        UNION SELECT replace(replace(sql, '\"', ''), ' ', '') FROM sqlite_master \
        WHERE type IN ('index', 'trigger') AND sql IS NOT NULL ORDER BY 1";
    let rows = sqlx::query(statement).fetch_all(&mut database).await;
    let lines = rows.unwrap();
    lines.iter().map(|row| row.get(0)).collect()
}

/// The tables as PostgreSQL describes them, whatever order their columns have.
async fn postgres_tables(url: &str) -> Vec<String> {
    let mut database = postgres(url).await;
    let statement = "SELECT concat_ws(' ', table_name, column_name, data_type, collation_name, \
          is_nullable, column_default, is_identity, generation_expression) \
          FROM information_schema.columns WHERE table_schema = 'graspd' \
        UNION SELECT indexdef FROM pg_indexes WHERE schemaname = 'graspd' \
        UNION SELECT pg_get_triggerdef(pg_trigger.oid) FROM pg_trigger \
          WHERE NOT tgisinternal AND tgrelid = 'graspd.jobs'::regclass \
        UNION SELECT conrelid::regclass || ' ' || pg_get_constraintdef(oid) FROM pg_constraint \
          WHERE connamespace = 'graspd'::regnamespace \
        UNION SELECT pg_get_functiondef(oid) FROM pg_proc \
          WHERE pronamespace = 'graspd'::regnamespace ORDER BY 1";
    let rows = sqlx::query(statement).fetch_all(&mut database).await;
    let lines = rows.unwrap();
    lines.iter().map(|row| row.get(0)).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_folder_of_the_program_before_is_opened_with_all_that_is_in_it() {
    let data = folder().await;
    let survey = async || {
        let mut survey = Survey::open(data.path()).await.unwrap();
        survey.schema_version().await.unwrap()
    };
    assert_eq!(survey().await, VERSION);
    let store = Sqlite::open(data.path()).await.unwrap();
    let keys = SqliteKeys::open(data.path()).await.unwrap();
    check(&store, &keys, FOLDER_KEY).await;
    store.close().await;
    drop((store, keys));
    // Once is enough.
    drop(Sqlite::open(data.path()).await.unwrap());
    assert_eq!(survey().await, VERSION);

    let new = tempfile::tempdir().unwrap();
    drop(Sqlite::open(new.path()).await.unwrap());
    let tables = sqlite_tables(data.path()).await;
    assert_eq!(tables, sqlite_tables(new.path()).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_of_the_program_before_is_opened_with_all_that_is_in_it() {
    let cluster = Cluster::shared();
    let (database, new) = (cluster.database(), cluster.database());
    let mut connection = postgres(&database.url).await;
    connection.execute(sqlx::raw_sql(DATABASE)).await.unwrap();
    let open = async |url| Postgres::open(url, PoolSizes::of_server(1)).await.unwrap();
    let store = open(&database.url).await;
    check(&store, &store, DATABASE_KEY).await;
    // Once is enough.
    open(&database.url).await;

    open(&new.url).await;
    let tables = postgres_tables(&database.url).await;
    assert_eq!(tables, postgres_tables(&new.url).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn tables_that_the_program_before_had_not_brought_up_to_date_are_refused() {
    let forget = "DELETE FROM _sqlx_migrations WHERE version = 2";
    let data = folder().await;
    let mut connection = sqlite(data.path()).await;
    connection.execute(forget).await.unwrap();
    let refused = Sqlite::open(data.path()).await.unwrap_err();
    assert!(matches!(refused, OpenError::PartlyMigrated), "{refused}");

    let database = Cluster::shared().database();
    let mut connection = postgres(&database.url).await;
    connection.execute(sqlx::raw_sql(DATABASE)).await.unwrap();
    let mut connection = postgres(&database.url).await;
    connection.execute(forget).await.unwrap();
    let refused = Postgres::open(&database.url, PoolSizes::of_server(1)).await;
    let refused = refused.unwrap_err();
    assert!(matches!(refused, OpenError::PartlyMigrated), "{refused}");
}
