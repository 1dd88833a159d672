//! Databases of every schema there has been, with rows in them, brought to the newest.
#![allow(clippy::unwrap_used)]

use sqlx::AssertSqlSafe;
use uuid::Uuid;

#[cfg(feature = "postgres")]
use super::POSTGRES;
use super::{MigrateError, SQLITE, newest};
use crate::conformance::on_each_empty;
use crate::jobs::{Queue, repair};
use crate::store::job::{self, Filter, State};
use crate::store::key::{self, HOME};
use crate::store::{Db, Tx, bike, idempotency_key, parameter, result, ride, trial};

/// Rows as the first schema had them; `{group}` is where later ones name the group, and a line
/// `-- from N` stands above what earlier ones than N do not have.
const ROWS: &str = include_str!("rows.sql");

/// The schema from which on jobs store their result.
const RESULTS: i64 = 18;

/// What `veloid seed` wrote, until schema 16 took it away.
const SEASON: &str = include_str!("season.sql");

/// Tables with rows in them, without those that migrations add.
const TABLES: [&str; 9] = [
    "bike",
    "ride",
    "job",
    "trial",
    "result",
    "parameter WHERE method <> 'result'",
    "idempotency_key",
    "worker",
    "river_job",
];

fn id(number: u128) -> Uuid {
    Uuid::from_u128((0x018b_cfe5_6800_7000_8000 << 48) + number)
}

/// Makes tables and queue as they were.
async fn migrate_to(db: &Db, schema: i64) {
    match db {
        Db::Sqlite { write, .. } => {
            SQLITE.run_to(schema, write).await.unwrap();
            super::SqliteMigrator::new(write.clone())
                .migrate_up()
                .await
                .unwrap();
        }
        #[cfg(feature = "postgres")]
        Db::Postgres { write, .. } => {
            POSTGRES.run_to(schema, write).await.unwrap();
            super::PostgresMigrator::new(write.clone())
                .migrate_up()
                .await
                .unwrap();
        }
    }
}

async fn execute(tx: &mut Tx, sql: String) {
    let done = on!(tx, t => sqlx::raw_sql(AssertSqlSafe(sql)).execute(&mut **t).await.map(drop));
    done.unwrap();
}

async fn fill(db: &Db, schema: i64) -> i64 {
    let queue = Queue(db.river().build().unwrap());
    let mut tx = db.begin().await.unwrap();
    let row = queue.observe(&mut tx, id(4)).await.unwrap();
    insert(&mut tx, ROWS, schema, row).await;
    tx.commit().await.unwrap();
    row
}

/// Runs the statements of a text that a schema has.
async fn insert(tx: &mut Tx, text: &str, schema: i64, row: i64) {
    let (group, home) = match schema {
        ..4 => ("", ""),
        _ => (", group_name", ", 'default'"),
    };
    let mut sql = text
        .replace("{group}", group)
        .replace("{home}", home)
        .replace("{river}", &row.to_string());
    for number in 1..=7 {
        let literal = match tx {
            Tx::Sqlite(..) => format!("x'{}'", id(number).simple()),
            #[cfg(feature = "postgres")]
            Tx::Postgres(..) => format!("'{}'", id(number)),
        };
        sql = sql.replace(&format!("#{number}"), &literal);
    }
    for statement in sql.split("\n\n") {
        let from = statement
            .strip_prefix("-- from ")
            .and_then(|rest| rest.lines().next());
        if from.is_none_or(|from| from.parse::<i64>().unwrap() <= schema) {
            execute(tx, statement.to_owned()).await;
        }
    }
}

async fn counts(db: &Db) -> Vec<i64> {
    let mut counts = Vec::new();
    for table in TABLES {
        let sql = AssertSqlSafe(format!("SELECT COUNT(*) FROM {table}"));
        let count = on!(read db, p => sqlx::query_scalar(sql).fetch_one(p).await);
        counts.push(count.unwrap());
    }
    counts
}

#[tokio::test]
async fn a_database_of_every_schema_keeps_what_is_in_it() {
    for schema in 1..=newest() {
        on_each_empty(async |db| {
            migrate_to(&db, schema).await;
            let row = fill(&db, schema).await;
            let before = counts(&db).await;
            assert!(before.iter().all(|count| *count > 0), "{before:?}");
            db.migrate().await.unwrap();
            assert_eq!(counts(&db).await, before, "from schema {schema}");
            if let Some(read) = db.sqlite() {
                let broken = sqlx::query("PRAGMA foreign_key_check")
                    .fetch_all(read)
                    .await;
                assert!(broken.unwrap().is_empty(), "from schema {schema}");
            }
            if schema < RESULTS {
                let found = parameter::results(&db, &[id(2)]).await.unwrap();
                let values: Vec<_> = found.iter().map(|r| (r.value, r.std_error)).collect();
                assert_eq!(values, [(109_000.0, Some(210.0))], "from schema {schema}");
            }
            is_read(&db, row).await;
            if schema >= 3 {
                let key = key::find(&db, "cd").await.unwrap().unwrap();
                assert!(key.is_valid() && key.max_upload_bytes == Some(1000));
            }
            if schema >= 4 {
                let other = bike::find(&db, "others", "lab-7").await.unwrap().unwrap();
                assert_eq!(other.document.0.mass_front_kg, Some(9.0));
                let mut tx = db.begin().await.unwrap();
                assert_eq!(key::unfinished_jobs(&mut tx, id(5)).await.unwrap(), 1);
            }
        })
        .await;
    }
}

/// Numbers of methods that no result states are gone; an axle that only the sensors identified keeps its own.
#[tokio::test]
async fn numbers_that_the_result_withholds_are_gone() {
    const WITHHELD: &str = include_str!("withheld.sql");
    const LEFT: &str = "SELECT method || ' ' || axle || ' ' || name FROM parameter \
        WHERE verdict = 'cannot_tell' ORDER BY 1";
    on_each_empty(async |db| {
        migrate_to(&db, 19).await;
        let row = fill(&db, 19).await;
        let real = counts(&db).await;
        let mut tx = db.begin().await.unwrap();
        insert(&mut tx, WITHHELD, 19, row).await;
        tx.commit().await.unwrap();
        db.migrate().await.unwrap();
        let left: Vec<String> =
            on!(read &db, p => sqlx::query_scalar(LEFT).fetch_all(p).await).unwrap();
        assert_eq!(
            left,
            [
                "latent_road rear k_n_m",
                "output_error front b_n_s_m",
                "result front b_n_s_m"
            ]
        );
        let mut tx = db.begin().await.unwrap();
        execute(
            &mut tx,
            "DELETE FROM parameter WHERE verdict = 'cannot_tell'".to_owned(),
        )
        .await;
        tx.commit().await.unwrap();
        assert_eq!(counts(&db).await, real);
    })
    .await;
}

/// Rides that were made up go with all that is theirs, and nothing else does.
#[tokio::test]
async fn rides_that_were_made_up_are_gone() {
    const THEIRS: [&str; 3] = [
        "SELECT COUNT(*) FROM ride_tag",
        "SELECT COUNT(*) FROM bike_told",
        "SELECT COUNT(*) FROM bike WHERE name LIKE 'season%'",
    ];
    for schema in [1, 4, 15] {
        on_each_empty(async |db| {
            migrate_to(&db, schema).await;
            let row = fill(&db, schema).await;
            let real = counts(&db).await;
            let mut tx = db.begin().await.unwrap();
            insert(&mut tx, SEASON, schema, row).await;
            tx.commit().await.unwrap();
            assert_ne!(counts(&db).await, real);
            db.migrate().await.unwrap();
            assert_eq!(counts(&db).await, real, "from schema {schema}");
            for sql in THEIRS {
                let left: i64 =
                    on!(read &db, p => sqlx::query_scalar(sql).fetch_one(p).await).unwrap();
                assert_eq!(left, 0, "{sql}");
            }
            is_read(&db, row).await;
        })
        .await;
    }
}

/// The store reads all rows that any schema has, and goes on with the job that waits.
async fn is_read(db: &Db, row: i64) {
    let bike = bike::find(db, HOME, "lab-7").await.unwrap().unwrap();
    assert_eq!((bike.jobs, bike.document.0.mass_rear_kg), (3, Some(63.0)));
    let ride = ride::find(db, HOME, id(1)).await.unwrap().unwrap();
    assert_eq!((ride.name.as_str(), ride.bytes), ("ride.csv", 3));

    let done = job::find(db, HOME, id(2)).await.unwrap().unwrap();
    assert_eq!((done.state, done.revision), (State::Succeeded, 6));
    assert_eq!(done.verdict.as_deref(), Some("named"));
    assert_eq!(done.request.0.options.settings.seed, 7);
    assert_eq!(done.request.0.options.reading.rate_hz, Some(200.0));
    assert_eq!(done.summary.0.ignored, ["x"]);
    let front = done.least_squares.unwrap().0.front.unwrap();
    assert_eq!(front.b_n_s_m, 1200.0);
    let failed = job::find(db, HOME, id(3)).await.unwrap().unwrap();
    assert_eq!(failed.failure.unwrap().0.kind, "crash");
    let all = Filter {
        group: HOME,
        ..Filter::default()
    };
    assert_eq!(job::page(db, &all, 9).await.unwrap().len(), 3);

    let trials = trial::list(db, id(2)).await.unwrap();
    assert_eq!(trials[0].result.as_ref().unwrap().0.best_cost, [0.5, 0.25]);
    let report = result::find(db, id(2), result::REPORT).await.unwrap();
    let report = report.unwrap();
    assert_eq!(report.text, r#"{"veloid": "0.1.0"}"#);
    assert!(!report.is_checked, "it was stored without a checksum");
    let named = parameter::Filter {
        group: HOME,
        effect: Some("coulomb_friction"),
        ..parameter::Filter::default()
    };
    let parameters = parameter::page(db, &named, 9).await.unwrap();
    assert_eq!((parameters.len(), parameters[0].value), (1, 20.5));

    let mut tx = db.begin().await.unwrap();
    let used = idempotency_key::find(&mut tx, HOME, "once").await.unwrap();
    assert_eq!(used, Some(("f2".to_owned(), id(2))));
    assert_eq!(job::lock(&mut tx, id(4)).await.unwrap(), Some(Some(row)));
    job::start(&mut tx, id(4)).await.unwrap();
    tx.commit().await.unwrap();
    let running = job::find(db, HOME, id(4)).await.unwrap().unwrap();
    assert_eq!(running.state, State::Running);
}

/// A report as it was stored while a model that ran away wrote NaN into it, and one that is sound.
fn report(position_max: &str) -> String {
    let simulated_ride = veloid_engine::simulate::simulated_ride::SimulatedRide {
        duration_s: 5.0,
        ..Default::default()
    };
    let settings = veloid_engine::Settings {
        trials: 1,
        particles: 8,
        iterations: 2,
        diagnosis: false,
        ..Default::default()
    };
    let bike = r#"{"bike": "lab-7", "mass_front_kg": 23.0, "mass_rear_kg": 63.0}"#;
    let bike = veloid_engine::bicycle::Bike::from_json(bike).unwrap();
    let quiet = veloid_engine::Silent;
    let report = veloid_engine::identify(&simulated_ride.ride(), &bike, &settings, &quiet).unwrap();
    let mut report = serde_json::to_value(report).unwrap();
    report["comparison"]["rows"][0]["position_max_m"] = serde_json::from_str(position_max).unwrap();
    report.to_string()
}

/// Of the jobs that schema 5 has at their end, what cannot be read starts again, once, and nothing else.
#[tokio::test]
async fn jobs_with_numbers_that_are_none_begin_anew() {
    let null = r#"{"kind": "internal", "detail": "gave up after 3 attempts: database: ... invalid type: null, expected f64 at line 1"}"#;
    for (stored, failure, states) in [
        (report("null"), null, [State::Queued, State::Queued]),
        (
            report("0.001"),
            r#"{"kind": "crash", "detail": "null"}"#,
            [State::Succeeded, State::Failed],
        ),
    ] {
        on_each_empty(async |db| {
            migrate_to(&db, 5).await;
            fill(&db, 5).await;
            let mut tx = db.begin().await.unwrap();
            for (sql, value) in [
                (
                    "UPDATE result SET document = $1 WHERE name = 'report'",
                    stored.as_str(),
                ),
                (
                    "UPDATE job SET failure = $1 WHERE state = 'failed'",
                    failure,
                ),
            ] {
                let value: sqlx::types::Json<serde_json::Value> =
                    sqlx::types::Json(serde_json::from_str(value).unwrap());
                on!(&mut tx, t => sqlx::query(sql).bind(value).execute(&mut **t).await.map(drop))
                    .unwrap();
            }
            tx.commit().await.unwrap();
            db.migrate().await.unwrap();
            let queue = Queue(db.river().build().unwrap());
            for _ in 0..2 {
                repair(&db, &queue).await.unwrap();
                for (number, state) in [2, 3].into_iter().zip(states) {
                    let job = job::find(&db, HOME, id(number)).await.unwrap().unwrap();
                    assert_eq!(job.state, state, "job {number}");
                    assert_eq!(job.verdict.is_some(), job.state == State::Succeeded);
                }
            }
            let left = result::find(&db, id(2), result::REPORT).await.unwrap();
            assert_eq!(left.is_some(), states[0] == State::Succeeded);
            let waits = job::find(&db, HOME, id(4)).await.unwrap().unwrap();
            assert_eq!((waits.state, waits.revision), (State::Queued, 1));
        })
        .await;
    }
}

#[tokio::test]
async fn a_database_of_a_newer_program_is_refused_and_left_alone() {
    on_each_empty(async |db| {
        db.migrate().await.unwrap();
        let mut tx = db.begin().await.unwrap();
        let later = "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time) \
            SELECT 999, 'later', success, checksum, execution_time FROM _sqlx_migrations WHERE version = 1";
        execute(&mut tx, later.to_owned()).await;
        tx.commit().await.unwrap();
        let refused = db.migrate().await.unwrap_err();
        assert!(matches!(refused, MigrateError::Newer { found: 999, .. }), "{refused}");
    })
    .await;
}

/// Name and type of every column. Types have two names for the same.
async fn columns(db: &Db) -> Vec<(String, String, String)> {
    const SQLITE: &str = "\
        SELECT m.name, c.name, c.type FROM sqlite_master m, pragma_table_info(m.name) c \
        WHERE m.type = 'table' AND m.name NOT LIKE '%sql%' AND m.name NOT LIKE 'river%'";
    const POSTGRES: &str = "\
        SELECT table_name::TEXT, column_name::TEXT, data_type::TEXT FROM information_schema.columns \
        WHERE table_schema = 'public' AND table_name NOT LIKE '%sql%' AND table_name NOT LIKE 'river%'";
    let sql = db.spelt(SQLITE, POSTGRES);
    let rows = on!(read db, p => sqlx::query_as(sql).fetch_all(p).await);
    let mut rows: Vec<(String, String, String)> = rows.unwrap();
    for (_, _, kind) in &mut rows {
        *kind = match kind.as_str() {
            "uuid" => "BLOB".to_owned(),
            "bigint" => "INTEGER".to_owned(),
            "double precision" => "REAL".to_owned(),
            "json" => "TEXT".to_owned(),
            other => other.to_uppercase(),
        };
    }
    rows.sort();
    rows
}

/// Whichever way each database went, the outcome is the same.
#[tokio::test]
async fn both_databases_end_with_the_same_columns() {
    let outcomes = std::sync::Mutex::new(Vec::new());
    on_each_empty(async |db| {
        db.migrate().await.unwrap();
        let outcome = columns(&db).await;
        outcomes.lock().unwrap().push(outcome);
    })
    .await;
    let outcomes = outcomes.into_inner().unwrap();
    assert!(outcomes[0].len() > 50, "{:?}", outcomes[0]);
    assert!(
        outcomes.iter().all(|columns| *columns == outcomes[0]),
        "{outcomes:#?}"
    );
}
