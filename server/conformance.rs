//! What store and queue promise, held against SQLite always and against PostgreSQL where
//! `VELOID_TEST_POSTGRES` names a server such as `postgres://postgres@127.0.0.1:5432`.
#![allow(clippy::unwrap_used)]

use riverqueue::JobState;
use serde_json::{Value, json};
#[cfg(feature = "postgres")]
use sqlx::{AssertSqlSafe, Connection, PgConnection};
use uuid::Uuid;
use veloid_engine::bicycle::{Bike, PerAxle};
use veloid_engine::report::Trial;
use veloid_engine::ride::RideSummary;

use crate::jobs::{Hub, Queue, give_up, sweep};
use crate::options::Options;
use crate::store::job::{self, Failure, Filter, NewJob, Request, Stage, State};
use crate::store::key::HOME;
use crate::store::{Db, bike, idempotency_key, loss, on, result, ride, trial, turn, worker};

fn home() -> Filter<'static> {
    Filter {
        group: HOME,
        ..Filter::default()
    }
}

/// Runs a test on a fresh database of each kind.
pub async fn on_each(test: impl AsyncFn(Db)) {
    on_each_empty(async |db| {
        db.migrate().await.unwrap();
        test(db).await;
    })
    .await;
}

/// Runs a test on a database of each kind that has no tables yet.
pub async fn on_each_empty(test: impl AsyncFn(Db)) {
    let name = format!("veloid_conformance_{}", Uuid::now_v7().simple());
    let folder = std::env::temp_dir().join(&name);
    std::fs::create_dir(&folder).unwrap();
    let url = format!("sqlite:{}", folder.join("veloid.db").display());
    test(Db::connect(&url).await.unwrap()).await;
    std::fs::remove_dir_all(folder).unwrap();
    on_empty_postgres(&name, test).await;
}

#[cfg(not(feature = "postgres"))]
async fn on_empty_postgres(_: &str, _: impl AsyncFn(Db)) {
    crate::skips::not_applicable("built without the feature `postgres`");
}

#[cfg(feature = "postgres")]
async fn on_empty_postgres(name: &str, test: impl AsyncFn(Db)) {
    let Ok(server) = std::env::var("VELOID_TEST_POSTGRES") else {
        return crate::skips::not_applicable("VELOID_TEST_POSTGRES names no PostgreSQL");
    };
    let mut admin = PgConnection::connect(&format!("{server}/postgres"))
        .await
        .unwrap();
    let create = format!("CREATE DATABASE {name}");
    sqlx::query(AssertSqlSafe(create))
        .execute(&mut admin)
        .await
        .unwrap();
    let url = format!("{server}/{name}");
    test(Db::connect(&url).await.unwrap()).await;
    let drop = format!("DROP DATABASE {name} WITH (FORCE)");
    sqlx::query(AssertSqlSafe(drop))
        .execute(&mut admin)
        .await
        .unwrap();
}

pub fn queue(db: &Db) -> Queue {
    Queue(db.river().build().unwrap())
}

const TRIALS: usize = 10;

async fn queued(db: &Db, queue: &Queue) -> (Uuid, i64) {
    queued_in(db, queue, HOME).await
}

/// A job as an upload leaves it behind, and its River row.
pub async fn queued_in(db: &Db, queue: &Queue, group: &str) -> (Uuid, i64) {
    let (id, mut options) = (Uuid::now_v7(), Options::default());
    options.settings.trials = TRIALS;
    let request = Request {
        bike: Bike::default(),
        options,
    };
    let mut tx = db.begin().await.unwrap();
    bike::upsert(&mut tx, group, "lab", &request.bike)
        .await
        .unwrap();
    let ride = ride::upsert(&mut tx, group, "0f", "ride.csv", 3)
        .await
        .unwrap();
    let new = NewJob {
        id,
        group,
        key: None,
        ride,
        bike: "lab",
        fingerprint: "f1",
        request: &request,
        summary: &RideSummary::default(),
        ridden_at: None,
        study: None,
    };
    job::insert(&mut tx, &new).await.unwrap();
    let row = queue.observe(&mut tx, id).await.unwrap();
    turn::take(&mut tx, id).await.unwrap();
    job::enter(&mut tx, id, Stage::Observe, row).await.unwrap();
    tx.commit().await.unwrap();
    (id, row)
}

/// A job whose trials are queued, so many to a row; the River row of each.
async fn in_trials(db: &Db, queue: &Queue, share: usize) -> (Uuid, Vec<i64>) {
    let (id, observe) = queued(db, queue).await;
    let mut tx = db.begin().await.unwrap();
    job::start(&mut tx, id).await.unwrap();
    queue.cancel(&mut tx, &[observe]).await.unwrap();
    assert!(
        job::observed(&mut tx, id, &PerAxle::default())
            .await
            .unwrap()
    );
    let rows = queue.trials(&mut tx, id, TRIALS, share).await.unwrap();
    trial::insert(&mut tx, id, 1, &rows).await.unwrap();
    tx.commit().await.unwrap();
    (id, rows)
}

async fn state(db: &Db, id: Uuid) -> State {
    job::load(db, id).await.unwrap().unwrap().state
}

async fn row_state(queue: &Queue, row: i64) -> JobState {
    queue.0.jobs().get(row).await.unwrap().state
}

/// Makes a River row look as if a worker had begun it.
pub async fn begun_by(db: &Db, row: i64, worker: &str) {
    const SQLITE: &str = "UPDATE river_job SET state = 'running', attempt = 1, \
        attempted_at = datetime('now', 'subsec'), attempted_by = jsonb_array($2) WHERE id = $1";
    const POSTGRES: &str = "UPDATE river_job SET state = 'running', attempt = 1, \
        attempted_at = now(), attempted_by = ARRAY[$2] WHERE id = $1";
    let mut tx = db.begin().await.unwrap();
    let sql = tx.spelt(SQLITE, POSTGRES);
    let done = on!(&mut tx, t => sqlx::query(sql).bind(row).bind(worker).execute(&mut **t).await.map(drop));
    done.unwrap();
    tx.commit().await.unwrap();
}

#[tokio::test]
async fn migrations_can_be_repeated_and_on_postgres_run_at_once() {
    on_each(async |db| {
        db.migrate().await.unwrap();
        if !db.is_sqlite() {
            let again = || db.migrate();
            let (a, b, c, d) = tokio::join!(again(), again(), again(), again());
            assert!([a, b, c, d].iter().all(Result::is_ok));
        }
    })
    .await;
}

#[tokio::test]
async fn a_job_goes_its_way_and_no_step_twice() {
    on_each(async |db| {
        let queue = queue(&db);
        let (id, _) = queued(&db, &queue).await;
        let none = PerAxle::default();
        let mut tx = db.begin().await.unwrap();
        assert!(
            !job::observed(&mut tx, id, &none).await.unwrap(),
            "it is not running"
        );
        job::start(&mut tx, id).await.unwrap();
        assert!(job::observed(&mut tx, id, &none).await.unwrap());
        assert!(!job::observed(&mut tx, id, &none).await.unwrap());
        job::enter(&mut tx, id, Stage::Diagnose, 7).await.unwrap();
        assert!(
            job::succeed(&mut tx, id, Some("named"), None)
                .await
                .unwrap()
        );
        assert!(!job::succeed(&mut tx, id, None, None).await.unwrap());
        assert!(!job::end(&mut tx, id, None).await.unwrap());
        assert!(
            !job::reset(&mut tx, id, [State::Failed, State::Cancelled])
                .await
                .unwrap()
        );
        tx.commit().await.unwrap();
        let job = job::load(&db, id).await.unwrap().unwrap();
        assert_eq!(
            (job.state, job.verdict.as_deref()),
            (State::Succeeded, Some("named"))
        );
        assert_eq!(
            job.revision, 6,
            "inserted, entered, started, observed, entered, ended"
        );
        assert_eq!(job::revision(&db, HOME, id).await.unwrap(), Some((6, true)));
    })
    .await;
}

#[tokio::test]
async fn a_cancelled_job_stays_cancelled_until_it_is_begun_anew() {
    on_each(async |db| {
        let queue = queue(&db);
        let (id, rows) = in_trials(&db, &queue, 1).await;
        let mut tx = db.begin().await.unwrap();
        assert!(give_up(&queue, &mut tx, id, None).await.unwrap());
        assert!(!give_up(&queue, &mut tx, id, None).await.unwrap());
        assert!(!job::count_trials(&mut tx, id, 1).await.unwrap());
        assert!(!job::succeed(&mut tx, id, None, None).await.unwrap());
        tx.commit().await.unwrap();
        assert_eq!(state(&db, id).await, State::Cancelled);
        for row in rows {
            assert_eq!(row_state(&queue, row).await, JobState::Cancelled);
        }
        let mut tx = db.begin().await.unwrap();
        assert!(
            job::reset(&mut tx, id, [State::Failed, State::Cancelled])
                .await
                .unwrap()
        );
        trial::delete(&mut tx, id).await.unwrap();
        tx.commit().await.unwrap();
        assert_eq!(state(&db, id).await, State::Queued);
    })
    .await;
}

#[tokio::test]
async fn of_trials_that_end_at_once_one_is_the_last() {
    on_each(async |db| {
        let (id, _) = in_trials(&db, &queue(&db), 1).await;
        let counts = (0..TRIALS).map(|_| {
            let db = db.clone();
            tokio::spawn(async move {
                let mut tx = db.begin().await.unwrap();
                let last = job::count_trials(&mut tx, id, 1).await.unwrap();
                tx.commit().await.unwrap();
                last
            })
        });
        let mut last = 0;
        for count in counts.collect::<Vec<_>>() {
            last += i32::from(count.await.unwrap());
        }
        assert_eq!(last, 1);
    })
    .await;
}

#[tokio::test]
async fn trials_that_share_a_row_are_taken_over_together_and_stored_once() {
    on_each(async |db| {
        let (queue, found) = (queue(&db), vec![Trial::default(); TRIALS]);
        let (id, rows) = in_trials(&db, &queue, 4).await;
        let expected = [0, 0, 0, 0, 4, 4, 4, 4, 8, 8].map(|trial| rows[trial]);
        assert_eq!(rows, expected);
        begun_by(&db, rows[4], "dead").await;
        sweep(&db, &queue, &Hub::new()).await.unwrap();
        let mut tx = db.begin().await.unwrap();
        let unfinished = trial::unfinished(&mut tx, id).await.unwrap();
        let [new] = unfinished[..]
            .iter()
            .filter(|row| !rows.contains(row))
            .collect::<Vec<_>>()[..]
        else {
            panic!("{unfinished:?} after {rows:?}");
        };
        tx.commit().await.unwrap();
        let args = queue.0.jobs().get(*new).await.unwrap().encoded_args;
        let args: Value = serde_json::from_str(args.get()).unwrap();
        assert_eq!(args, json!({"job": id, "index": 4, "count": 4}));
        let mut tx = db.begin().await.unwrap();
        for (first, count, left) in [(4, 4, 2), (0, 4, 1), (8, 2, 0)] {
            let results = &found[first..first + count];
            let stored = trial::finish(&mut tx, id, first, results).await.unwrap();
            assert_eq!(stored, count as i64);
            let again = trial::finish(&mut tx, id, first, results).await.unwrap();
            assert_eq!(again, 0);
            let last = job::count_trials(&mut tx, id, stored).await.unwrap();
            assert_eq!(last, left == 0);
            assert_eq!(trial::unfinished(&mut tx, id).await.unwrap().len(), left);
        }
        tx.commit().await.unwrap();
    })
    .await;
}

#[tokio::test]
async fn what_is_queued_is_there_with_its_transaction_or_not_at_all() {
    on_each(async |db| {
        let queue = queue(&db);
        let mut tx = db.begin().await.unwrap();
        let row = queue.observe(&mut tx, Uuid::now_v7()).await.unwrap();
        drop(tx);
        let missing = queue.0.jobs().get(row).await.unwrap_err();
        assert!(
            matches!(missing, riverqueue::Error::NotFound(_)),
            "{missing}"
        );
        let (_, row) = queued(&db, &queue).await;
        assert_eq!(row_state(&queue, row).await, JobState::Available);
    })
    .await;
}

/// Lets the process die that has a row of a job's trials; the row that took over, if one did.
async fn dies_with(db: &Db, queue: &Queue, id: Uuid, held: i64, is_alone: bool) -> Option<i64> {
    begun_by(db, held, "dead").await;
    let mut tx = db.begin().await.unwrap();
    let before = trial::unfinished(&mut tx, id).await.unwrap();
    if is_alone {
        assert!(loss::alone(&mut tx, id, held).await.unwrap());
    }
    tx.commit().await.unwrap();
    sweep(db, queue, &Hub::new()).await.unwrap();
    assert_eq!(row_state(queue, held).await, JobState::Discarded);
    let mut tx = db.begin().await.unwrap();
    let rows = trial::unfinished(&mut tx, id).await.unwrap();
    tx.commit().await.unwrap();
    assert_eq!(rows.len(), TRIALS);
    rows.into_iter().find(|row| !before.contains(row))
}

#[tokio::test]
async fn work_is_taken_over_from_the_dead_alone_and_who_was_beside_them_is_not_to_blame() {
    on_each(async |db| {
        let (queue, hub) = (queue(&db), Hub::new());
        let (id, rows) = in_trials(&db, &queue, 1).await;
        let mut held = rows[3];
        let mut tx = db.begin().await.unwrap();
        worker::beat(&mut tx, "alive", 1).await.unwrap();
        tx.commit().await.unwrap();
        begun_by(&db, held, "alive").await;
        sweep(&db, &queue, &hub).await.unwrap();
        assert_eq!(row_state(&queue, held).await, JobState::Running);

        for death in 1..=20 {
            held = dies_with(&db, &queue, id, held, false).await.unwrap();
            assert_eq!(row_state(&queue, held).await, JobState::Available);
            let standing = loss::standing(&db, id).await.unwrap();
            assert_eq!(standing.is_suspect(), death >= 2);
        }
        let job = job::load(&db, id).await.unwrap().unwrap();
        assert_eq!(job.state, State::Running);
    })
    .await;
}

#[tokio::test]
async fn a_job_that_is_alone_when_three_processes_die_is_the_cause() {
    on_each(async |db| {
        let queue = queue(&db);
        let (id, rows) = in_trials(&db, &queue, 1).await;
        let (other, _) = queued(&db, &queue).await;
        let mut held = rows[3];
        // What it has done since the last death speaks for it.
        for (deaths, progress) in [(4, true), (5, false)] {
            for death in 1..=deaths {
                let new = dies_with(&db, &queue, id, held, death > 2).await;
                assert_eq!(new.is_none(), death == 5);
                held = new.unwrap_or(held);
                let behind = loss::standing(&db, other).await.unwrap();
                assert_eq!(behind.gives_way(), (3..5).contains(&death));
                assert!(!behind.is_suspect());
                assert!(!loss::standing(&db, id).await.unwrap().gives_way());
            }
            if progress {
                let mut tx = db.begin().await.unwrap();
                assert!(!job::count_trials(&mut tx, id, 1).await.unwrap());
                tx.commit().await.unwrap();
                assert!(!loss::standing(&db, id).await.unwrap().is_suspect());
            }
        }
        let job = job::load(&db, id).await.unwrap().unwrap();
        assert_eq!(job.state, State::Failed);
        let failure = job.failure.unwrap();
        assert_eq!(failure.kind, "crash");
        assert!(
            failure.detail.starts_with("5 processes"),
            "{}",
            failure.detail
        );
        assert_eq!(state(&db, other).await, State::Queued);
    })
    .await;
}

#[tokio::test]
async fn one_row_of_a_suspect_at_a_time_has_a_process_to_itself() {
    on_each(async |db| {
        let queue = queue(&db);
        let (id, rows) = in_trials(&db, &queue, 1).await;
        let alone = async |row| {
            let mut tx = db.begin().await.unwrap();
            let noted = loss::alone(&mut tx, id, row).await.unwrap();
            tx.commit().await.unwrap();
            noted
        };
        begun_by(&db, rows[0], "here").await;
        begun_by(&db, rows[1], "there").await;
        assert!(alone(rows[0]).await);
        assert!(alone(rows[0]).await, "a retry of the same row");
        assert!(!alone(rows[1]).await);
        let mut tx = db.begin().await.unwrap();
        loss::survived(&mut tx, id, rows[1]).await.unwrap();
        loss::survived(&mut tx, id, rows[0]).await.unwrap();
        tx.commit().await.unwrap();
        assert!(alone(rows[1]).await);
    })
    .await;
}

#[tokio::test]
async fn a_job_that_the_queue_has_nothing_for_fails() {
    on_each(async |db| {
        let queue = queue(&db);
        let (stray, row) = queued(&db, &queue).await;
        let (sound, _) = queued(&db, &queue).await;
        let mut tx = db.begin().await.unwrap();
        queue.cancel(&mut tx, &[row]).await.unwrap();
        tx.commit().await.unwrap();
        sweep(&db, &queue, &Hub::new()).await.unwrap();
        assert_eq!(state(&db, stray).await, State::Failed);
        assert_eq!(state(&db, sound).await, State::Queued);
    })
    .await;
}

#[tokio::test]
async fn workers_are_there_while_they_beat() {
    on_each(async |db| {
        let mut tx = db.begin().await.unwrap();
        worker::beat(&mut tx, "a", 1).await.unwrap();
        worker::beat(&mut tx, "a", 1).await.unwrap();
        worker::beat(&mut tx, "b", 1).await.unwrap();
        worker::expire(&mut tx, 3_600_000).await.unwrap();
        worker::leave(&mut tx, "b").await.unwrap();
        tx.commit().await.unwrap();
        assert_eq!(worker::count(&db).await.unwrap(), 1);
        let mut tx = db.begin().await.unwrap();
        worker::expire(&mut tx, 0).await.unwrap();
        tx.commit().await.unwrap();
        assert_eq!(worker::count(&db).await.unwrap(), 0);
    })
    .await;
}

#[tokio::test]
async fn documents_come_back_number_for_number() {
    on_each(async |db| {
        let (id, _) = queued(&db, &queue(&db)).await;
        let numbers = [0.1 + 0.2, 5e-324, f64::MAX, -1e16, 1.0 / 3.0];
        let mut tx = db.begin().await.unwrap();
        result::put(&mut tx, id, result::OBSERVED, &[1.0])
            .await
            .unwrap();
        result::put(&mut tx, id, result::OBSERVED, &numbers)
            .await
            .unwrap();
        tx.commit().await.unwrap();
        let back: Vec<f64> = result::get(&db, id, result::OBSERVED).await.unwrap();
        assert_eq!(back, numbers);
        let stored = result::find(&db, id, result::OBSERVED).await.unwrap();
        let stored = stored.unwrap();
        assert_eq!(stored.text, serde_json::to_string(&numbers).unwrap());
        assert!(stored.is_checked);
        let report = result::find(&db, id, result::REPORT).await.unwrap();
        assert!(report.is_none());
    })
    .await;
}

#[tokio::test]
async fn jobs_are_found_by_what_they_are() {
    on_each(async |db| {
        let queue = queue(&db);
        let mut ids = Vec::new();
        for _ in 0..3 {
            ids.push(queued(&db, &queue).await.0);
        }
        let mut tx = db.begin().await.unwrap();
        assert_eq!(
            job::find_equal(&mut tx, HOME, "f1").await.unwrap(),
            Some(ids[2])
        );
        let failure = Failure::new("input", "why");
        assert!(
            give_up(&queue, &mut tx, ids[2], Some(&failure))
                .await
                .unwrap()
        );
        assert_eq!(
            job::find_equal(&mut tx, HOME, "f1").await.unwrap(),
            Some(ids[1])
        );
        idempotency_key::insert(&mut tx, HOME, "key", "f1", ids[0])
            .await
            .unwrap();
        let used = idempotency_key::find(&mut tx, HOME, "key").await.unwrap();
        assert_eq!(used, Some(("f1".to_owned(), ids[0])));
        tx.commit().await.unwrap();

        let page = async |filter: Filter<'_>, limit| -> Vec<Uuid> {
            let rows = job::page(&db, &filter, limit).await.unwrap();
            rows.iter().map(|row| row.id).collect()
        };
        assert_eq!(page(home(), 2).await, [ids[2], ids[1]]);
        let older = Filter {
            before: Some(ids[1]),
            ..home()
        };
        assert_eq!(page(older, 2).await, [ids[0]]);
        let failed = Filter {
            state: Some(State::Failed),
            ..home()
        };
        assert_eq!(page(failed, 9).await, [ids[2]]);
        let foreign = Filter {
            bike: Some("other"),
            ..home()
        };
        assert!(page(foreign, 9).await.is_empty());

        let mut tx = db.begin().await.unwrap();
        let again = idempotency_key::insert(&mut tx, HOME, "key", "f2", ids[1])
            .await
            .unwrap_err();
        assert!(again.as_database_error().unwrap().is_unique_violation());
    })
    .await;
}

/// Nobody waits for a statement that is only curious, and no lock outlives who is gone.
#[cfg(feature = "postgres")]
#[tokio::test]
async fn postgres_ends_what_takes_too_long() {
    on_each(async |db| {
        let Db::Postgres { write, read, .. } = &db else {
            return;
        };
        let of = async |pool, what: &str| -> String {
            let sql = AssertSqlSafe(format!("SHOW {what}"));
            sqlx::query_scalar(sql).fetch_one(pool).await.unwrap()
        };
        assert_eq!(of(read, "statement_timeout").await, "10s");
        assert_eq!(of(write, "statement_timeout").await, "1min");
        assert_eq!(of(write, "idle_in_transaction_session_timeout").await, "8s");
    })
    .await;
}
