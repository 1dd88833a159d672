//! Hosts that fail: server, workers and a PostgreSQL of their own, each in a network namespace, joined
//! by a bridge in one more. A host is cut off by taking its port of the bridge down: what it sends is
//! lost without a word, as when a cable is pulled.

use std::cell::RefCell;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::built::has;
use crate::harness::{Folder, VELOID, identify};
use crate::ride;
use crate::skips::{not_applicable, skip};

/// Longer than a worker's lease.
const OUTAGE: Duration = Duration::from_secs(12);

/// For whatever must come to pass, on however slow a machine.
const DEADLINE: Duration = Duration::from_secs(600);

const DATABASE: &str = "postgres://postgres@10.77.0.1:5432/postgres";

/// Swarms of some seconds each.
const TRIALS: u32 = 6;
const SETTINGS: [(&str, &str); 6] = [
    ("trials", "6"),
    ("particles", "60"),
    ("iterations", "1000"),
    ("diagnosis", "false"),
    ("seed", "7"),
    ("again", "true"),
];

/// The network, and everything that runs in it.
struct Lab {
    prefix: String,
    hosts: Vec<String>,
    folder: Folder,
    postgres: RefCell<Option<Child>>,
}

/// A `veloid` on a host of its own.
struct Host<'a> {
    lab: &'a Lab,
    name: String,
    child: Child,
}

impl Lab {
    /// None, and a word about it, where namespaces or PostgreSQL cannot be had.
    fn new() -> Option<Self> {
        if !has("postgres") {
            return None;
        }
        if !as_root() || run("ip", &["netns", "list"]).is_none() {
            not_applicable("network namespaces need root and its rights");
        } else if server_programs().is_none() {
            skip("no PostgreSQL to start");
        } else {
            let lab = Self {
                prefix: format!("veloid{}", std::process::id()),
                hosts: Vec::new(),
                folder: Folder::new(),
                postgres: RefCell::default(),
            };
            return Some(lab.joined());
        }
        None
    }

    /// With the bridge, and PostgreSQL on it.
    fn joined(mut self) -> Self {
        let switch = self.namespace("switch");
        must(
            "ip",
            &["-n", &switch, "link", "add", "bridge", "type", "bridge"],
        );
        must("ip", &["-n", &switch, "link", "set", "bridge", "up"]);
        self.host("pg", 1);
        let data = self.folder.0.join("pg");
        std::fs::create_dir(&data).unwrap();
        must("chown", &["postgres:postgres", data.to_str().unwrap()]);
        let initdb = server_programs().unwrap().join("initdb");
        let made = as_postgres(&mut Command::new("setpriv"))
            .arg(initdb)
            .args(["--no-sync", "--auth", "trust", "--pgdata"])
            .arg(&data)
            .output()
            .unwrap();
        assert!(made.status.success(), "{made:?}");
        let access = "host all all 10.77.0.0/24 trust\n";
        std::fs::write(data.join("pg_hba.conf"), access).unwrap();
        self.start_postgres();
        self
    }

    fn namespace(&mut self, host: &str) -> String {
        let name = format!("{}-{host}", self.prefix);
        must("ip", &["netns", "add", &name]);
        self.hosts.push(name.clone());
        must("ip", &["-n", &name, "link", "set", "lo", "up"]);
        name
    }

    /// A host with an address of 10.77.0.0/24 on the bridge.
    fn host(&mut self, host: &str, address: u8) {
        let (name, switch) = (self.namespace(host), format!("{}-switch", self.prefix));
        let address = format!("10.77.0.{address}/24");
        must(
            "ip",
            &[
                "-n", &name, "link", "add", "eth0", "type", "veth", "peer", "name", host, "netns",
                &switch,
            ],
        );
        must(
            "ip",
            &["-n", &name, "address", "add", &address, "dev", "eth0"],
        );
        must("ip", &["-n", &name, "link", "set", "eth0", "up"]);
        must(
            "ip",
            &["-n", &switch, "link", "set", host, "master", "bridge"],
        );
        must("ip", &["-n", &switch, "link", "set", host, "up"]);
    }

    /// Takes the host's port of the bridge down, or up again.
    fn port(&self, host: &str, state: &str) {
        let switch = format!("{}-switch", self.prefix);
        must("ip", &["-n", &switch, "link", "set", host, state]);
    }

    /// A command on a host. `ip netns exec` becomes it, so that the child is the command itself.
    fn on(&self, host: &str, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &format!("{}-{host}", self.prefix)]);
        command.arg(program);
        command
    }

    fn start_postgres(&self) {
        let data = self.folder.0.join("pg");
        let program = server_programs().unwrap().join("postgres");
        let mut command = self.on("pg", "setpriv");
        as_postgres(&mut command).arg(program).arg("-D").arg(&data);
        command.args(["-c", "listen_addresses=*", "-c", "unix_socket_directories="]);
        let log = log(&self.folder, "pg.log");
        let child = command.stdout(Stdio::null()).stderr(log).spawn().unwrap();
        self.postgres.replace(Some(child));
        until("PostgreSQL answers", || self.sql("SELECT 1").is_some());
    }

    /// Kills PostgreSQL as a power cut would.
    fn kill_postgres(&self) {
        let mut postgres = self.postgres.take().unwrap();
        postgres.kill().unwrap();
        postgres.wait().unwrap();
        until("PostgreSQL is gone", || self.sql("SELECT 1").is_none());
    }

    fn sql(&self, sql: &str) -> Option<String> {
        let mut psql = self.on("pg", "psql");
        let output = psql.args([DATABASE, "-qAtc", sql]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        output.status.success().then(|| text.trim().to_owned())
    }

    fn count(&self, sql: &str) -> u32 {
        self.sql(sql).unwrap().parse().unwrap()
    }

    /// `veloid` on a host, listening on port 8080, with a data folder that all share.
    fn veloid(&self, host: &str, args: &[&str]) -> Host<'_> {
        let mut command = self.on(host, &*VELOID);
        command
            .args(args)
            .args(["--listen", "0.0.0.0:8080", "--data"]);
        command.arg(self.folder.0.join(format!("data-{host}")));
        command
            .arg("--files")
            .arg(format!("file://{}", self.folder.0.join("files").display()));
        command
            .env("DATABASE_URL", DATABASE)
            .env("VELOID_OPEN", "true");
        let log = log(&self.folder, &format!("{host}.log"));
        let child = command.stdout(Stdio::null()).stderr(log).spawn().unwrap();
        let host = Host {
            lab: self,
            name: host.to_owned(),
            child,
        };
        until("veloid answers", || host.get("/readyz").is_some());
        host
    }

    fn worker(&self, host: &str) -> Host<'_> {
        self.veloid(host, &["worker", "--workers", "1"])
    }

    /// Sends the example ride; the address of its job.
    fn submit(&self, server: &Host) -> String {
        let ride = self.folder.write("ride.csv", ride::example());
        let mut curl = self.on(&server.name, "curl");
        curl.args([
            "-s",
            "-F",
            &format!("file=@{}", ride.display()),
            "-F",
            &format!("bike={}", ride::BIKE),
        ]);
        for (key, value) in SETTINGS {
            curl.args(["-F", &format!("{key}={value}")]);
        }
        let output = curl.arg("http://127.0.0.1:8080/v1/rides").output().unwrap();
        let view: Value = serde_json::from_slice(&output.stdout).expect("a job");
        view["links"]["job"].as_str().expect("accepted").to_owned()
    }

    /// Waits for a job to succeed, and holds its report against the command line's.
    fn succeeded(&self, server: &Host, job: &str, expected: &Value) {
        until("the job ends", || {
            let view = server.json(job);
            assert!(
                !["failed", "cancelled"].contains(&view["state"].as_str().unwrap()),
                "{view:#}"
            );
            view["state"] == "succeeded"
        });
        assert_eq!(server.json(job)["trials"]["done"], TRIALS);
        assert_eq!(
            server.json(&format!("{job}/report")).to_string(),
            expected.to_string()
        );
    }

    /// None is needed, but a machine that gives a worker no time for 8 s may bring one.
    fn say_takeovers(&self, when: &str) {
        let latest = "SELECT takeovers FROM job ORDER BY id DESC LIMIT 1";
        eprintln!("{} takeovers while {when}", self.count(latest));
    }

    /// What the command line makes of the ride, in peace.
    fn in_peace(&self) -> Value {
        let ride = self.folder.write("ride.csv", ride::example());
        let bike = self.folder.write("bike.json", ride::BIKE);
        let swarm = ["--trials", "6", "--particles", "60", "--iterations", "1000"];
        let args = [&["--no-diagnosis", "--seed", "7"], &swarm[..]].concat();
        identify(&ride, &bike, &args).0
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        if let Some(mut postgres) = self.postgres.take() {
            let _ = postgres.kill();
            let _ = postgres.wait();
        }
        for host in &self.hosts {
            run("ip", &["netns", "delete", host]);
        }
        if std::thread::panicking() {
            for entry in self.folder.0.read_dir().unwrap().flatten() {
                if entry.path().extension().is_some_and(|e| e == "log") {
                    eprintln!("--- {} ---", entry.path().display());
                    eprintln!(
                        "{}",
                        std::fs::read_to_string(entry.path()).unwrap_or_default()
                    );
                }
            }
        }
    }
}

impl Host<'_> {
    fn get(&self, path: &str) -> Option<String> {
        let mut curl = self.lab.on(&self.name, "curl");
        curl.args([
            "-sf",
            "--max-time",
            "20",
            &format!("http://127.0.0.1:8080{path}"),
        ]);
        let output = curl.output().unwrap();
        output
            .status
            .success()
            .then(|| String::from_utf8(output.stdout).unwrap())
    }

    fn json(&self, path: &str) -> Value {
        serde_json::from_str(&self.get(path).unwrap()).unwrap()
    }

    /// The figure of a metric; 0 where it has none yet.
    fn metric(&self, name: &str) -> f64 {
        let metrics = self.get("/metrics").unwrap_or_default();
        let mut lines = metrics.lines();
        lines
            .find_map(|line| line.strip_prefix(name)?.trim().parse().ok())
            .unwrap_or(0.0)
    }

    /// Asks it to stop and waits for it.
    fn stop(mut self) {
        must("kill", &["-TERM", &self.child.id().to_string()]);
        assert!(
            self.child.wait().unwrap().success(),
            "{} stops in order",
            self.name
        );
    }
}

impl Drop for Host<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Rows of trials that run, and the number of workers that run them.
const RUNNING: &str = "SELECT count(DISTINCT attempted_by[array_upper(attempted_by, 1)]) \
                       FROM river_job WHERE kind = 'trial' AND state = 'running'";

#[test]
#[ignore = "takes a minute; `.ci/long` runs it"]
fn hosts_that_are_cut_off_killed_or_replaced_lose_nothing_and_do_nothing_twice() {
    let Some(mut lab) = Lab::new() else { return };
    for (host, address) in [("server", 2), ("w1", 3), ("w2", 4), ("w3", 5)] {
        lab.host(host, address);
    }
    let expected = lab.in_peace();
    cut_off(&lab, &expected);
    rolled(&lab, &expected);
    without_database(&lab, &expected);
}

/// A worker is cut off in the middle of a trial; others take over, and its late result is refused.
fn cut_off(lab: &Lab, expected: &Value) {
    let server = lab.veloid("server", &["serve", "--workers", "0"]);
    let (lost, _other) = (lab.worker("w1"), lab.worker("w2"));
    let job = lab.submit(&server);
    until("both work", || lab.count(RUNNING) == 2);
    lab.port("w1", "down");
    let cut = Instant::now();
    until("its trial is taken over", || {
        lab.count("SELECT sum(takeovers) FROM job") >= 1
    });
    eprintln!(
        "taken over {:.1} s after the cut",
        cut.elapsed().as_secs_f64()
    );
    lab.succeeded(&server, &job, expected);
    assert_eq!(lost.metric("veloid_stale_completions_total"), 0.0);

    lab.port("w1", "up");
    until("its late result is refused", || {
        lost.metric("veloid_stale_completions_total") >= 1.0
    });
    until("it is back", || {
        lab.count("SELECT count(*) FROM worker") == 2
    });
    lab.succeeded(&server, &job, expected);
    assert_eq!(
        lab.count("SELECT count(*) FROM trial WHERE result IS NOT NULL"),
        TRIALS
    );
}

/// Workers are replaced one by one while a job runs: nothing is taken over or fails.
fn rolled(lab: &Lab, expected: &Value) {
    let server = lab.veloid("server", &["serve", "--workers", "0"]);
    let old = [lab.worker("w1"), lab.worker("w2")];
    let job = lab.submit(&server);
    until("both work", || lab.count(RUNNING) == 2);
    let mut new = Vec::new();
    for (old, host) in old.into_iter().zip(["w3", "w1"]) {
        new.push(lab.worker(host));
        old.stop();
    }
    lab.succeeded(&server, &job, expected);
    lab.say_takeovers("workers were replaced");
}

/// PostgreSQL is killed while a job runs, and comes back: work goes on where it was.
fn without_database(lab: &Lab, expected: &Value) {
    let server = lab.veloid("server", &["serve", "--workers", "0"]);
    let _workers = [lab.worker("w1"), lab.worker("w2")];
    let job = lab.submit(&server);
    until("both work", || lab.count(RUNNING) == 2);
    lab.kill_postgres();
    until("the server says so", || server.get("/readyz").is_none());
    assert!(server.get("/healthz").is_some());
    std::thread::sleep(OUTAGE);
    lab.start_postgres();
    until("the server is ready again", || {
        server.get("/readyz").is_some()
    });
    lab.succeeded(&server, &job, expected);
    lab.say_takeovers("the database was away");
}

/// The folder of PostgreSQL's own programs, which is seldom on the PATH.
fn server_programs() -> Option<PathBuf> {
    let debian = Path::new("/usr/lib/postgresql").read_dir().ok()?;
    let mut folders: Vec<PathBuf> = debian
        .flatten()
        .map(|entry| entry.path().join("bin"))
        .collect();
    folders.retain(|folder| folder.join("initdb").exists());
    folders.sort();
    folders.pop()
}

fn as_root() -> bool {
    let id = Command::new("id").arg("-u").output();
    id.is_ok_and(|output| output.stdout == b"0\n")
}

/// PostgreSQL refuses to run as root.
fn as_postgres(command: &mut Command) -> &mut Command {
    command.args([
        "--reuid",
        "postgres",
        "--regid",
        "postgres",
        "--clear-groups",
    ])
}

fn log(folder: &Folder, name: &str) -> File {
    let mut options = File::options();
    options
        .create(true)
        .append(true)
        .open(folder.0.join(name))
        .unwrap()
}

fn run(program: &str, args: &[&str]) -> Option<Output> {
    let output = Command::new(program).args(args).output().ok()?;
    output.status.success().then_some(output)
}

fn must(program: &str, args: &[&str]) {
    assert!(run(program, args).is_some(), "{program} {args:?}");
}

fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(begin.elapsed() < DEADLINE, "in vain: {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}
