use std::collections::BTreeSet;

use serde_json::Value;
#[cfg(feature = "postgres")]
use sqlx::{AssertSqlSafe, Connection, PgConnection};

use crate::harness::Server;
use crate::season;
use crate::skips::not_applicable;

/// Every metric that the dashboard asks for is one that the server has.
#[tokio::test]
async fn the_dashboard_asks_for_metrics_that_are_there() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docker/grafana/veloid.json");
    let text = std::fs::read_to_string(path).unwrap();
    let dashboard: Value = serde_json::from_str(&text).unwrap();
    let panels = dashboard["panels"].as_array().unwrap();
    let expressions = panels
        .iter()
        .flat_map(|panel| panel["targets"].as_array().unwrap())
        .map(|target| target["expr"].as_str().unwrap());
    let asked: BTreeSet<&str> = expressions
        .flat_map(|expression| expression.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')))
        .filter(|word| word.starts_with("veloid_"))
        .collect();
    assert!(asked.len() >= 6, "{asked:?}");

    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let metrics = server.get("/metrics").await.text().await.unwrap();
    for name in asked {
        let mut lines = metrics.lines();
        let named = lines.any(|line| {
            line.strip_prefix(name)
                .is_some_and(|rest| rest.starts_with(['{', ' ']))
        });
        assert!(named, "{name} is missing in\n{metrics}");
    }
}

#[cfg(feature = "postgres")]
fn fleet() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docker/grafana/fleet.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// As Grafana fills in what stands for the chosen group, bicycle and time.
#[cfg(feature = "postgres")]
fn filled(sql: &str) -> String {
    sql.replace("${group:sqlstring}", "'default'")
        .replace("${bike:sqlstring}", "'season-001'")
        .replace("${__from}", "0")
        .replace("${__to}", "99999999999999")
}

#[cfg(not(feature = "postgres"))]
#[test]
fn the_fleets_dashboard_asks_what_postgresql_answers() {
    not_applicable("the tests are built without the feature `postgres`");
}

/// Every query of the fleet's dashboard runs on PostgreSQL, changes nothing and finds something.
#[cfg(feature = "postgres")]
#[tokio::test]
async fn the_fleets_dashboard_asks_what_postgresql_answers() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 3, 90).await;
    let Some(url) = server.database() else {
        return not_applicable("VELOID_TEST_POSTGRES names no PostgreSQL");
    };
    let mut database = PgConnection::connect(url).await.unwrap();
    let dashboard = fleet();
    let panels = dashboard["panels"].as_array().unwrap();
    let queries = panels.iter().flat_map(|panel| {
        let targets = panel["targets"].as_array().unwrap();
        targets.iter().map(|target| {
            (
                panel["title"].as_str().unwrap(),
                target["rawSql"].as_str().unwrap(),
            )
        })
    });
    let variables = dashboard["templating"]["list"]
        .as_array()
        .unwrap()
        .iter()
        .skip(1);
    let variables = variables.map(|variable| {
        (
            variable["name"].as_str().unwrap(),
            variable["query"].as_str().unwrap(),
        )
    });
    let mut asked = 0;
    for (title, sql) in queries.chain(variables) {
        let sql = filled(sql);
        assert!(!sql.contains('$'), "{title}: {sql}");
        let mut transaction = database.begin().await.unwrap();
        sqlx::raw_sql("SET TRANSACTION READ ONLY")
            .execute(&mut *transaction)
            .await
            .unwrap();
        let rows = sqlx::raw_sql(AssertSqlSafe(sql))
            .fetch_all(&mut *transaction)
            .await;
        let rows = rows.unwrap_or_else(|error| panic!("{title}: {error}"));
        // Nothing of a made-up season fails.
        assert_eq!(rows.is_empty(), title == "Latest failures", "{title}");
        asked += 1;
    }
    assert!(asked >= 11, "{asked} queries");
}

/// What docs/dashboards.md has the API asked for is there.
#[tokio::test]
async fn the_api_answers_what_the_page_on_dashboards_asks() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 3, 90).await;
    let page = include_str!("../docs/dashboards.md");
    let rows = page.lines().filter_map(|line| {
        let (address, rest) = line.split_once("| `/v1/")?.1.split_once('`')?;
        Some((
            format!("/v1/{address}"),
            rest.trim_matches(['|', ' ', '`']).to_owned(),
        ))
    });
    let mut asked = 0;
    for (address, root) in rows {
        let address = address
            .replace("$bike", "season-001")
            .replace("${__from:date:iso}", "2000-01-01T00:00:00.000Z")
            .replace("${__to:date:iso}", "2100-01-01T00:00:00.000Z");
        let answer = server.json(&address).await;
        let found = answer.pointer(&format!("/{}", root.replace('.', "/")));
        assert!(
            found.is_some_and(|found| !found.as_array().unwrap().is_empty()),
            "{address}: {root}"
        );
        asked += 1;
    }
    assert_eq!(asked, 5);
}
