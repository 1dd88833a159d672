//! Fixed and bounded parameters at the command line and through the server.

use serde_json::Value;

use crate::harness::{Folder, Server, veloid};
use crate::ride;

const SHORT: [(&str, &str); 3] = [("trials", "1"), ("particles", "4"), ("iterations", "2")];

#[tokio::test]
async fn an_upload_fixes_k_and_a_wrong_key_is_refused() {
    let server = Server::start();
    let parts = [&SHORT[..], &[("fix", "f.k=60000"), ("bound", "r.B=0:1e5")]].concat();
    let response = server.upload(ride::example(), ride::BIKE, &parts).await;
    assert_eq!(response.status(), 202);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    let report = server.json(&format!("{job}/report")).await;
    assert_eq!(report["settings"]["fix"]["f.k"], 60000.0);
    assert_eq!(report["settings"]["bound"]["r.B"][1], 1e5);
    let k = &report["result"]["front"]["k"];
    assert_eq!(
        (&k["value"], &k["interval"]),
        (&Value::from(60000.0), &Value::Null)
    );
    assert_eq!(k["why"], "fixed at 60000 N/m by the user");
    let parts = [&SHORT[..], &[("fix", "f.c=3")]].concat();
    let response = server.upload(ride::example(), ride::BIKE, &parts).await;
    assert_eq!(response.status(), 422);
    let problem: Value = response.json().await.unwrap();
    let detail = problem["detail"].as_str().unwrap();
    assert!(
        detail.contains("f.c: unknown quantity 'c', expected k or B"),
        "{detail}"
    );
}

#[test]
fn the_command_line_says_what_cannot_be_fixed() {
    let folder = Folder::new();
    let path = |name: &str| folder.0.join(name).to_str().unwrap().to_owned();
    std::fs::write(path("ride.csv"), ride::example()).unwrap();
    std::fs::write(path("bike.json"), ride::BIKE).unwrap();
    for (option, value, said) in [
        (
            "--fix",
            "f.k",
            "fix: 'f.k', expected AXLE.QUANTITY=VALUE such as f.k=60000",
        ),
        (
            "--fix",
            "f.k=inf",
            "fix: 'f.k=inf', expected AXLE.QUANTITY=VALUE",
        ),
        (
            "--fix",
            "q.k=1",
            "q.k: unknown axle 'q', expected f, front, r or rear",
        ),
        (
            "--bound",
            "r.B=9",
            "bound: 'r.B=9', expected AXLE.QUANTITY=LOW:HIGH",
        ),
        (
            "--bound",
            "r.B=9:3",
            "r.B is bounded by 9 and 3, expected the lower bound first",
        ),
    ] {
        let (ride, bike) = (path("ride.csv"), path("bike.json"));
        let output = veloid(&["identify", &ride, "--bike", &bike, option, value]);
        assert_eq!(output.status.code(), Some(2), "{value}");
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(reported.contains(said), "{reported}");
    }
}
