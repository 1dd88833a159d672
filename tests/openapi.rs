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
