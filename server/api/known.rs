//! Refuses query parameters that a route does not have: a mistyped filter would give everything. What
//! a route has is what the API's document says.

use std::collections::HashMap;
use std::sync::Arc;

use axum::extract::{MatchedPath, Request, State};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use utoipa::openapi::path::{Operation, ParameterIn, PathItem};
use utoipa::openapi::{OpenApi, RefOr};

use super::problem::{Kind, Problem};
use crate::bicycle::Given;
use crate::facts;
use crate::options::Options;

/// Uploads take every option, and what describes the bicycle, in their query too, which would be long to list there.
const UPLOADS: [&str; 2] = ["/v1/rides", "/v1/rides/preview"];
/// Most of a name that a problem repeats (characters).
const SHOWN: usize = 80;

/// The parameters of each route.
pub type Known = Arc<HashMap<(Method, String), Vec<String>>>;

pub fn of(document: &OpenApi) -> Known {
    let mut known = HashMap::new();
    for (path, item) in &document.paths.paths {
        for (method, operation) in operations(item) {
            let mut names = in_query(operation);
            if method == Method::POST && UPLOADS.contains(&path.as_str()) {
                let parts = Given::names().chain(Options::names()).chain(facts::names());
                names.extend(parts.map(str::to_owned));
            }
            known.insert((method, path.clone()), names);
        }
    }
    Arc::new(known)
}

fn operations(item: &PathItem) -> impl Iterator<Item = (Method, &Operation)> {
    let all = [
        (Method::GET, &item.get),
        (Method::HEAD, &item.get),
        (Method::POST, &item.post),
        (Method::PATCH, &item.patch),
        (Method::DELETE, &item.delete),
    ];
    all.into_iter()
        .filter_map(|(method, operation)| operation.as_ref().map(|operation| (method, operation)))
}

fn in_query(operation: &Operation) -> Vec<String> {
    let all = operation.parameters.iter().flatten();
    let own = all.filter_map(|parameter| match parameter {
        RefOr::T(parameter) => Some(parameter),
        RefOr::Ref(_) => None,
    });
    own.filter(|parameter| parameter.parameter_in == ParameterIn::Query)
        .map(|parameter| parameter.name.clone())
        .collect()
}

pub async fn check(
    State(known): State<Known>,
    matched: MatchedPath,
    request: Request,
    next: Next,
) -> Response {
    let route = (request.method().clone(), matched.as_str().to_owned());
    let query = request.uri().query().unwrap_or_default();
    if let Some(names) = known.get(&route)
        && let Err(problem) = only(names, query)
    {
        return problem.into_response();
    }
    next.run(request).await
}

/// Whether a query has no other names than these.
pub fn only(names: &[String], query: &str) -> Result<(), Problem> {
    let mut pairs = form_urlencoded::parse(query.as_bytes());
    let Some((stranger, _)) = pairs.find(|(name, _)| !names.iter().any(|known| known == name))
    else {
        return Ok(());
    };
    let stranger: String = stranger.chars().take(SHOWN).collect();
    let expected = match names {
        [] => "none".to_owned(),
        names => format!("`{}`", names.join("`, `")),
    };
    let detail = format!("unknown parameter `{stranger}`, expected {expected}");
    Err(Problem::new(Kind::BadRequest, detail))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strangers_are_named_with_those_that_are_known() {
        let names = ["name".to_owned(), "limit".to_owned()];
        for query in ["", "name=k&limit=2", "limit=&name=x%26naem=k", "&&"] {
            assert!(only(&names, query).is_ok(), "{query}");
        }
        let detail = |names, query| only(names, query).err().map(|problem| problem.detail);
        let expected = "unknown parameter `naem`, expected `name`, `limit`";
        for query in ["naem=k", "name=k&naem", "na%65m=k"] {
            assert_eq!(detail(&names, query).as_deref(), Some(expected));
        }
        let none = detail(&[], "name=k");
        assert_eq!(
            none.as_deref(),
            Some("unknown parameter `name`, expected none")
        );
    }
}
