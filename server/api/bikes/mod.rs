pub mod course;
pub mod delete;
pub mod events;
pub mod get;
pub mod history;
pub mod list;
pub mod proposals;
pub mod restore;
pub mod view;

use super::Server;
use super::problem::Problem;
use crate::store::bike::{self, BikeRow};

/// A bicycle of the group; 404 where it has none of this name.
pub async fn existing(server: &Server, group: &str, name: &str) -> Result<BikeRow, Problem> {
    // No name holds a NUL, and PostgreSQL refuses to be asked for one.
    let found = match name.contains('\0') {
        true => None,
        false => bike::find(&server.db, group, name).await?,
    };
    found.ok_or_else(|| Problem::not_found("the bike"))
}
