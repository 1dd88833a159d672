//! A backup of a server that is at work, and a server on what was restored.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::harness::{Folder, Server, veloid};
use crate::ride::{self, LONG};

/// A job that was acknowledged, and the bytes of its ride.
type Acknowledged = (String, Vec<u8>);

/// Uploads a ride that no other upload has; its job.
async fn submit(server: &Server, samples: usize) -> Acknowledged {
    let file = ride::table(samples, 200.0).into_bytes();
    let response = server.upload(file.clone(), ride::BIKE, &ride::QUICK).await;
    assert_eq!(response.status(), 202);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    (job, file)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[tokio::test]
async fn a_backup_of_a_server_at_work_holds_all_that_was_acknowledged() {
    let server = Arc::new(Server::on_sqlite(&["--workers", "1"]));
    let mut acknowledged = vec![submit(&server, 1000).await];
    server.succeeded(&acknowledged[0].0).await;
    let report = server.json(&format!("{}/report", acknowledged[0].0)).await;
    // The only worker stays busy, so that what comes after it waits in the queue.
    let long = server.submit(&LONG).await;
    while server.json(&long).await["stage"] != "trial" {}
    for samples in 1001..1006 {
        acknowledged.push(submit(&server, samples).await);
    }

    let stop = Arc::new(AtomicBool::new(false));
    let uploads = tokio::spawn({
        let (server, stop) = (Arc::clone(&server), Arc::clone(&stop));
        async move {
            let mut count = 0;
            while !stop.load(Ordering::Relaxed) {
                submit(&server, 2000 + count).await;
                count += 1;
            }
            count
        }
    });
    let kept = Folder::new();
    let backup = kept.0.join("backup");
    let mut command = server.beside(&["backup", text(&backup)]);
    let output = tokio::task::spawn_blocking(move || command.output().unwrap()).await;
    let output = output.unwrap();
    assert!(output.status.success(), "{output:?}");
    stop.store(true, Ordering::Relaxed);
    assert!(uploads.await.unwrap() > 0, "nothing was uploaded meanwhile");

    let folder = Folder::new();
    let restore = ["restore", text(&backup), "--data", text(&folder.0)];
    let output = veloid(&restore);
    assert!(output.status.success(), "{output:?}");
    let again = veloid(&restore);
    assert_eq!(again.status.code(), Some(1), "what is there stays");
    assert!(
        String::from_utf8_lossy(&again.stderr)
            .contains("not empty, expected a new or an empty folder")
    );

    let restored = Server::in_folder(folder, &["--workers", "2"]);
    assert_eq!(restored.json(&long).await["state"], "running");
    assert_eq!(restored.cancel(&long).await.unwrap().status(), 200);
    for (job, file) in &acknowledged {
        let view = restored.succeeded(job).await;
        let ride = format!("/v1/rides/{}/file", view["ride"]["id"].as_str().unwrap());
        let kept = restored.get(&ride).await;
        assert!(
            kept.bytes().await.unwrap() == file[..],
            "the bytes of {job}"
        );
    }
    assert_eq!(
        restored
            .json(&format!("{}/report", acknowledged[0].0))
            .await,
        report
    );
    let all = restored.json("/v1/jobs?limit=1000").await;
    for job in all["items"].as_array().unwrap() {
        let job = job["links"]["job"].as_str().unwrap();
        if job != long {
            restored.succeeded(job).await;
        }
    }
}

#[tokio::test]
async fn a_raw_file_that_is_damaged_is_named_and_holds_up_no_other() {
    let server = Server::on_sqlite(&["--workers", "0"]);
    let jobs = [submit(&server, 500).await, submit(&server, 501).await];
    let mut shas = Vec::new();
    for (job, _) in &jobs {
        let sha256 = &server.json(job).await["ride"]["summary"]["sha256"];
        shas.push(sha256.as_str().unwrap().to_owned());
    }
    std::fs::write(server.folder.0.join("rides").join(&shas[0]), "t\n").unwrap();
    let kept = Folder::new();
    let backup = kept.0.join("backup");
    let output = server.beside(&["backup", text(&backup)]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains(&shas[0]) && message.contains("1 of 2"),
        "{message}"
    );
    assert!(!backup.join("rides").join(&shas[0]).exists());
    assert_eq!(
        std::fs::read(backup.join("rides").join(&shas[1])).unwrap(),
        jobs[1].1
    );
}

#[test]
fn what_cannot_be_copied_is_said() {
    let folder = Folder::new();
    let (nothing, new) = (folder.0.join("nothing"), folder.0.join("new"));
    let [nothing, new] = [&nothing, &new].map(|path| text(path));
    let postgres = "postgres://127.0.0.1/veloid";
    for (arguments, problem) in [
        (["backup", new, "--data", nothing], "no such database"),
        (["restore", nothing, "--data", new], "no such database"),
        (["backup", new, "--database-url", postgres], "pg_dump"),
    ] {
        let output = veloid(&arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(problem), "{message}");
        assert!(!folder.0.join("new").exists(), "{arguments:?}");
    }
}
