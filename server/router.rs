pub mod connection;
pub mod door;
pub mod headers;
pub mod security;
pub mod stay;
pub mod telemetry;
use std::any::Any;
use std::sync::Arc;

use axum::Router;
use axum::http::{HeaderMap, HeaderValue, Method, Uri, header};
use axum::middleware::{from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use utoipa::OpenApi;
use utoipa::openapi::OpenApi as Document;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::{Config, SwaggerUi};
use veloid_engine::report::ResultQuantity;
use veloid_engine::report::diagnosis::{Excerpt, Predicted, ResidualSpectrum, Surface};
use veloid_engine::report::dynamics::{ParameterErrors, Pole, StepInput, StepResponse};
use veloid_engine::report::model_on_ride::{
    FitOnRide, ParameterOnRide, SeriesOnRide, SpectrumOnRide,
};
use veloid_engine::report::simulation::{ActingEffect, Law, LawState, Pitch};
use veloid_engine::report::validation::{
    CorrelationTest, Distortion, ForceCurve, FrequencyResponse, ModelResponse, ResidualTests,
    Restoring, TestedInput,
};
use veloid_engine::report::windows::{EffectScore, PartLength, SetScore};

use crate::api::problem::{Kind, Problem};
use crate::api::{
    Server, audit, bikes, dependence, fleet, health, jobs, known, parameters, rides, studies,
    validations, webhooks,
};
use crate::facts;
use crate::pages;
use crate::pages::layout::Fault;
use crate::shorten::shortened;
use security::secured;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "veloid",
        description = "Identifies a bicycle's stiffness and damping from ride logs, with their \
                       uncertainty, and the physics that the model leaves out. Units are SI and \
                       part of the names. Errors are RFC 9457 problems with a stable `type`.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
    ),
    // What only stands inside of a generic type is not found by itself.
    components(schemas(ActingEffect, Excerpt, Law, LawState, Pitch, Predicted, ResidualSpectrum, EffectScore, PartLength, ResultQuantity, SetScore, Surface,
        ParameterErrors, Pole, StepInput, StepResponse, CorrelationTest, Distortion, ForceCurve, FrequencyResponse, ModelResponse, ResidualTests, Restoring, TestedInput,
        FitOnRide, ParameterOnRide, SeriesOnRide, SpectrumOnRide)),
    tags(
        (name = "rides", description = "Upload and fetch rides"),
        (name = "jobs", description = "Follow, cancel and retry identifications; fetch their results"),
        (name = "fleet", description = "Bicycles and everything identified about them"),
        (name = "operations", description = "For operators"),
    )
)]
struct Base;

fn routes() -> OpenApiRouter<Arc<Server>> {
    OpenApiRouter::with_openapi(Base::openapi())
        .routes(routes!(rides::upload::upload))
        .routes(routes!(rides::refused::list))
        .routes(routes!(rides::preview::preview))
        .routes(routes!(rides::preview_bike::preview_bike))
        .routes(routes!(
            rides::get::get,
            rides::patch::patch,
            rides::delete::delete
        ))
        .routes(routes!(rides::restore::restore))
        .routes(routes!(rides::file::file))
        .routes(routes!(jobs::list::list))
        .routes(routes!(jobs::get::get, jobs::cancel::cancel))
        .routes(routes!(jobs::retry::retry))
        .routes(routes!(jobs::trials::trials))
        .routes(routes!(jobs::report::report))
        .routes(routes!(jobs::model::model))
        .routes(routes!(jobs::series::series))
        .routes(routes!(jobs::events::events))
        .routes(routes!(validations::create))
        .routes(routes!(studies::create))
        .routes(routes!(bikes::list::list))
        .routes(routes!(bikes::get::get, bikes::delete::delete))
        .routes(routes!(bikes::restore::restore))
        .routes(routes!(bikes::history::history))
        .routes(routes!(bikes::course::course))
        .routes(routes!(bikes::proposals::list))
        .routes(routes!(
            bikes::events::list::list,
            bikes::events::create::create
        ))
        .routes(routes!(bikes::events::delete::delete))
        .routes(routes!(fleet::fleet))
        .routes(routes!(fleet::effect))
        .routes(routes!(dependence::dependence))
        .routes(routes!(parameters::list))
        .routes(routes!(audit::list))
        .routes(routes!(webhooks::list::list, webhooks::create::create))
        .routes(routes!(webhooks::delete::delete))
        .routes(routes!(webhooks::test::test))
        .routes(routes!(health::healthz))
        .routes(routes!(health::readyz))
        .routes(routes!(health::metrics))
}

/// The document with what no derived schema knows.
fn complete(mut document: Document) -> Document {
    secured(&mut document);
    facts::bounded(&mut document);
    document
}

/// The OpenAPI document.
pub fn document() -> Document {
    complete(routes().into_openapi())
}

/// The whole service.
pub fn router(server: Arc<Server>) -> Router {
    let (router, document) = routes().split_for_parts();
    let document = complete(document);
    let known = known::of(&document);
    // Shared: what a handler holds is cloned for every connection.
    let document = Arc::new(document);
    let openapi = move || {
        let document = Arc::clone(&document);
        async move { axum::Json(&*document).into_response() }
    };
    let swagger = SwaggerUi::new("/docs").config(Config::from("/openapi.json"));
    router
        .route_layer(from_fn_with_state(known, known::check))
        .merge(pages::routes())
        .route("/openapi.json", get(openapi))
        .with_state(Arc::clone(&server))
        .merge(swagger)
        .fallback(not_found)
        .method_not_allowed_fallback(method_not_allowed)
        .layer(from_fn_with_state(server, door::enter))
        .layer(from_fn(connection::sound))
        .layer(CompressionLayer::new())
        .layer(CatchPanicLayer::custom(panicked))
        .layer(from_fn(headers::protect))
        .layer(from_fn(telemetry::measure))
}

async fn not_found(uri: Uri, headers: HeaderMap) -> Response {
    readable(&headers, Problem::not_found(&shortened(uri.path())))
}

async fn method_not_allowed(method: Method, uri: Uri, headers: HeaderMap) -> Response {
    let (path, method) = (shortened(uri.path()), shortened(method.as_str()));
    let detail = format!("{path} does not support {method}");
    readable(&headers, Problem::new(Kind::MethodNotAllowed, detail))
}

/// A problem as a page for browsers, as JSON for programs.
fn readable(headers: &HeaderMap, problem: Problem) -> Response {
    let accept = headers.get(header::ACCEPT).map(HeaderValue::as_bytes);
    let accept = String::from_utf8_lossy(accept.unwrap_or_default());
    match accept.contains("text/html") {
        true => Fault(problem).into_response(),
        false => problem.into_response(),
    }
}

fn panicked(panic: Box<dyn Any + Send + 'static>) -> Response {
    let cause = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no message");
    Problem::internal(format!("panic: {cause}")).into_response()
}
