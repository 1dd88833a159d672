//! What the API's document says of keys: every operation that needs one, and what it answers without.

use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{ContentBuilder, HeaderBuilder, OpenApi, Ref, Response, ResponseBuilder};

const SCHEME: &str = "key";
/// What is open to all.
pub const OPEN: [&str; 2] = ["/healthz", "/readyz"];

pub fn secured(document: &mut OpenApi) {
    let scheme = HttpBuilder::new()
        .scheme(HttpAuthScheme::Bearer)
        .description(Some(
            "Created by `veloid key create`. A server that only its own machine can reach requires none.",
        ))
        .build();
    let components = document.components.get_or_insert_default();
    components.add_security_scheme(SCHEME, SecurityScheme::Http(scheme));
    for (path, item) in &mut document.paths.paths {
        if OPEN.contains(&path.as_str()) {
            continue;
        }
        let operations = [
            &mut item.get,
            &mut item.post,
            &mut item.patch,
            &mut item.delete,
        ];
        for operation in operations.into_iter().flatten() {
            let none: [&str; 0] = [];
            operation.security = Some(vec![SecurityRequirement::new(SCHEME, none)]);
            let answers = &mut operation.responses.responses;
            for (status, response) in [
                ("401", problem("No valid key")),
                ("403", problem("The key does not allow this")),
                ("429", later("A limit of the key is reached")),
            ] {
                answers.insert(status.to_owned(), response.into());
            }
        }
    }
}

fn problem(description: &str) -> Response {
    let content = ContentBuilder::new()
        .schema(Some(Ref::from_schema_name("Problem")))
        .build();
    ResponseBuilder::new()
        .description(description)
        .content("application/problem+json", content)
        .build()
}

fn later(description: &str) -> Response {
    let mut response = problem(description);
    let header = HeaderBuilder::new()
        .description(Some("Seconds to wait before trying again"))
        .build();
    response
        .headers
        .insert("Retry-After".to_owned(), header.into());
    response
}
