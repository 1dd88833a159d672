//! A backup of a server that is at work, and a server on what was restored.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::bad_days::Mount;
use crate::harness::{Folder, Server, VELOID, raw_files, veloid};
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

/// A backup of a server that has identified a ride, and the folder that it is in.
async fn backup_of_a_result() -> (Folder, PathBuf) {
    let mut server = Server::on_sqlite(&["--workers", "1"]);
    let (job, _) = submit(&server, 1000).await;
    server.succeeded(&job).await;
    let folder = Folder::new();
    let backup = folder.0.join("backup");
    let output = server.beside(&["backup", text(&backup)]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    server.kill();
    (folder, backup)
}

/// Exit status and all output of a command.
fn run(args: &[&str]) -> (i32, String) {
    let output = veloid(args);
    let all = [output.stdout, output.stderr].concat();
    (
        output.status.code().unwrap(),
        String::from_utf8(all).unwrap(),
    )
}

fn sums_agree(backup: &Path) -> bool {
    let mut sums = Command::new("sha256sum");
    let sums = sums.args(["--check", "--strict", "--quiet", "SHA256SUMS"]);
    sums.current_dir(backup).status().unwrap().success()
}

#[tokio::test]
async fn every_file_of_a_backup_that_is_altered_or_missing_is_named() {
    let (folder, backup) = backup_of_a_result().await;
    let (check, data) = (["check", "--data", text(&backup)], folder.0.join("data"));
    let restore = ["restore", text(&backup), "--data", text(&data)];
    assert_eq!(
        run(&check),
        (0, "the backup is as it was written\n".to_owned())
    );
    assert!(sums_agree(&backup), "a check alters nothing");
    let raw = raw_files(&backup).remove(0);
    let raw = format!("rides/{}", raw.file_name().unwrap().to_str().unwrap());
    for (name, is_restored) in [
        ("veloid.db", false),
        ("rides/installation", false),
        (&raw, true),
    ] {
        let path = backup.join(name);
        let bytes = std::fs::read(&path).unwrap();
        let mut altered = bytes.clone();
        // Of a report in the database: its own checks do not see that.
        let needle = b"\"veloid\":\"0.1.0\"";
        let at = bytes
            .windows(needle.len())
            .position(|window| window == needle);
        altered[at.map_or(10, |at| at + 13)] ^= 1;
        for broken in [Some(altered), None] {
            match broken {
                Some(bytes) => std::fs::write(&path, bytes).unwrap(),
                None => std::fs::remove_file(&path).unwrap(),
            }
            let (status, said) = run(&check);
            assert!(status == 1 && said.contains(name), "{name}: {said}");
            let (status, said) = run(&restore);
            let short = name.strip_prefix("rides/").unwrap_or(name);
            assert!(status == 1 && said.contains(short), "{name}: {said}");
            assert_eq!(
                data.join("veloid.db").exists(),
                is_restored,
                "{name}: {said}"
            );
            let _ = std::fs::remove_dir_all(&data);
        }
        std::fs::write(&path, bytes).unwrap();
    }
    assert_eq!(run(&check).0, 0);

    let manifest = backup.join("SHA256SUMS");
    let lines = std::fs::read_to_string(&manifest).unwrap();
    for line in lines.lines() {
        std::fs::write(&manifest, lines.replace(&format!("{line}\n"), "")).unwrap();
        let (status, said) = run(&check);
        let (_, name) = line.split_once("  ").unwrap();
        assert!(status == 1 && said.contains(name), "{line}: {said}");
    }
    std::fs::write(&manifest, lines.replacen(' ', "", 1)).unwrap();
    for command in [&check[..], &restore] {
        let (status, said) = run(command);
        assert!(status == 1 && said.contains("line 1"), "{said}");
    }

    std::fs::remove_file(&manifest).unwrap();
    let (status, said) = run(&restore);
    assert!(
        status == 0 && said.contains("there is no SHA256SUMS"),
        "{said}"
    );
    assert_eq!(run(&["check", "--data", text(&data)]).0, 0);
}

#[tokio::test]
async fn a_copy_onto_a_full_disk_leaves_nothing() {
    let folder = Folder::new();
    let Some(disk) = Mount::small(folder.0.join("disk")) else {
        return;
    };
    let server = Server::on_sqlite(&["--workers", "0"]);
    let (_, ride) = submit(&server, 40_000).await;
    // More than SQLite keeps in memory before it writes.
    const ROWS: &str = "\
        WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 3000) \
        INSERT INTO audit (id, group_name, actor, action, subject, done_at) \
        SELECT randomblob(16), 'default', 'server', 'fill', hex(randomblob(1000)), 0 FROM n";
    server.execute(ROWS).await;
    let kept = folder.0.join("kept");
    let source = text(&server.folder.0);
    assert_eq!(run(&["backup", text(&kept), "--data", source]).0, 0);
    let ballast = disk.fill();
    let full = std::fs::metadata(&ballast).unwrap().len();
    let database = std::fs::metadata(kept.join("veloid.db")).unwrap().len();
    assert!(database > 6_000_000 && ride.len() > 1_500_000);
    let (new, empty) = (disk.0.join("new"), disk.0.join("empty"));
    // No room at all, for some of the database, and for the database without the ride.
    for room in [0, 100_000, database / 2, database + 1_000_000] {
        let file = std::fs::File::options().write(true).open(&ballast).unwrap();
        file.set_len(full - room).unwrap();
        let _ = std::fs::create_dir(&empty);
        for target in [&new, &empty] {
            let backup = ["backup", text(target), "--data", source];
            let restore = ["restore", text(&kept), "--data", text(target)];
            for command in [backup, restore] {
                let (status, said) = run(&command);
                assert_eq!(status, 1, "{command:?} with {room} bytes: {said}");
                assert!(said.contains("disk is full; the copy takes "), "{said}");
                let left = std::fs::read_dir(target).map_or(0, Iterator::count);
                assert_eq!(left, 0, "{command:?} with {room} bytes");
            }
        }
        assert!(!new.exists(), "with {room} bytes");
    }
    std::fs::remove_file(ballast).unwrap();
    assert_eq!(run(&["backup", text(&new), "--data", source]).0, 0);
    std::fs::remove_dir_all(&new).unwrap();
    assert_eq!(run(&["restore", text(&kept), "--data", text(&empty)]).0, 0);
}

/// Whenever a copy is killed, what has its name is whole.
#[tokio::test]
async fn a_copy_that_is_killed_is_whole_or_has_no_database() {
    let (folder, backup) = backup_of_a_result().await;
    let mut whole = 0;
    for delay in 0..24 {
        let copies = [("backup", "--data", &backup), ("restore", "", &backup)];
        for (command, option, from) in copies {
            let to = folder.0.join(format!("{command}-{delay}"));
            let args: Vec<&str> = match option {
                "" => vec![command, text(from), "--data", text(&to)],
                data => vec![command, text(&to), data, text(from)],
            };
            let mut child = Command::new(&*VELOID)
                .args(args)
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(Duration::from_millis(4 * delay));
            let _ = child.kill();
            child.wait().unwrap();
            if to.join("veloid.db").exists() {
                whole += 1;
                let (status, said) = run(&["check", "--data", text(&to)]);
                assert_eq!(status, 0, "{command} killed after {} ms: {said}", 4 * delay);
            }
        }
    }
    eprintln!("{whole} of 48 copies were whole when they were killed");
}
