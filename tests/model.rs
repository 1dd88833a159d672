use std::process::Command;

use serde_json::Value;

use crate::harness::Server;
use crate::ride;

#[tokio::test]
async fn the_model_comes_as_json_and_as_a_script_that_simulates_it() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let report = server.json(&format!("{job}/report")).await;
    let model = server.json(&format!("{job}/model")).await;
    assert_eq!(model["plain"], report["output_error"]);
    assert!(model["extended"].is_null(), "no diagnosis was asked for");

    let response = server.get(&format!("{job}/model?format=matlab")).await;
    assert_eq!(
        response.headers()["content-type"],
        "text/x-matlab; charset=utf-8"
    );
    let script = response.text().await.unwrap();
    assert!(
        script.contains("strcmp(strtrim(ride.colheaders), 'u_r')"),
        "{script}"
    );
    if Command::new("octave").arg("--version").output().is_err() {
        eprintln!("skipped: no octave to run the script");
        return;
    }
    server.folder.write("veloid_model.m", script);
    server.folder.write("ride.csv", ride::example());
    let call = "[t, z] = veloid_model('ride.csv'); dlmwrite('z.csv', z, 'precision', 12);";
    let mut octave = Command::new("octave");
    octave.args(["--no-gui", "--quiet", "--eval", call]);
    octave.current_dir(&server.folder.0).output().unwrap();
    let simulated = std::fs::read_to_string(server.folder.0.join("z.csv")).unwrap();
    let series = server.json(&format!("{job}/series?points=100000")).await;
    for (column, axle) in ["front", "rear"].into_iter().enumerate() {
        let plain = series["axles"][axle]["plain"].as_array().unwrap();
        let own = simulated
            .lines()
            .map(|line| line.split(',').nth(column).unwrap());
        let far = |(own, plain): (&str, &Value)| {
            (own.parse::<f64>().unwrap() - plain.as_f64().unwrap()).abs() > 1e-9
        };
        assert_eq!(simulated.lines().count(), plain.len());
        assert_eq!(
            own.zip(plain).filter(|pair| far(*pair)).count(),
            0,
            "{axle}"
        );
    }
}
