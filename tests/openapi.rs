use std::path::Path;

use serde_json::Value;

use crate::harness::{Server, veloid};

fn committed() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../openapi/openapi.json");
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn the_committed_document_is_what_the_program_prints() {
    let printed = String::from_utf8(veloid(&["openapi"]).stdout).unwrap();
    assert!(
        printed == committed(),
        "openapi/openapi.json is out of date: cargo run -- openapi > openapi/openapi.json"
    );
}

#[tokio::test]
async fn the_committed_document_is_what_the_server_serves() {
    let server = Server::start();
    let committed: Value = serde_json::from_str(&committed()).unwrap();
    assert_eq!(server.json("/openapi.json").await, committed);
    let docs = server.get("/docs/").await.text().await.unwrap();
    assert!(docs.contains("swagger-ui"), "{docs}");
}

#[test]
fn every_reference_has_its_schema_and_every_operation_its_own_name() {
    let text = committed();
    let document: Value = serde_json::from_str(&text).unwrap();
    let schemas = document["components"]["schemas"].as_object().unwrap();
    for part in text.split("#/components/schemas/").skip(1) {
        let name = part.split_once('"').unwrap().0;
        assert!(schemas.contains_key(name), "{name} is missing");
    }
    let names = text.split("\"operationId\": \"").skip(1);
    let mut names: Vec<&str> = names.map(|part| part.split_once('"').unwrap().0).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
}

/// utoipa keeps one of two schemas of the same name, without a word.
#[test]
fn no_two_types_share_a_schema() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut folders = ["engine", "server"]
        .map(|folder| root.join(folder))
        .to_vec();
    let mut names: Vec<String> = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                names.extend(schemas(&std::fs::read_to_string(path).unwrap()));
            }
        }
    }
    assert!(names.len() > 100, "{}", names.len());
    names.sort_unstable();
    let twice: Vec<&[String]> = names.windows(2).filter(|two| two[0] == two[1]).collect();
    assert!(twice.is_empty(), "{twice:?}: give one `#[schema(as = …)]`");
}

/// Names of the schemas of a file: of each type that derives `ToSchema`, its own or the one given by `as`.
fn schemas(source: &str) -> Vec<String> {
    let types = source.split("derive(").skip(1).filter_map(|part| {
        let (derived, rest) = part.split_once(')')?;
        derived.contains("ToSchema").then_some(rest)
    });
    let word = |text: &str| {
        text.split(|c: char| !c.is_alphanumeric())
            .next()
            .map(str::to_owned)
    };
    let name = |rest: &str| {
        let keyword = ["struct ", "enum "]
            .into_iter()
            .filter_map(|k| Some((rest.find(k)?, k)));
        let (at, keyword) = keyword.min()?;
        let given = rest[..at]
            .split_once("schema(as = ")
            .map(|(_, after)| after);
        word(given.unwrap_or(&rest[at + keyword.len()..]))
    };
    types.filter_map(name).collect()
}
