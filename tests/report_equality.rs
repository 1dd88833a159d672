use serde_json::Value;
use veloid_engine::document::format_number::Number;

use crate::harness::{Folder, Server, identify};
use crate::ride;

#[tokio::test]
async fn the_server_and_the_command_line_report_the_same_numbers() {
    let server = Server::with(&["--workers", "2"]);
    let job = server.submit(&[("seed", "7")]).await;
    server.succeeded(&job).await;
    let served = server
        .get(&format!("{job}/report"))
        .await
        .text()
        .await
        .unwrap();

    let folder = Folder::new();
    let ride = folder.write("ride.csv", ride::example());
    let bike = folder.write("bike.json", ride::BIKE);
    let swarm = ["--trials", "3", "--particles", "12", "--iterations", "8"];
    let args = [&["--seed", "7", "--no-diagnosis"], &swarm[..]].concat();
    let (written, summary) = identify(&ride, &bike, &args);
    assert!(summary.contains("output error"), "{summary}");

    // Texts of the numbers, not their values: not even the last bit may differ.
    let served: Value = serde_json::from_str(&served).unwrap();
    assert_eq!(served.to_string(), written.to_string());
}

/// z_f of the example turned upside down, and two samples early.
fn spoilt(by: impl Fn(&[String], usize) -> String) -> Vec<u8> {
    let table = ride::table(1200, 100.0);
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
    let front: Vec<String> = rows[1..].iter().map(|r| r[3].to_owned()).collect();
    let mut csv = rows[0].join(",");
    for (i, row) in rows[1..].iter().enumerate() {
        let z_f = by(&front, i);
        csv += &format!("\n{},{},{},{z_f},{}", row[0], row[1], row[2], row[4]);
    }
    csv.into_bytes()
}

/// The plain model of such rides runs away: what it makes of them is unknown, on both ways, and every page stands.
#[tokio::test]
async fn rides_that_no_bicycle_makes_end_alike_on_both_ways() {
    let server = Server::on_sqlite(&["--workers", "2"]);
    let folder = Folder::new();
    let bike = folder.write("bike.json", ride::BIKE);
    let negated = spoilt(|z, i| match z[i].strip_prefix('-') {
        Some(positive) => positive.to_owned(),
        None => format!("-{}", z[i]),
    });
    let early = spoilt(|z, i| z[(i + 2).min(z.len() - 1)].clone());
    for csv in [negated, early, ride::table(1200, 100.0).into_bytes()] {
        let parts = [&ride::QUICK[..3], &[("diagnosis", "true"), ("seed", "7")]].concat();
        let response = server.upload(csv.clone(), ride::BIKE, &parts).await;
        assert_eq!(response.status(), 202);
        let job = response.headers()["location"].to_str().unwrap().to_owned();
        server.succeeded(&job).await;
        let served = server.get(&format!("{job}/report")).await;
        let served: Value = serde_json::from_str(&served.text().await.unwrap()).unwrap();

        let ride = folder.write("ride.csv", &csv);
        let swarm = ["--trials", "3", "--particles", "12", "--iterations", "8"];
        let (written, _) = identify(&ride, &bike, &[&["--seed", "7"], &swarm[..]].concat());
        assert_eq!(served.to_string(), written.to_string());

        let page = job.replace("/v1/jobs", "/jobs");
        for path in [page, format!("{job}/model"), format!("{job}/series")] {
            assert_eq!(server.get(&path).await.status(), 200, "{path}");
        }
    }
}

/// The report of one ride, diagnosis and all. PostgreSQL spells numbers in its own way (1e16 as
/// 10000000000000000), so that each is brought to the spelling of the double it stands for.
async fn report(server: &Server) -> String {
    let parts = [("seed", "7"), ("trials", "8"), ("diagnosis", "true")];
    let job = server.submit(&parts).await;
    server.succeeded(&job).await;
    let mut report = server.json(&format!("{job}/report")).await;
    as_doubles(&mut report);
    report.to_string()
}

fn as_doubles(value: &mut Value) {
    match value {
        Value::Number(number) => *value = number.as_f64().into(),
        Value::Array(values) => values.iter_mut().for_each(as_doubles),
        Value::Object(values) => values.values_mut().for_each(as_doubles),
        _ => {}
    }
}

#[tokio::test]
async fn neither_the_database_nor_the_number_of_workers_changes_a_number() {
    let expected = report(&Server::on_sqlite(&["--workers", "2"])).await;
    assert!(expected.contains("\"verdict\":"), "{expected}");
    if crate::built::postgres().is_none() {
        return crate::skips::not_applicable("no PostgreSQL to compare SQLite with");
    }
    for count in [1, 4] {
        let server = Server::with(&["--workers", "0"]);
        let _workers: Vec<_> = (0..count).map(|_| server.worker(&[])).collect();
        let all = format!("\nveloid_workers {count}\n");
        while !server
            .get("/metrics")
            .await
            .text()
            .await
            .unwrap()
            .contains(&all)
        {
            tokio::time::sleep(std::time::Duration::from_millis(50)).await;
        }
        let found = report(&server).await;
        assert!(found == expected, "{count} workers:\n{found}\n{expected}");
    }
}

/// One way to write a number and one meaning of its margin, said once on each screen.
#[tokio::test]
async fn margins_mean_the_same_at_the_command_line_and_on_the_page() {
    let server = Server::start();
    let job = server.submit(&[("seed", "7")]).await;
    server.succeeded(&job).await;
    let page = server.get(job.trim_start_matches("/v1")).await;
    let page = page.text().await.unwrap();
    let folder = Folder::new();
    let ride = folder.write("ride.csv", ride::example());
    let bike = folder.write("bike.json", ride::BIKE);
    let swarm = ["--trials", "3", "--particles", "12", "--iterations", "8"];
    let args = [&["--seed", "7", "--no-diagnosis"], &swarm[..]].concat();
    let (report, summary) = identify(&ride, &bike, &args);
    for screen in [&page, &summary] {
        assert_eq!(
            screen.matches("± is the 95 % interval").count(),
            1,
            "{screen}"
        );
        assert!(
            !screen.contains("+/-") && !screen.contains("+-"),
            "{screen}"
        );
    }
    for (method, number) in [
        (
            "output_error",
            Number::measured as fn(f64, Option<f64>) -> _,
        ),
        ("swarm", Number::scattered),
    ] {
        let found = &report[method]["front"];
        let spread = found["k_std_n_m"].as_f64();
        let spread = spread.or(found["k_scatter_n_m"].as_f64());
        let k = number(found["k_n_m"].as_f64().unwrap(), spread);
        let reported = k.to_string();
        assert!(summary.contains(&reported), "{reported}: {summary}");
        let margin = k.margin.unwrap();
        let (value, mark) = (k.value, k.mark);
        let reported = format!("{value}<span class=\"margin\">{mark}{margin}</span>");
        assert!(page.contains(&reported), "{reported}: {page}");
    }
}
