//! Raw files on an S3-compatible server that the server and its worker reach, in place of a folder.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use crate::built::has;
use crate::harness::{Folder, Server, VELOID, http};
use crate::ride;

/// moto's S3 server (`pip install 'moto[server]'`), on a free port.
struct S3 {
    child: Child,
    endpoint: String,
}

impl S3 {
    /// None, and a word about it, where there is none or the program does not know it.
    fn start() -> Option<Self> {
        if !has("s3") {
            return None;
        }
        let mut command = Command::new("moto_server");
        command.args(["-H", "127.0.0.1", "-p", "0"]);
        let Ok(mut child) = command.stderr(Stdio::piped()).spawn() else {
            crate::skips::skip("no moto_server");
            return None;
        };
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let endpoint = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix(" * Running on ").map(str::to_owned))
            .expect("moto_server ended before it listened");
        std::thread::spawn(move || lines.for_each(drop));
        Some(Self { child, endpoint })
    }

    fn env(&self) -> [(&str, &str); 5] {
        [
            ("AWS_ENDPOINT_URL", &self.endpoint),
            ("AWS_ALLOW_HTTP", "true"),
            ("AWS_REGION", "us-east-1"),
            ("AWS_ACCESS_KEY_ID", "veloid"),
            ("AWS_SECRET_ACCESS_KEY", "veloid"),
        ]
    }
}

impl Drop for S3 {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[tokio::test]
async fn a_ride_in_object_storage_is_worked_on_and_comes_back() {
    let Some(s3) = S3::start() else { return };
    let bucket = format!("{}/lab", s3.endpoint);
    let client = http().build().unwrap();
    assert!(
        client
            .put(&bucket)
            .send()
            .await
            .unwrap()
            .status()
            .is_success()
    );

    let files = ["--files", "s3://lab/rides"];
    let server = Server::with_env(&[&["--workers", "0"], &files[..]].concat(), &s3.env());
    let job = server.submit(&[]).await;
    let _worker = server.worker(&files);
    let view = server.succeeded(&job).await;

    let address = format!("/v1/rides/{}/file", view["ride"]["id"].as_str().unwrap());
    let back = server.get(&address).await.bytes().await.unwrap();
    assert_eq!(back, ride::example());
    let list = client
        .get(&bucket)
        .send()
        .await
        .unwrap()
        .text()
        .await
        .unwrap();
    assert_eq!(list.matches("<Key>rides/").count(), 2, "{list}");
    assert!(list.contains("<Key>rides/installation</Key>"), "{list}");
    // Another database has no part in it.
    let other = Folder::new();
    let migrate = ["migrate", "--data", other.0.to_str().unwrap()];
    let refused = Command::new(&*VELOID)
        .args(migrate)
        .args(files)
        .envs(s3.env())
        .output();
    let refused = String::from_utf8(refused.unwrap().stderr).unwrap();
    assert!(refused.contains("the database has no rides"), "{refused}");
    assert!(
        !server.folder.0.join("rides").exists(),
        "nothing is kept beside it"
    );
    let on_its_way = server.folder.0.join("incoming").read_dir().unwrap();
    assert_eq!(on_its_way.count(), 0);
}
