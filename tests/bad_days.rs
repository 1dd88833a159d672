//! Days on which the machine or the input is at fault: the job ends with its reason or goes on once the
//! cause is gone, and the server lives.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use sqlx::{Connection, SqliteConnection};

use crate::harness::{Folder, Server, VELOID, has_points, veloid};
use crate::oracle::{Upload, jobs_are, nothing_is_left, nothing_ran_twice};
use crate::ride;
use crate::skips::{not_applicable, skip};

/// A swarm of some seconds.
const SECONDS: [(&str, &str); 2] = [("iterations", "1000"), ("particles", "60")];

/// A file system that goes when the test ends; none where the tests do not run as root.
pub struct Mount(pub PathBuf);

impl Mount {
    pub fn small(at: PathBuf) -> Option<Self> {
        std::fs::create_dir(&at).unwrap();
        Self::new(at, &["-t", "tmpfs", "-o", "size=24m", "tmpfs"])
    }

    /// The folder once more over itself, so that it can be made read-only by itself.
    fn over(at: PathBuf) -> Option<Self> {
        let from = at.to_str().unwrap().to_owned();
        Self::new(at, &["--bind", &from])
    }

    fn new(at: PathBuf, args: &[&str]) -> Option<Self> {
        let done = Command::new("mount").args(args).arg(&at).output();
        if done.is_ok_and(|output| output.status.success()) {
            return Some(Self(at));
        }
        not_applicable("mounting needs root and its rights");
        None
    }

    fn remount(&self, option: &str) {
        let options = format!("remount,bind,{option}");
        let mut mount = Command::new("mount");
        assert!(
            mount
                .args(["-o", &options])
                .arg(&self.0)
                .status()
                .unwrap()
                .success()
        );
    }

    /// Leaves no byte free.
    pub fn fill(&self) -> PathBuf {
        let path = self.0.join("ballast");
        let mut file = File::create(&path).unwrap();
        for block in [1 << 20, 4096, 1] {
            while file.write_all(&vec![0; block]).is_ok() {}
        }
        path
    }
}

impl Drop for Mount {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("--lazy").arg(&self.0).status();
    }
}

/// The process answers, also what only reads.
async fn lives(server: &Server) {
    assert_eq!(server.get("/healthz").await.status(), 200);
    assert_eq!(server.get("/v1/jobs").await.status(), 200);
}

/// An upload is refused for now, with a reason, and said to be worth another try.
async fn is_put_off(server: &Server, why: &str) {
    let response = server
        .upload(ride::example(), ride::BIKE, &ride::QUICK)
        .await;
    let (status, headers) = (response.status(), response.headers().clone());
    let problem: Value = response.json().await.unwrap();
    assert_eq!(status, 503, "{problem:#}");
    assert!(headers.contains_key("retry-after"));
    assert!(
        problem["detail"].as_str().unwrap().contains(why),
        "{problem:#}"
    );
}

async fn reaches(server: &Server, job: &str, stage: &str) {
    loop {
        let view = server.json(job).await;
        assert!(view["finished_at"].is_null(), "it ended before: {view:#}");
        if view["stage"] == stage {
            return;
        }
    }
}

/// A server with database and files on a disk of its own; none where nothing can be mounted.
fn on_a_small_disk(folder: &Folder, workers: &str) -> Option<(Mount, Server)> {
    let disk = Mount::small(folder.0.join("disk"))?;
    let at = disk.0.display();
    let (database, files) = (format!("sqlite:{at}/veloid.db"), format!("file://{at}"));
    let env = [("DATABASE_URL", &*database), ("VELOID_FILES", &*files)];
    let server = Server::on_sqlite_with_env(&["--workers", workers], &env);
    Some((disk, server))
}

#[tokio::test]
async fn a_full_disk_costs_time_and_nothing_else() {
    let folder = Folder::new();
    let Some((disk, server)) = on_a_small_disk(&folder, "1") else {
        return;
    };
    let upload = Upload::new("key", &SECONDS);
    let job = upload.send(&server).await.unwrap();
    reaches(&server, &job, "trial").await;
    let ballast = disk.fill();
    is_put_off(&server, "no storage space").await;
    lives(&server).await;
    assert_eq!(server.get("/readyz").await.status(), 503);
    // Time for a trial to end, and to find that it cannot be stored.
    tokio::time::sleep(Duration::from_secs(5)).await;
    lives(&server).await;
    std::fs::remove_file(ballast).unwrap();
    upload
        .succeeded_once(&server, &job, &upload.undisturbed().await)
        .await;
    let next = server.submit(&[]).await;
    server.succeeded(&next).await;
    nothing_ran_twice(&server).await;
    // An answer holds for a second.
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert_eq!(server.get("/readyz").await.status(), 200);
    let on_their_way = disk.0.join("incoming").read_dir().unwrap().count();
    assert_eq!(on_their_way, 0, "what was refused is gone");
}

#[tokio::test]
async fn a_read_only_folder_puts_uploads_off() {
    let folder = Folder::new();
    let files = folder.0.join("files");
    std::fs::create_dir(&files).unwrap();
    let Some(mount) = Mount::over(files.clone()) else {
        return;
    };
    let url = format!("file://{}", files.display());
    let server = Server::with_env(&[], &[("VELOID_FILES", &url)]);
    mount.remount("ro");
    is_put_off(&server, "read-only").await;
    lives(&server).await;
    mount.remount("rw");
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    jobs_are(&server, 1).await;
}

/// A folder that nobody may write to, not even root, until the test ends.
struct Locked(PathBuf);

impl Locked {
    fn new(at: PathBuf) -> Option<Self> {
        if chattr("+i", &at) {
            return Some(Self(at));
        }
        not_applicable("locking a folder needs root and a file system that can");
        None
    }
}

impl Drop for Locked {
    fn drop(&mut self) {
        chattr("-i", &self.0);
    }
}

fn chattr(change: &str, at: &Path) -> bool {
    let done = Command::new("chattr").arg(change).arg(at).output();
    done.is_ok_and(|output| output.status.success())
}

#[tokio::test]
async fn a_folder_that_may_not_be_written_puts_uploads_off() {
    let server = Server::start();
    for folder in ["incoming", "rides"] {
        let Some(locked) = Locked::new(server.folder.0.join(folder)) else {
            return;
        };
        is_put_off(&server, "permission denied").await;
        lives(&server).await;
        drop(locked);
    }
    let incoming = server.folder.0.join("incoming");
    assert_eq!(incoming.read_dir().unwrap().count(), 0);
    std::fs::remove_dir(&incoming).unwrap();
    std::fs::write(&incoming, "").unwrap();
    is_put_off(&server, "not a directory").await;
    std::fs::remove_file(&incoming).unwrap();
    std::fs::create_dir(&incoming).unwrap();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    jobs_are(&server, 1).await;
}

#[tokio::test]
async fn a_locked_database_costs_time_and_nothing_else() {
    let server = Server::on_sqlite(&["--workers", "1"]);
    let upload = Upload::new("key", &SECONDS);
    let job = upload.send(&server).await.unwrap();
    reaches(&server, &job, "trial").await;
    let url = format!("sqlite:{}", server.folder.0.join("veloid.db").display());
    let mut other = SqliteConnection::connect(&url).await.unwrap();
    sqlx::query("BEGIN EXCLUSIVE")
        .execute(&mut other)
        .await
        .unwrap();
    is_put_off(&server, "busy").await;
    lives(&server).await;
    sqlx::query("ROLLBACK").execute(&mut other).await.unwrap();
    upload
        .succeeded_once(&server, &job, &upload.undisturbed().await)
        .await;
    nothing_ran_twice(&server).await;
}

/// Debian's place of the library that tells a process another time.
fn libfaketime() -> Option<String> {
    let folders = std::fs::read_dir("/usr/lib").unwrap().flatten();
    let paths = folders.map(|folder| folder.path().join("faketime/libfaketimeMT.so.1"));
    let found = paths.into_iter().find(|path| path.exists());
    if found.is_none() {
        skip("no libfaketime");
    }
    Some(found?.to_str()?.to_owned())
}

/// An hour ahead while a job runs, then two hours back while another does: on SQLite the clock of the
/// process is that of the database.
#[tokio::test]
async fn a_clock_that_is_set_stops_nothing() {
    let Some(library) = libfaketime() else { return };
    let folder = Folder::new();
    let clock = folder.write("clock", "+0");
    let env = [
        ("LD_PRELOAD", library.as_str()),
        ("FAKETIME_TIMESTAMP_FILE", clock.to_str().unwrap()),
        ("FAKETIME_NO_CACHE", "1"),
        ("FAKETIME_DONT_FAKE_MONOTONIC", "1"),
    ];
    let server = Server::on_sqlite_with_env(&["--workers", "1"], &env);
    let upload = Upload::new("ahead", &SECONDS);
    let expected = upload.undisturbed().await;
    for (key, offset) in [("ahead", "+3600"), ("back", "-3600")] {
        let upload = Upload::new(key, &[&SECONDS[..], &[("again", "true")]].concat());
        let job = upload.send(&server).await.unwrap();
        reaches(&server, &job, "trial").await;
        folder.write("clock", offset);
        let set = Instant::now();
        upload.succeeded_once(&server, &job, &expected).await;
        eprintln!(
            "{key}: done {:.1} s after the clock was set",
            set.elapsed().as_secs_f64()
        );
    }
    let next = server.submit(&[]).await;
    server.succeeded(&next).await;
    let view = server.json(&next).await;
    let hour_ago = jiff::Timestamp::now() - jiff::SignedDuration::from_mins(30);
    let created: jiff::Timestamp = view["created_at"].as_str().unwrap().parse().unwrap();
    assert!(created < hour_ago, "the clock was set: {created}");
}

/// Rides that are sent while others wait and the clock has been set back by hours are done all the same, in their order,
/// before and after a restart.
#[tokio::test]
async fn rides_sent_after_the_clock_was_set_back_have_their_turn() {
    let Some(library) = libfaketime() else { return };
    let folder = Folder::new();
    let clock = folder.write("clock", "+0");
    let env = [
        ("LD_PRELOAD", library.as_str()),
        ("FAKETIME_TIMESTAMP_FILE", clock.to_str().unwrap()),
        ("FAKETIME_NO_CACHE", "1"),
        ("FAKETIME_DONT_FAKE_MONOTONIC", "1"),
    ];
    let mut server = Server::on_sqlite_with_env(&["--workers", "1"], &env);
    let long = server.submit(&ride::LONG).await;
    reaches(&server, &long, "trial").await;
    let waits = server.submit(&[("seed", "2")]).await;
    for (offset, seeds) in [("-10800", ["3", "4"]), ("-36000", ["5", "6"])] {
        folder.write("clock", offset);
        for seed in seeds {
            server.submit(&[("seed", seed)]).await;
        }
        const LATER: &str = "\
            SELECT COUNT(*) FROM river_job WHERE state = 'available' AND scheduled_at > '1971-01-01'";
        // What was begun and came back has the time of its return.
        let begun =
            "SELECT COUNT(*) FROM river_job WHERE state = 'available' AND attempted_at IS NOT NULL";
        assert_eq!(server.count(LATER).await, server.count(begun).await);
        server.crash_and_restart();
    }
    assert_eq!(server.cancel(&long).await.unwrap().status(), 200);
    server.succeeded(&waits).await;
    let jobs = server.json("/v1/jobs").await;
    for job in jobs["items"].as_array().unwrap() {
        let job = job["links"]["job"].as_str().unwrap();
        if job != long {
            server.succeeded(job).await;
        }
    }
    jobs_are(&server, 6).await;
    nothing_is_left(&server).await;
}

/// Retries and refused uploads during a full disk are logged now and then, not each time.
#[tokio::test]
async fn a_full_disk_fills_no_log() {
    let folder = Folder::new();
    let Some((disk, server)) = on_a_small_disk(&folder, "2") else {
        return;
    };
    let mut jobs = Vec::new();
    for seed in ["1", "2", "3", "4"] {
        jobs.push(server.submit(&[("trials", "64"), ("seed", seed)]).await);
    }
    reaches(&server, jobs.last().unwrap(), "trial").await;
    let ballast = disk.fill();
    let begun = Instant::now();
    let log = || std::fs::read_to_string(server.folder.0.join("log")).unwrap();
    // Beside other work it takes a while until a trial ends that cannot be stored.
    let most = |seconds| begun.elapsed() < Duration::from_secs(seconds);
    while most(12) || (most(60) && !log().contains("keeping")) {
        is_put_off(&server, "no storage space").await;
    }
    let elapsed = begun.elapsed().as_secs();
    let log = log();
    std::fs::remove_file(ballast).unwrap();
    let mut said = std::collections::BTreeMap::<&str, u64>::new();
    for line in log.lines() {
        let (_, rest) = line
            .split_once(" WARN ")
            .or_else(|| line.split_once("ERROR "))
            .unwrap_or_default();
        // Without times and fields: the message and its module.
        *said.entry(rest.split('=').next().unwrap()).or_default() += 1;
    }
    said.remove("");
    eprintln!("in {elapsed} s: {said:#?}");
    assert!(said.keys().any(|line| line.contains("keeping")), "{log}");
    for (line, times) in said {
        assert!(
            times <= 2 + elapsed / 2,
            "{times} times in {elapsed} s: {line}"
        );
    }
    for job in jobs {
        server.succeeded(&job).await;
    }
}

/// The log of a server that ended before it listened; none if it listens.
fn ended(data: &Path) -> Option<String> {
    let log = data.with_extension("log");
    let mut serve = Command::new(&*VELOID);
    let serve = serve.args([
        "serve",
        "--workers",
        "1",
        "--listen",
        "127.0.0.1:0",
        "--data",
    ]);
    let serve = serve.arg(data).env_remove("DATABASE_URL");
    let serve = serve
        .stdout(Stdio::piped())
        .stderr(File::create(&log).unwrap());
    let mut child = serve.spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let listens = lines.next().is_some();
    if listens {
        child.kill().unwrap();
    }
    let status = child.wait().unwrap();
    assert!(listens || status.code() == Some(1), "{status}");
    (!listens).then(|| std::fs::read_to_string(log).unwrap())
}

/// A server that starts on a full disk listens, or names the disk and its free bytes.
#[test]
fn a_server_that_begins_on_a_full_disk_says_so() {
    let folder = Folder::new();
    let data = folder.0.join("data");
    let Some(disk) = Mount::small(data.clone()) else {
        return;
    };
    let mut refused = 0;
    for used in [false, true] {
        for kib in [0, 4, 16, 36, 64, 128, 400] {
            if used {
                let migrated = veloid(&["migrate", "--data", data.to_str().unwrap()]);
                assert!(migrated.status.success(), "{migrated:?}");
            }
            let ballast = disk.fill();
            let file = File::options().write(true).open(&ballast).unwrap();
            let bytes = file.metadata().unwrap().len();
            file.set_len(bytes - (kib << 10)).unwrap();
            if let Some(said) = ended(&data) {
                let last = said.lines().last().unwrap();
                let begin = format!("veloid: {}: the disk is full, ", data.display());
                assert!(last.starts_with(&begin), "{kib} KiB left: {said}");
                assert!(last.contains(" bytes are free"), "{kib} KiB left: {said}");
                refused += 1;
            }
            for entry in data.read_dir().unwrap() {
                let path = entry.unwrap().path();
                let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
            }
        }
    }
    eprintln!("{refused} of 14 starts were refused");
    assert!(refused >= 8, "{refused} of 14 starts were refused");
}

/// A server that computes in its own process, and panics or hangs there where it is told to.
fn faulty(variable: &str, point: &str, args: &[&str]) -> Option<Server> {
    if !has_points() {
        return None;
    }
    let args = [args, &["--isolate", "off"]].concat();
    Some(Server::with_env(&args, &[(variable, point)]))
}

/// The job has failed at its first attempt, and the next one succeeds on the same thread.
async fn fails_alone(server: &Server, kind: &str, why: &str) {
    let job = server.submit(&[]).await;
    let view = server.finished(&job).await;
    assert_eq!(view["state"], "failed", "{view:#}");
    assert_eq!(view["failure"]["kind"], kind, "{view:#}");
    assert!(
        view["failure"]["detail"].as_str().unwrap().contains(why),
        "{view:#}"
    );
    let again = "SELECT COUNT(*) FROM river_job WHERE attempt > 1";
    assert_eq!(server.count(again).await, 0, "nothing was tried again");
    lives(server).await;
    let next = server.submit(&[("seed", "2")]).await;
    server.succeeded(&next).await;
    nothing_ran_twice(server).await;
}

#[tokio::test]
async fn a_panic_in_the_engine_fails_its_job_alone() {
    for stage in ["computing:1", "computing:4"] {
        let Some(server) = faulty("VELOID_PANIC_AT", stage, &["--workers", "1"]) else {
            return;
        };
        fails_alone(&server, "crash", "asked to panic").await;
    }
}

#[tokio::test]
async fn a_stage_that_hangs_fails_its_job_alone() {
    // Observe, and a swarm.
    for stage in ["computing:1", "in_trial:9"] {
        let args = ["--workers", "1", "--stage-timeout", "5"];
        let Some(server) = faulty("VELOID_HANG_AT", stage, &args) else {
            return;
        };
        fails_alone(&server, "deadline", "longer than 5 s").await;
    }
}

#[tokio::test]
async fn a_server_that_hangs_in_a_stage_stops_when_asked() {
    let Some(mut server) = faulty("VELOID_HANG_AT", "computing", &["--workers", "1"]) else {
        return;
    };
    let job = server.submit(&[]).await;
    while server.json(&job).await["state"] == "queued" {}
    let asked = Instant::now();
    assert_eq!(server.terminate(), Some(0));
    eprintln!(
        "stopped {:.1} s after SIGTERM",
        asked.elapsed().as_secs_f64()
    );
    server.restart_with_env(&[]);
    server.succeeded(&job).await;
    nothing_ran_twice(&server).await;
}

/// Rides that can be read and hold nothing that a bicycle does: whatever the fit makes of them, the job
/// ends at its first attempt, or the upload is refused with the reason.
#[tokio::test]
async fn a_ride_that_no_model_fits_ends_its_job_once() {
    let server = Server::with(&["--workers", "1"]);
    for (what, motion) in [
        ("a growing oscillation", Motion::Growing),
        ("numbers at the end of their range", Motion::Huge),
        ("a displacement that never moves", Motion::Still),
        ("noise that the road knows nothing of", Motion::Foreign),
    ] {
        let parts = [&ride::QUICK[..], &[("diagnosis", "true")]].concat();
        let response = server.upload(motion.ride(), ride::BIKE, &parts).await;
        let status = response.status();
        let body: Value = response.json().await.unwrap();
        if status == 422 {
            eprintln!("{what}: refused: {}", body["detail"]);
            continue;
        }
        assert_eq!(status, 202, "{what}: {body:#}");
        let view = server
            .finished(body["links"]["job"].as_str().unwrap())
            .await;
        eprintln!(
            "{what}: {} {} {}",
            view["state"], view["verdict"], view["failure"]
        );
        if view["state"] == "failed" {
            let kind = view["failure"]["kind"].as_str().unwrap();
            assert!(["input", "engine"].contains(&kind), "{what}: {view:#}");
        }
    }
    let again = "SELECT COUNT(*) FROM river_job WHERE attempt > 1";
    assert_eq!(server.count(again).await, 0, "nothing was tried again");
    lives(&server).await;
    let next = server.submit(&[]).await;
    server.succeeded(&next).await;
}

enum Motion {
    Growing,
    Huge,
    Still,
    Foreign,
}

impl Motion {
    /// Ten seconds at 100 Hz over a rough road.
    fn ride(&self) -> Vec<u8> {
        let mut csv = "t,u_f,u_r,z_f,z_r\n".to_owned();
        // Weyl's sequence: evenly spread, and without a period.
        let noise = |n: usize, step: f64| (n as f64 * step).fract() - 0.5;
        for n in 0..1000 {
            let (t, u) = (
                n as f64 / 100.0,
                0.01 * noise(n * n, 0.618_033_988_749_894_9),
            );
            let z = match self {
                Motion::Growing => 1e-6 * (2.0 * t).exp() * (20.0 * t).sin(),
                Motion::Huge => 1e300 * noise(n * n, 0.414_213_562_373_095_1),
                Motion::Still => 0.0,
                Motion::Foreign => 0.01 * noise(n * n, 0.414_213_562_373_095_1),
            };
            writeln!(csv, "{t:.3},{u:e},{u:e},{z:e},{z:e}").unwrap();
        }
        csv.into_bytes()
    }
}
