//! Commands that ask a server: `serve --demo` its own, `health` the one of this machine.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::built::{VELOID, veloid};
use crate::harness::{Folder, Server};

#[test]
fn the_demo_uploads_rides_and_says_how_they_ended() {
    let folder = Folder::new();
    let mut server = Command::new(&*VELOID)
        .args(["serve", "--demo", "--listen", "127.0.0.1:0", "--data"])
        .arg(&folder.0)
        .env_remove("DATABASE_URL")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let lines = BufReader::new(server.stdout.take().unwrap()).lines();
    let mut said: Vec<String> = Vec::new();
    for line in lines.map_while(Result::ok) {
        let is_last = line.starts_with("demo: done");
        said.push(line);
        if is_last {
            break;
        }
    }
    server.kill().unwrap();
    server.wait().unwrap();
    let said = said.join("\n");
    for expected in [
        "clean.csv: succeeded, verdict nothing_missing",
        "friction.csv: succeeded, verdict named",
        "accelerometers.csv: succeeded, verdict named",
        "12 rides as one: succeeded, verdict named",
        "demo: done",
    ] {
        assert!(said.contains(expected), "{said}");
    }
}

#[tokio::test]
async fn health_is_that_of_the_server_on_this_machine() {
    let mut server = Server::with(&["--workers", "0"]);
    let listen = server.url.trim_start_matches("http://").to_owned();
    let health = || veloid(&["health", "--listen", &listen]);
    let ready = health();
    assert!(ready.status.success(), "{ready:?}");
    assert_eq!(ready.stdout, b"ready\n");
    server.kill();
    let gone = health();
    assert_eq!(gone.status.code(), Some(1), "{gone:?}");
    assert!(String::from_utf8(gone.stderr).unwrap().contains("refused"));
}
