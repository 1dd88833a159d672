//! A proof that is killed goes on where it was, with a program in veloid's stead that says nothing is missing.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Writes down each ride it is given. Without a file `go` the third takes for ever; without `well` ride 004 kills it.
const PROGRAM: &str = r#"#!/bin/sh
here=$(dirname "$0")
basename "$2" >>"$here/begun"
[ -e "$here/go" ] || [ "$(wc -l <"$here/begun")" -lt 3 ] || exec sleep 30
case $2 in *_004.csv) [ -e "$here/well" ] || kill -9 $$ ;; esac
echo '{"diagnosis": {"verdict": "nothing_missing"}}' >"$6"
"#;

struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl Folder {
    fn new() -> Self {
        let path = std::env::temp_dir().join(format!("veloid-goes-on-{}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn program(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, text).expect("written");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("executable");
        path
    }

    fn prove(&self, binary: &Path, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_veloid-truth"));
        command
            .args(["prove", "--suite", "clean300", "--count", "4", "--work"])
            .arg(self.0.join("work"))
            .arg("--binary")
            .arg(binary)
            .args(more)
            .env("RAYON_NUM_THREADS", "1")
            .stdin(Stdio::null());
        command
    }

    /// The rides that were begun, one line each.
    fn begun(&self) -> Vec<String> {
        let text = fs::read_to_string(self.0.join("begun")).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }

    fn kept(&self) -> usize {
        let entries = fs::read_dir(self.0.join("work/clean300_kept")).expect("kept");
        entries.count()
    }

    fn allow(&self, what: &str) {
        fs::write(self.0.join(what), "").expect("written");
    }
}

fn said(output: &Output) -> String {
    let text = [&output.stdout[..], &output.stderr].concat();
    String::from_utf8_lossy(&text).into_owned()
}

#[test]
fn a_proof_that_was_killed_goes_on() {
    let folder = Folder::new();
    let binary = folder.program("veloid", PROGRAM);
    let prove = |more: &[&str]| folder.prove(&binary, more).output().expect("run");

    let mut killed = folder.prove(&binary, &[]);
    let mut killed = killed
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("run");
    let until = Instant::now() + Duration::from_secs(120);
    while folder.begun().len() < 3 && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(20));
    }
    killed.kill().expect("killed");
    killed.wait().expect("gone");
    assert_eq!(folder.kept(), 2, "{:?}", folder.begun());

    let nothing = prove(&["--budget", "0s"]);
    assert!(nothing.status.success(), "{}", said(&nothing));
    assert!(
        said(&nothing).contains("2 of 4 rides, development seed 1"),
        "{}",
        said(&nothing)
    );
    assert!(
        said(&nothing).contains("The same command goes on"),
        "{}",
        said(&nothing)
    );
    assert_eq!(folder.begun().len(), 3);

    let says = |name: &str, verdict: &str| {
        let text = format!(
            "#!/bin/sh\necho '{{\"diagnosis\": {{\"verdict\": \"{verdict}\"}}}}' >\"$6\"\n"
        );
        let binary = folder.program(name, &text);
        let run = folder.prove(&binary, &["--budget", "0s"]).output();
        run.expect("run")
    };
    let other = says("other", "unnamed");
    assert!(
        said(&other).contains("reported otherwise of"),
        "{}",
        said(&other)
    );
    for refused in [other, prove(&["--seed", "2"])] {
        assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
        assert!(
            said(&refused).contains("name another folder (--work)"),
            "{}",
            said(&refused)
        );
    }
    let rebuilt = says("rebuilt", "nothing_missing");
    assert!(
        said(&rebuilt).contains("2 of 4 rides"),
        "{}",
        said(&rebuilt)
    );
    assert_eq!(folder.begun().len(), 3);

    folder.allow("go");
    let whole = prove(&[]);
    assert!(whole.status.success(), "{}", said(&whole));
    assert!(
        said(&whole).contains("4 of 4 rides, development seed 1"),
        "{}",
        said(&whole)
    );
    assert_eq!(folder.kept(), 3, "what a signal ended is not kept");
    folder.allow("well");
    assert!(prove(&[]).status.success());
    assert!(prove(&[]).status.success());
    let mut begun = folder.begun();
    begun.sort();
    let times = |name: &str| begun.iter().filter(|b| b.as_str() == name).count();
    let rides = [
        "ride_001.csv",
        "ride_002.csv",
        "ride_003.csv",
        "ride_004.csv",
    ];
    assert_eq!(rides.map(times), [1, 1, 2, 2]);
    assert!(!said(&prove(&[])).contains("goes on"));
    let bad = prove(&["--budget", "soon"]);
    assert!(
        said(&bad).contains("expected 90s, 15m or 2h"),
        "{}",
        said(&bad)
    );
}
