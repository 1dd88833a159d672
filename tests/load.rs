//! Many at once, and for long: prints the tables of docs/load.md. On an idle machine, not in CI:
//! `cargo test --workspace --test blackbox load:: -- --ignored --nocapture --test-threads 1`
//! `VELOID_UPLOADS` and `VELOID_SOAK` (s) make them shorter, `VELOID_READ_MS` lets a busy machine read slower,
//! `VELOID_TEST_BINARY` names another build of the program.

use std::env;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use futures_util::StreamExt;
use futures_util::future::join_all;
use reqwest::header::{ETAG, IF_NONE_MATCH, RETRY_AFTER};
use tokio::task::JoinHandle;

use crate::harness::{Server, form};
use crate::measured::{self, row};
use crate::oracle::nothing_ran_twice;
use crate::ride;

const UPLOADS: usize = 1000;
/// Rides that the server takes before it puts others off.
const QUEUE: usize = 300;
/// What is demanded of 99 % of the reads: a page that follows a job does not feel slow.
const READ_MS: usize = 50;
/// Most that the server may hold; a quarter of the limit in docker/kubernetes.yaml.
const MEMORY_KB: u64 = 512 << 10;
/// Two trials of twenty seconds at 200 Hz fill a row of River, so that a ride has five.
const ROWS: i64 = 5;
const LARGE_SWARM: [(&str, &str); 2] = [("particles", "100"), ("iterations", "100")];
const CLIENTS: usize = 32;
const POLLERS: usize = 200;
const STREAMS: usize = 100;
/// Time between two looks of a dashboard.
const LOOK: Duration = Duration::from_secs(1);

fn from_env(name: &str, otherwise: usize) -> usize {
    env::var(name).map_or(otherwise, |text| text.parse().expect("a number"))
}

/// What all who use a server at once share.
struct Crowd {
    server: Server,
    ride: Vec<u8>,
    /// More options of every ride.
    swarm: &'static [(&'static str, &'static str)],
    /// The key of somebody else, who sends one ride at a time.
    other: String,
    jobs: Mutex<Vec<String>>,
    sent: AtomicUsize,
    put_off: AtomicUsize,
    events: AtomicUsize,
    reads_ms: Mutex<Vec<f64>>,
    over: AtomicBool,
}

impl Crowd {
    fn before(args: &[&str], swarm: &'static [(&'static str, &'static str)]) -> Arc<Self> {
        let many = "1000000";
        let key = |group| {
            [
                "--group",
                group,
                "--requests-per-minute",
                many,
                "--unfinished-jobs",
                many,
            ]
        };
        let (mut server, [one, other]) = Server::with_keys([&key("many"), &key("one")], args);
        server.as_seen_by(&one);
        Arc::new(Self {
            server,
            ride: ride::example(),
            swarm,
            other,
            jobs: Mutex::default(),
            sent: AtomicUsize::new(0),
            put_off: AtomicUsize::new(0),
            events: AtomicUsize::new(0),
            reads_ms: Mutex::default(),
            over: AtomicBool::new(false),
        })
    }

    /// Sends one ride, as often as the server puts it off.
    async fn send(&self, index: usize) -> String {
        let seed = index.to_string();
        let diagnosis = index.is_multiple_of(10).to_string();
        let parts = [
            ("seed", seed.as_str()),
            ("diagnosis", &diagnosis),
            ("again", "true"),
        ];
        let parts = [&parts[..], self.swarm].concat();
        loop {
            let response = self
                .server
                .upload(self.ride.clone(), ride::BIKE, &parts)
                .await;
            if response.status() == 202 {
                let location = response.headers()["location"].to_str().unwrap();
                return location.to_owned();
            }
            assert!(
                [429, 503].contains(&response.status().as_u16()),
                "{response:?}"
            );
            let wait = response.headers()[RETRY_AFTER].to_str().unwrap();
            self.put_off.fetch_add(1, Relaxed);
            tokio::time::sleep(Duration::from_secs(wait.parse().unwrap())).await;
        }
    }

    /// One of 32 that send until all is sent.
    async fn uploader(self: Arc<Self>, count: usize) {
        while let index = self.sent.fetch_add(1, Relaxed)
            && index < count
        {
            let job = self.send(index).await;
            self.jobs.lock().unwrap().push(job);
        }
    }

    /// Some job of those that were acknowledged.
    fn some_job(&self, pick: usize) -> Option<String> {
        let jobs = self.jobs.lock().unwrap();
        (!jobs.is_empty()).then(|| jobs[pick % jobs.len()].clone())
    }

    /// Looks at one job after the other, each until it is at its end.
    async fn poller(self: Arc<Self>, who: usize) {
        tokio::time::sleep(LOOK.mul_f64(who as f64 / POLLERS as f64)).await;
        let mut seen = None;
        for turn in 0.. {
            if self.over.load(Relaxed) {
                break;
            }
            if let Some(job) = self.some_job(who + turn / 20 * POLLERS) {
                let mut request = self.server.client.get(self.server.address(&job));
                if let Some(etag) = seen.take() {
                    request = request.header(IF_NONE_MATCH, etag);
                }
                let begin = Instant::now();
                let response = request.send().await.unwrap();
                assert!(
                    [200, 304].contains(&response.status().as_u16()),
                    "{response:?}"
                );
                seen = response.headers().get(ETAG).cloned();
                response.bytes().await.unwrap();
                self.reads_ms
                    .lock()
                    .unwrap()
                    .push(1e3 * begin.elapsed().as_secs_f64());
            }
            tokio::time::sleep(LOOK).await;
        }
    }

    /// Follows one job after the other by its events.
    async fn follower(self: Arc<Self>, who: usize) {
        for turn in 0.. {
            if self.over.load(Relaxed) {
                break;
            }
            if let Some(job) = self.some_job(who + turn * STREAMS) {
                let response = self.server.get(&format!("{job}/events")).await;
                assert_eq!(response.status(), 200);
                let mut events = response.bytes_stream();
                while let Some(event) = events.next().await
                    && !self.over.load(Relaxed)
                {
                    event.unwrap();
                    self.events.fetch_add(1, Relaxed);
                }
            }
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
    }

    fn begin(self: &Arc<Self>) -> Vec<JoinHandle<()>> {
        let pollers = (0..POLLERS).map(|who| tokio::spawn(self.clone().poller(who)));
        let followers = (0..STREAMS).map(|who| tokio::spawn(self.clone().follower(who)));
        pollers.chain(followers).collect()
    }

    /// Ends the looking, and says how long reads took; 99 % of them at most so long (ms).
    async fn end(&self, all: Vec<JoinHandle<()>>) -> f64 {
        self.over.store(true, Relaxed);
        for one in all {
            one.await.unwrap();
        }
        let mut reads = self.reads_ms.lock().unwrap();
        reads.sort_by(f64::total_cmp);
        let at = |share: f64| reads[((reads.len() - 1) as f64 * share) as usize];
        row(
            &format!("{} reads of a job: median, p99, most", reads.len()),
            format!("{:.1}, {:.1}, {:.1} ms", at(0.5), at(0.99), at(1.0)),
            &format!("p99 {READ_MS} ms"),
        );
        row("events sent", self.events.load(Relaxed).to_string(), "");
        at(0.99)
    }

    async fn unfinished(&self) -> i64 {
        let sql = "SELECT count(*) FROM job WHERE finished_at IS NULL";
        self.server.count(sql).await
    }

    /// Every job that was acknowledged has succeeded, once, with one report.
    async fn nothing_is_lost(&self, expected: i64) {
        let succeeded = "SELECT count(*) FROM job WHERE state = 'succeeded'";
        assert_eq!(self.server.count(succeeded).await, expected);
        let reports = "SELECT count(*) FROM result WHERE name = 'report'";
        assert_eq!(self.server.count(reports).await, expected);
        nothing_ran_twice(&self.server).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "measures"]
async fn a_thousand_uploads_at_once_beside_pollers_and_streams() {
    let uploads = from_env("VELOID_UPLOADS", UPLOADS);
    let crowd = Crowd::before(&["--queue", &QUEUE.to_string()], &[]);
    let begin = Instant::now();
    let lookers = crowd.begin();
    let uploaders = (0..CLIENTS).map(|_| tokio::spawn(crowd.clone().uploader(uploads)));
    let uploaders = tokio::spawn(join_all(uploaders.collect::<Vec<_>>()));
    let lone = tokio::spawn(somebody_else(crowd.clone()));
    measured::head();
    let mut sizes = Vec::new();
    while !uploaders.is_finished() || crowd.unfinished().await > 0 {
        sizes.push(Size::of(&crowd.server));
        tokio::time::sleep(LOOK).await;
    }
    uploaders.await.unwrap();
    let took = begin.elapsed().as_secs_f64();
    crowd.over.store(true, Relaxed);
    let mut waits = lone.await.unwrap();
    let read_ms = crowd.end(lookers).await;
    crowd.nothing_is_lost((uploads + waits.len()) as i64).await;
    waits.sort_by(f64::total_cmp);
    let behind_all = took * QUEUE.min(uploads) as f64 / uploads as f64;
    row(
        "rides, each with one report",
        format!("{uploads} in {took:.0} s"),
        "all",
    );
    row(
        "put off by 503, then taken",
        crowd.put_off.load(Relaxed).to_string(),
        "",
    );
    row(
        &format!("somebody else's {} single rides: median, most", waits.len()),
        format!(
            "{:.1}, {:.1} s",
            waits[waits.len() / 2],
            waits[waits.len() - 1]
        ),
        &format!(
            "{:.1} s, a third of the time in which a full queue is worked off",
            behind_all / 3.0
        ),
    );
    let (quarter, end) = (sizes[sizes.len() / 4], sizes[sizes.len() - 1]);
    Size::print("at a quarter", &quarter);
    Size::print("at the end", &end);
    let most = sizes.iter().max_by_key(|size| size.memory_kb).unwrap();
    Size::print("at its most", most);
    reads_are_fast(read_ms);
    let longest = waits[waits.len() - 1];
    assert!(
        longest <= behind_all / 3.0,
        "{longest:.1} s beside {behind_all:.1} s"
    );
    assert!(end.grew_little_from(&quarter), "memory grows");
    assert!(most.memory_kb <= MEMORY_KB, "{} kB", most.memory_kb);
}

fn reads_are_fast(most_ms: f64) {
    let demanded = from_env("VELOID_READ_MS", READ_MS);
    assert!(
        most_ms <= demanded as f64,
        "99 % of the reads take {most_ms:.1} ms"
    );
}

/// Sends a ride, waits for its end, and so on; how long each took (s).
async fn somebody_else(crowd: Arc<Crowd>) -> Vec<f64> {
    let mut took = Vec::new();
    while !crowd.over.load(Relaxed) {
        tokio::time::sleep(Duration::from_secs(3)).await;
        let client = &crowd.server.client;
        let begin = Instant::now();
        let seed = took.len().to_string();
        let parts = [
            ("seed", seed.as_str()),
            ("diagnosis", "false"),
            ("again", "true"),
        ];
        let response = client
            .post(crowd.server.address("/v1/rides"))
            .bearer_auth(&crowd.other)
            .multipart(form(crowd.ride.clone(), ride::BIKE, &parts))
            .send()
            .await
            .unwrap();
        if response.status() != 202 {
            continue;
        }
        let job = crowd
            .server
            .address(response.headers()["location"].to_str().unwrap());
        loop {
            let waited = client
                .get(format!("{job}?wait=30"))
                .bearer_auth(&crowd.other);
            let view: serde_json::Value = waited.send().await.unwrap().json().await.unwrap();
            if view["state"] == "succeeded" {
                break;
            }
        }
        took.push(begin.elapsed().as_secs_f64());
    }
    took
}

/// What a server's process holds.
#[derive(Clone, Copy)]
struct Size {
    memory_kb: u64,
    files: usize,
    log_kb: u64,
}

impl Size {
    fn of(server: &Server) -> Self {
        let process = format!("/proc/{}", server.id());
        let status = std::fs::read_to_string(format!("{process}/status")).unwrap();
        let memory = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let log = server.folder.0.join("veloid.db-wal").metadata();
        Self {
            memory_kb: memory
                .unwrap()
                .trim()
                .trim_end_matches(" kB")
                .parse()
                .unwrap(),
            files: std::fs::read_dir(format!("{process}/fd")).unwrap().count(),
            log_kb: log.map_or(0, |log| log.len() / 1024),
        }
    }

    /// In memory, by at most a fifth.
    fn grew_little_from(&self, before: &Self) -> bool {
        self.memory_kb as f64 <= 1.2 * before.memory_kb as f64
    }

    fn print(when: &str, size: &Self) {
        row(
            &format!("{when}: resident memory, file descriptors, write-ahead log"),
            format!(
                "{} MB, {}, {} kB",
                size.memory_kb / 1024,
                size.files,
                size.log_kb
            ),
            "",
        );
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "takes an hour"]
async fn an_hour_of_rides_leaves_memory_files_and_log_flat() {
    let seconds = from_env("VELOID_SOAK", 3600) as u64;
    let crowd = Crowd::before(&["--queue", "20"], &LARGE_SWARM);
    let begin = Instant::now();
    let lookers = crowd.begin();
    let uploaders: Vec<_> = (0..4)
        .map(|_| tokio::spawn(crowd.clone().uploader(usize::MAX)))
        .collect();
    measured::head();
    let mut quarters = Vec::new();
    for quarter in 1..=4 {
        let mut sizes = Vec::new();
        while begin.elapsed().as_secs() < seconds * quarter / 4 {
            tokio::time::sleep(LOOK).await;
            sizes.push(Size::of(&crowd.server));
        }
        sizes.sort_by_key(|size| size.memory_kb);
        let median = sizes[sizes.len() / 2];
        Size::print(
            &format!("quarter {quarter}, median of {}", sizes.len()),
            &median,
        );
        quarters.push(median);
    }
    uploaders.iter().for_each(JoinHandle::abort);
    join_all(uploaders).await;
    while crowd.unfinished().await > 0 {
        tokio::time::sleep(LOOK).await;
    }
    let read_ms = crowd.end(lookers).await;
    let rides = crowd.server.count("SELECT count(*) FROM job").await;
    crowd.nothing_is_lost(rides).await;
    let took = begin.elapsed().as_secs();
    row(
        "rides, each with one report",
        format!("{rides} in {took} s"),
        "all",
    );
    let rows = "SELECT COUNT(DISTINCT river_id) FROM trial";
    assert_eq!(crowd.server.count(rows).await, ROWS * rides);
    let (early, late) = (quarters[1], quarters[3]);
    reads_are_fast(read_ms);
    assert!(late.grew_little_from(&early), "memory grows");
    assert!(late.files <= early.files + 10, "file descriptors stay open");
    assert!(
        late.log_kb as f64 <= 1.5 * early.log_kb as f64 + 1024.0,
        "the log grows"
    );
}
