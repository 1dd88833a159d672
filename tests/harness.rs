//! Starts `veloid serve` on a free port with a data folder of its own, and talks to it.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use jiff::Timestamp;
use reqwest::header::AUTHORIZATION;
use reqwest::multipart::{Form, Part};
use reqwest::{Client, ClientBuilder, Response};
use serde_json::Value;
#[cfg(feature = "postgres")]
use sqlx::PgConnection;
use sqlx::{Connection, SqliteConnection};

use crate::built::postgres;
pub use crate::built::{VELOID, has_points, veloid};
use crate::ride;

/// A folder that goes when the test ends.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("veloid-test-{}-{count}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Writes a file and gives its path.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A database of its own on the PostgreSQL of the tests; without one the server keeps to SQLite.
fn fresh_database(folder: &Folder) -> Option<String> {
    let server = postgres()?;
    let name = folder.0.file_name()?.to_str()?.replace('-', "_");
    let created = Command::new("psql")
        .args([&format!("{server}/postgres"), "-qc"])
        .arg(format!("CREATE DATABASE {name}"))
        .status();
    assert!(created.unwrap().success(), "no database on {server}");
    Some(format!("{server}/{name}"))
}

/// A running server.
pub struct Server {
    child: Child,
    database: Option<String>,
    pub url: String,
    pub client: Client,
    pub folder: Folder,
    args: Vec<String>,
    env: Vec<(String, String)>,
    /// The program.
    build: String,
}

impl Server {
    pub fn start() -> Self {
        Self::with(&[])
    }

    /// Starts with more arguments of `veloid serve`.
    pub fn with(args: &[&str]) -> Self {
        Self::with_env(args, &[])
    }

    /// Starts with more arguments, and environment variables that processes beside it get too.
    pub fn with_env(args: &[&str], env: &[(&str, &str)]) -> Self {
        Self::on(true, args, env)
    }

    /// Starts on SQLite, whatever the tests run on.
    pub fn on_sqlite(args: &[&str]) -> Self {
        Self::on(false, args, &[])
    }

    pub fn on_sqlite_with_env(args: &[&str], env: &[(&str, &str)]) -> Self {
        Self::on(false, args, env)
    }

    /// Makes a key for each set of arguments of `veloid key create`, and starts a server that asks
    /// for one.
    pub fn with_keys<const N: usize>(keys: [&[&str]; N], args: &[&str]) -> (Self, [String; N]) {
        // The keys have to be there before the server starts.
        let mut server = Self::with(&[]);
        server.kill();
        let keys = keys.map(|asked| {
            let mut command = server.beside(&["key", "create"]);
            key_of(&command.args(asked).output().unwrap())
        });
        server.args = [&["--keys"], args]
            .concat()
            .iter()
            .map(ToString::to_string)
            .collect();
        server.restart();
        (server, keys)
    }

    fn on(postgres: bool, args: &[&str], env: &[(&str, &str)]) -> Self {
        let folder = Folder::new();
        let mut env: Vec<(String, String)> = env
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
            .collect();
        let database = postgres.then(|| fresh_database(&folder)).flatten();
        env.extend(database.clone().map(|url| ("DATABASE_URL".to_owned(), url)));
        Self::of(&VELOID, folder, database, args, env)
    }

    /// Starts another build of the program.
    pub fn of_build(build: &str, args: &[&str]) -> Self {
        let folder = Folder::new();
        let database = fresh_database(&folder);
        let env = database.clone().map(|url| ("DATABASE_URL".to_owned(), url));
        Self::of(build, folder, database, args, env.into_iter().collect())
    }

    /// Asks the process to stop, and starts the program under test in its place.
    pub fn becomes_new(&mut self) {
        assert_eq!(self.terminate(), Some(0));
        self.build.clone_from(&VELOID);
        self.restart();
    }

    /// Starts on SQLite, on what lies in a folder.
    pub fn in_folder(folder: Folder, args: &[&str]) -> Self {
        Self::of(&VELOID, folder, None, args, Vec::new())
    }

    fn of(
        build: &str,
        folder: Folder,
        database: Option<String>,
        args: &[&str],
        env: Vec<(String, String)>,
    ) -> Self {
        let args: Vec<String> = args.iter().map(|arg| (*arg).to_owned()).collect();
        let (child, url) = launch(build, &folder.0, &env, &args);
        let client = http().timeout(Duration::from_secs(120)).build().unwrap();
        Self {
            child,
            database,
            url,
            client,
            folder,
            args,
            env,
            build: build.to_owned(),
        }
    }

    /// Ends the process as a power cut would.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Ends the process as a power cut would, and starts it anew on the same data.
    pub fn crash_and_restart(&mut self) {
        self.kill();
        self.restart();
    }

    /// Asks the process to stop.
    pub fn ask_to_stop(&self) {
        send("-TERM", &self.child);
    }

    /// Asks the process to stop and waits for it; its exit status.
    pub fn terminate(&mut self) -> Option<i32> {
        self.ask_to_stop();
        self.child.wait().unwrap().code()
    }

    /// Number of the process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether the process is there.
    pub fn is_there(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Waits until the process has died of itself, by no exit of its own.
    pub async fn dies(&mut self) {
        for _ in 0..6000 {
            if let Some(status) = self.child.try_wait().unwrap() {
                assert!(status.signal().is_some(), "it ended in order: {status}");
                return;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        panic!("it lives on");
    }

    /// Starts the process again with other environment variables than before.
    pub fn restart_with_env(&mut self, env: &[(&str, &str)]) {
        self.env.retain(|(key, _)| key == "DATABASE_URL");
        let env = env
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        self.env.extend(env);
        self.restart();
    }

    pub fn restart(&mut self) {
        (self.child, self.url) = launch(&self.build, &self.folder.0, &self.env, &self.args);
    }

    /// The server as seen by whoever has this key.
    pub fn as_seen_by(&mut self, key: &str) {
        let bearer = format!("Bearer {key}").parse().unwrap();
        let headers = [(AUTHORIZATION, bearer)].into_iter().collect();
        let client = http().default_headers(headers);
        self.client = client.build().unwrap();
    }

    /// A process beside the server on the same data.
    pub fn beside(&self, args: &[&str]) -> Command {
        let mut command = Command::new(&self.build);
        command
            .args(args)
            .arg("--data")
            .arg(&self.folder.0)
            .env_remove("DATABASE_URL")
            .envs(self.env.iter().cloned());
        command
    }

    /// The same, ended after a minute (exit status 124).
    pub fn beside_for_a_minute(&self, args: &[&str]) -> Command {
        let beside = self.beside(args);
        let mut limited = Command::new("timeout");
        limited
            .arg("60")
            .arg(beside.get_program())
            .args(beside.get_args());
        limited
            .env_remove("DATABASE_URL")
            .envs(self.env.iter().cloned());
        limited
    }

    /// Runs a statement on the server's database; its text is the same on both.
    pub async fn execute(&self, sql: &'static str) {
        #[cfg(feature = "postgres")]
        if let Some(url) = &self.database {
            let mut connection = PgConnection::connect(url).await.unwrap();
            sqlx::query(sql).execute(&mut connection).await.unwrap();
            return;
        }
        let mut connection = SqliteConnection::connect(&self.sqlite()).await.unwrap();
        sqlx::query(sql).execute(&mut connection).await.unwrap();
    }

    /// The number that a query of the server's database gives; its text is the same on both.
    pub async fn count(&self, sql: &'static str) -> i64 {
        #[cfg(feature = "postgres")]
        if let Some(url) = &self.database {
            let mut connection = PgConnection::connect(url).await.unwrap();
            return sqlx::query_scalar(sql)
                .fetch_one(&mut connection)
                .await
                .unwrap();
        }
        let mut connection = SqliteConnection::connect(&self.sqlite()).await.unwrap();
        sqlx::query_scalar(sql)
            .fetch_one(&mut connection)
            .await
            .unwrap()
    }

    /// Address of the server's database, where that is SQLite.
    pub fn sqlite(&self) -> String {
        let reported = self.env.iter().find(|(key, _)| key == "DATABASE_URL");
        match reported {
            Some((_, url)) => url.clone(),
            None => format!("sqlite:{}", self.folder.0.join("veloid.db").display()),
        }
    }

    /// Address of the server's database, where that is PostgreSQL.
    pub fn database(&self) -> Option<&str> {
        self.database.as_deref()
    }

    /// `veloid worker` beside the server, with one thread that stays on a core.
    pub fn pinned_worker(&self, core: &str) -> Worker {
        let mut worker = Command::new("taskset");
        let veloid = self.beside(&["worker", "--workers", "1"]);
        worker
            .args(["-c", core])
            .arg(&self.build)
            .args(veloid.get_args());
        worker.envs(self.env.iter().cloned());
        Worker(worker.stderr(Stdio::null()).spawn().unwrap())
    }

    /// `veloid worker` beside the server, with one thread and more arguments.
    pub fn worker(&self, args: &[&str]) -> Worker {
        self.worker_with_env(args, &[])
    }

    /// As `worker`, with more environment variables.
    pub fn worker_with_env(&self, args: &[&str], env: &[(&str, &str)]) -> Worker {
        let mut worker = self.beside(&["worker", "--workers", "1"]);
        let worker = worker.args(args).envs(env.iter().copied());
        Worker(worker.stderr(Stdio::null()).spawn().unwrap())
    }

    /// `veloid worker` beside the server, with so many threads.
    pub fn worker_with(&self, threads: usize) -> Worker {
        let mut worker = self.beside(&["worker", "--workers", &threads.to_string()]);
        Worker(worker.stderr(Stdio::null()).spawn().unwrap())
    }

    pub async fn get(&self, path: &str) -> Response {
        self.client.get(self.address(path)).send().await.unwrap()
    }

    pub async fn json(&self, path: &str) -> Value {
        let response = self.get(path).await;
        assert_eq!(response.status(), 200, "{path}");
        response.json().await.unwrap()
    }

    /// Asks for the end of a job; an error where the process dies before it answers.
    pub async fn cancel(&self, job: &str) -> reqwest::Result<Response> {
        self.client.delete(self.address(job)).send().await
    }

    pub fn address(&self, path: &str) -> String {
        format!("{}{path}", self.url)
    }

    /// Sends a form with a ride, a bike and other parts.
    pub async fn upload(&self, ride: Vec<u8>, bike: &str, parts: &[(&str, &str)]) -> Response {
        let request = self.client.post(self.address("/v1/rides"));
        let request = request.multipart(form(ride, bike, parts));
        request.send().await.unwrap()
    }

    /// Sends the example ride with quick settings; the address of its job.
    pub async fn submit(&self, parts: &[(&str, &str)]) -> String {
        let parts = [&ride::QUICK, parts].concat();
        let response = self.upload(ride::example(), ride::BIKE, &parts).await;
        let status = response.status();
        let location = response.headers().get("location").cloned();
        let body = response.text().await.unwrap();
        assert_eq!(status, 202, "{body}");
        location.unwrap().to_str().unwrap().to_owned()
    }

    /// Waits until the job is at its end.
    pub async fn finished(&self, job: &str) -> Value {
        for _ in 0..20 {
            let view = self.json(&format!("{job}?wait=30")).await;
            if !["queued", "running"].contains(&view["state"].as_str().unwrap()) {
                return view;
            }
        }
        panic!("{job} does not end: {:#}", self.json(job).await);
    }

    pub async fn succeeded(&self, job: &str) -> Value {
        let view = self.finished(job).await;
        assert_eq!(view["state"], "succeeded", "{view:#}");
        view
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        if let Some((server, name)) = self
            .database
            .as_deref()
            .and_then(|url| url.rsplit_once('/'))
        {
            let _ = Command::new("psql")
                .args([&format!("{server}/postgres"), "-qc"])
                .arg(format!("DROP DATABASE {name} WITH (FORCE)"))
                .status();
        }
        if std::thread::panicking()
            && let Ok(log) = std::fs::read_to_string(self.folder.0.join("log"))
        {
            eprintln!("--- log of the server ---\n{log}");
        }
    }
}

/// The raw files in a data folder, beside which lies the store's id.
pub fn raw_files(data: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(data.join("rides")).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    paths
        .filter(|path| path.file_name().unwrap() != "installation")
        .collect()
}

/// Nothing that was sent is kept, or on its way.
pub fn nothing_is_kept(server: &Server) {
    assert_eq!(raw_files(&server.folder.0), [] as [PathBuf; 0]);
    let incoming = std::fs::read_dir(server.folder.0.join("incoming")).unwrap();
    assert_eq!(incoming.count(), 0, "on its way");
}

/// A form with a ride, a bike and other parts, of which the last of a name counts, so that tests can
/// begin with [`ride::QUICK`]; channels are mapped one by one.
pub fn form(ride: Vec<u8>, bike: &str, parts: &[(&str, &str)]) -> Form {
    let last = parts.iter().enumerate().filter(|(i, (key, _))| {
        *key == "map" || parts[i + 1..].iter().all(|(later, _)| later != key)
    });
    let last: Vec<_> = last.map(|(_, part)| *part).collect();
    whole_form(ride, bike, &last)
}

/// A form with a ride, a bike and every one of these parts.
pub fn whole_form(ride: Vec<u8>, bike: &str, parts: &[(&str, &str)]) -> Form {
    let file = Part::bytes(ride).file_name("ride.csv");
    let form = Form::new().part("file", file).text("bike", bike.to_owned());
    parts.iter().fold(form, |form, (key, value)| {
        form.text((*key).to_owned(), (*value).to_owned())
    })
}

/// The key that `veloid key create` has printed.
pub fn key_of(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    let key = String::from_utf8(output.stdout.clone()).unwrap();
    key.trim().to_owned()
}

fn launch(build: &str, data: &Path, env: &[(String, String)], args: &[String]) -> (Child, String) {
    let log = File::options()
        .create(true)
        .append(true)
        .open(data.join("log"))
        .unwrap();
    let mut child = Command::new(build)
        .args(["serve", "--listen", "127.0.0.1:0", "--data"])
        .arg(data)
        .args(args)
        .env_remove("DATABASE_URL")
        .envs(env.iter().cloned())
        .stdout(Stdio::piped())
        .stderr(log)
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let url = lines
        .by_ref()
        .map_while(Result::ok)
        .find_map(|line| line.strip_prefix("veloid listens on ").map(str::to_owned))
        .expect("the server ended before it listened");
    // Whatever else it prints must not block it.
    std::thread::spawn(move || lines.for_each(drop));
    (child, url)
}

/// A worker that goes when the test ends.
pub struct Worker(Child);

impl Worker {
    /// Sends it a signal.
    pub fn send(&self, signal: &str) {
        send(signal, &self.0);
    }
}

fn send(signal: &str, child: &Child) {
    let id = child.id().to_string();
    let sent = Command::new("kill").args([signal, &id]).status();
    assert!(sent.unwrap().success());
}

impl Drop for Worker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A time of an answer. As texts they have no order: zeros at the end of a second's fraction are not written.
pub fn time(value: &Value) -> Option<Timestamp> {
    value.as_str()?.parse().ok()
}

/// A client to be set up; its TLS asks for a provider even where nothing is encrypted.
pub fn http() -> ClientBuilder {
    #[cfg(any(feature = "s3", feature = "webhooks"))]
    let _ = rustls::crypto::ring::default_provider().install_default();
    // Tests keep their only thread busy for long, and would not hear that a connection was closed.
    Client::builder().pool_idle_timeout(Duration::from_secs(5))
}

/// Runs `veloid identify` on the files of a ride and a bike; the report it writes, and what it says.
pub fn identify(ride: &Path, bike: &Path, args: &[&str]) -> (Value, String) {
    let folder = Folder::new();
    let json = folder.0.join("report.json");
    let mut command = Command::new(&*VELOID);
    command.arg("identify").arg(ride).arg("--bike").arg(bike);
    let output = command
        .arg("--json")
        .arg(&json)
        .args(args)
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let report = serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
    (report, String::from_utf8(output.stdout).unwrap())
}
