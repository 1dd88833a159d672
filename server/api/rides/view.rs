use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::api::Server;
use crate::api::jobs::view::JobView;
use crate::api::list::MOST;
use crate::api::problem::Problem;
use crate::facts::Facts;
use crate::store::ride::FileRow;
use crate::store::{job, ride};
use crate::time;

/// An uploaded ride.
#[derive(Serialize, ToSchema)]
pub struct RideView {
    pub id: Uuid,
    /// Name of the file as sent.
    pub name: String,
    /// SHA-256 of its file; for several files a combined value.
    pub sha256: String,
    pub bytes: i64,
    #[schema(format = DateTime)]
    pub uploaded_at: String,
    /// Facts about the ride.
    pub facts: Facts,
    /// When it was deleted, with its file and results.
    #[schema(format = DateTime)]
    pub deleted_at: Option<String>,
    /// When it will be erased; until then `POST /v1/rides/{id}/restore` restores it.
    #[schema(format = DateTime)]
    pub erased_after: Option<String>,
    /// Address of the bytes; for several files that of their list; null when the ride is deleted.
    pub file: Option<String>,
    /// Its files, in the order of the upload.
    pub files: Vec<FileView>,
    /// Its identifications, newest first; for a deleted ride those that were deleted with it.
    pub jobs: Vec<JobView>,
}

/// One of a ride's files.
#[derive(Serialize, ToSchema)]
pub struct FileView {
    pub name: String,
    pub sha256: String,
    pub bytes: i64,
    /// Address of the bytes.
    pub file: String,
}

/// The files of the ride `id`.
pub fn views(id: Uuid, files: Vec<FileRow>) -> Vec<FileView> {
    let several = files.len() > 1;
    let view = |file: FileRow| FileView {
        file: match several {
            true => format!("/v1/rides/{id}/file?{}", name_query(&file.name)),
            false => format!("/v1/rides/{id}/file"),
        },
        name: file.name,
        sha256: file.sha256,
        bytes: file.bytes,
    };
    files.into_iter().map(view).collect()
}

fn name_query(name: &str) -> String {
    let mut query = form_urlencoded::Serializer::new(String::new());
    query.append_pair("name", name).finish()
}

/// The group's ride, deleted or not, or the problem that there is none.
pub async fn find(server: &Server, group: &str, id: Uuid) -> Result<RideView, Problem> {
    let ride = ride::find(&server.db, group, id)
        .await?
        .ok_or_else(no_such_ride)?;
    let filter = job::Filter {
        group,
        ride: Some(id),
        deleted: ride.deleted_at.is_some(),
        ..job::Filter::default()
    };
    let jobs = job::page(&server.db, &filter, MOST).await?;
    let there = ride.deleted_at.is_none();
    let files = match there {
        true => ride::files(&server.db, id).await?,
        false => Vec::new(),
    };
    let end = ride.deleted_at.map(|at| at + server.policy.grace_ms);
    Ok(RideView {
        file: there.then(|| format!("/v1/rides/{id}/file")),
        files: views(id, files),
        id,
        name: ride.name,
        sha256: ride.sha256,
        bytes: ride.bytes,
        uploaded_at: time::text(ride.uploaded_at),
        facts: ride.facts.map(|json| json.0).unwrap_or_default(),
        deleted_at: ride.deleted_at.map(time::text),
        erased_after: end.map(time::text),
        jobs: jobs.into_iter().map(JobView::from).collect(),
    })
}

pub fn no_such_ride() -> Problem {
    Problem::not_found("the ride")
}
