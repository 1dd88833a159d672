//! Rides after reading, so that the stages of a job do not each read the file again.

use std::sync::Arc;

use tokio::task::JoinError;
use veloid_engine::ride::{self, ReadError, Ride};

use super::fault::Fault;
use crate::files::Files;
use crate::lru::Lru;
use crate::store::job::Request;

/// Rides kept. A 60 s ride at 500 Hz is 2 MB.
const CAPACITY: usize = 16;

/// The rides that were read last.
#[derive(Clone)]
pub struct RideCache {
    files: Files,
    rides: Arc<Lru<Ride>>,
}

impl RideCache {
    pub fn new(files: Files) -> Self {
        Self {
            files,
            rides: Arc::new(Lru::new(CAPACITY)),
        }
    }

    /// The ride of these bytes, read as the request says.
    pub async fn get(
        &self,
        sha256: &str,
        name: &str,
        request: &Request,
    ) -> Result<Arc<Ride>, Fault> {
        let make = async || {
            let bytes = self.files.read(sha256).await?;
            Ok(read(bytes, name.to_owned(), request.clone()).await??)
        };
        self.rides.get(key(sha256, request), make).await
    }

    /// Keeps a ride that was read while it was uploaded.
    pub fn put(&self, sha256: &str, request: &Request, ride: Arc<Ride>) {
        self.rides.put(key(sha256, request), ride);
    }
}

/// The bytes, how to read them, and the bike, whose geometry may delay the rear road.
fn key(sha256: &str, request: &Request) -> String {
    let how = serde_json::json!([request.options.reading, request.bike]);
    format!("{sha256} {how}")
}

/// Reads a ride off the async threads.
pub async fn read(
    bytes: Vec<u8>,
    name: String,
    request: Request,
) -> Result<Result<Ride, ReadError>, JoinError> {
    tokio::task::spawn_blocking(move || {
        ride::read(&bytes, &name, &request.bike, &request.options.reading)
    })
    .await
}
