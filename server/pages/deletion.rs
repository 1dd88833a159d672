//! The buttons that delete rides and bicycles and bring them back.

use axum::response::Redirect;
use uuid::Uuid;

use super::layout::{Fault, Path};
use super::words;
use crate::api::access::Caller;
use crate::api::{App, bikes, extract, rides};

const DELETED: &str = "/jobs?deleted=true";

pub async fn delete_ride(
    server: App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Redirect, Fault> {
    let _ = rides::delete::delete(server, caller, extract::Path(id)).await?;
    Ok(Redirect::to(DELETED))
}

pub async fn restore_ride(
    server: App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Redirect, Fault> {
    let _ = rides::restore::restore(server, caller, extract::Path(id)).await?;
    Ok(Redirect::to("/jobs"))
}

pub async fn delete_bike(
    server: App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Redirect, Fault> {
    let deleted = format!("{DELETED}&bike={}", words::query(&name));
    bikes::delete::delete(server, caller, extract::Path(name)).await?;
    Ok(Redirect::to(&deleted))
}

pub async fn restore_bike(
    server: App,
    caller: Caller,
    Path(name): Path<String>,
) -> Result<Redirect, Fault> {
    let page = words::bike_page(&name);
    let _ = bikes::restore::restore(server, caller, extract::Path(name)).await?;
    Ok(Redirect::to(&page))
}
