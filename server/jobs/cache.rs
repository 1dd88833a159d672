//! Rides after reading, so that the stages of a job do not each read the file again.

use std::sync::Arc;

use tokio::task::JoinError;
use veloid_engine::ride::{ReadError, Ride, RideFile};

use super::fault::Fault;
use crate::files::Files;
use crate::lru::Lru;
use crate::store::job::{JobRow, Request};
use crate::store::{Db, ride};

/// Rides kept. A 60 s ride at 500 Hz is 2 MB.
const CAPACITY: usize = 16;

/// The rides that were read last.
#[derive(Clone)]
pub struct RideCache {
    db: Db,
    files: Files,
    rides: Arc<Lru<Ride>>,
}

impl RideCache {
    pub fn new(db: Db, files: Files) -> Self {
        Self {
            db,
            files,
            rides: Arc::new(Lru::new(CAPACITY)),
        }
    }

    /// The ride of a job, read as its request says.
    pub async fn get(&self, job: &JobRow) -> Result<Arc<Ride>, Fault> {
        let make = async || {
            let mut files = Vec::new();
            for file in ride::files(&self.db, job.ride_id).await? {
                let bytes = self.files.read(&file.sha256).await?;
                files.push((file.name, bytes));
            }
            Ok(read(files, job.request.0.clone()).await??)
        };
        let key = key(&job.sha256, &job.ride_name, &job.request);
        self.rides.get(key, make).await
    }

    /// Keeps a ride that was read while it was uploaded.
    pub fn put(&self, sha256: &str, name: &str, request: &Request, ride: Arc<Ride>) {
        self.rides.put(key(sha256, name, request), ride);
    }
}

/// The bytes, how to read them, and the bike, whose geometry may delay the rear road.
fn key(sha256: &str, name: &str, request: &Request) -> String {
    let how = serde_json::json!([name, request.options.reading, request.bike]);
    format!("{sha256} {how}")
}

/// Reads a ride off the async threads, of files that are each a name and bytes.
pub async fn read(
    files: Vec<(String, Vec<u8>)>,
    request: Request,
) -> Result<Result<Ride, ReadError>, JoinError> {
    tokio::task::spawn_blocking(move || {
        let files: Vec<RideFile<'_>> = named(&files).collect();
        veloid_engine::read(&files, &request.bike, &request.options.reading)
    })
    .await
}

/// The files as the engine takes them.
pub fn named(files: &[(String, Vec<u8>)]) -> impl Iterator<Item = RideFile<'_>> {
    files.iter().map(|(name, bytes)| RideFile::new(name, bytes))
}
