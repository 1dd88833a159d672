//! Rides after reading, so that the stages of a job do not each read the file again.

use std::sync::Arc;

use veloid_engine::ride::Ride;

use super::at_hand::{ALL, bytes};
use super::errand::Source;
use super::fault::Fault;
use super::readers::{Reader, Readers};
use super::seats::Purpose;
use crate::files::{Files, OnDisk};
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
    readers: Arc<Readers>,
    rides: Arc<Lru<Ride>>,
}

impl RideCache {
    pub fn new(db: Db, files: Files, readers: Arc<Readers>) -> Self {
        Self {
            db,
            files,
            readers,
            rides: Arc::new(Lru::new(CAPACITY).of_at_most(ALL, bytes)),
        }
    }

    /// The ride of a job, read as its request says.
    pub async fn get(&self, job: &JobRow) -> Result<Arc<Ride>, Fault> {
        let make = async || {
            let (reader, files) = self.open(job, Purpose::Job).await?;
            let sources = files.iter().map(|(source, _)| source.clone()).collect();
            reader.ride(sources, job.request.0.clone()).await
        };
        let key = key(&job.sha256, &job.ride_name, &job.request);
        self.rides.get(key, make).await
    }

    /// A reader for the files of a job's ride, when it is the group's turn, and the files, which lie there as long as what is
    /// beside them. Their checksums, which take time too, are compared within that turn.
    pub async fn open(
        &self,
        job: &JobRow,
        purpose: Purpose,
    ) -> Result<(Reader<'_>, Vec<(Source, OnDisk)>), Fault> {
        let rows = ride::files(&self.db, job.ride_id).await?;
        let bytes = rows.iter().map(|file| file.bytes.unsigned_abs()).sum();
        let reader = (self.readers.turn(&job.group_name, bytes, purpose)).await?;
        let mut files = Vec::new();
        for file in rows {
            let lies = self.files.on_disk(&file.sha256).await?;
            let source = Source::new(file.name, lies.path().to_owned());
            files.push((source, lies));
        }
        Ok((reader, files))
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
