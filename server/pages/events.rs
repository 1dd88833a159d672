//! The form on a bicycle's page that notes what was done to it, and the buttons that take that away.

use axum::Form;
use axum::extract::State;
use axum::response::Redirect;
use uuid::Uuid;

use super::layout::{Fault, Path};
use super::words;
use crate::api::access::Caller;
use crate::api::bikes::events::create::{NewBikeEvent, note};
use crate::api::bikes::events::delete;
use crate::api::{App, extract};

pub async fn create(
    State(server): App,
    caller: Caller,
    Path(bike): Path<String>,
    Form(new): Form<NewBikeEvent>,
) -> Result<Redirect, Fault> {
    let page = format!("{}#events", words::bike_page(&bike));
    note(&server, &caller, bike, &new).await?;
    Ok(Redirect::to(&page))
}

pub async fn delete(
    server: App,
    caller: Caller,
    Path((bike, id)): Path<(String, Uuid)>,
) -> Result<Redirect, Fault> {
    let page = format!("{}#events", words::bike_page(&bike));
    delete::delete(server, caller, extract::Path((bike, id))).await?;
    Ok(Redirect::to(&page))
}
