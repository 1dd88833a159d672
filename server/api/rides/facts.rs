//! The facts of an upload, and those that are known of the same ride already.

use serde_json::{Map, Value};
use uuid::Uuid;

use crate::api::problem::Problem;
use crate::facts::{Facts, FactsError};
use crate::store::deletion::{self, Of};
use crate::store::{Tx, facts, job};

pub struct Given {
    pub of_file: Map<String, Value>,
    /// What the sender says goes before what stands in the file.
    pub given: Map<String, Value>,
}

impl Given {
    /// What is known of a ride that was not there.
    pub fn of_new(&self) -> Result<Facts, FactsError> {
        Facts::default()
            .patched(self.of_file.clone())?
            .patched(self.given.clone())
    }

    /// What is known of the ride of this file from now on; locks its jobs. The same file of a ride that is there says nothing new,
    /// and of one that is deleted nothing is left.
    pub async fn known(
        &self,
        tx: &mut Tx,
        group: &str,
        sha256: &str,
        name: &str,
    ) -> Result<Facts, Problem> {
        let Some(there) = facts::ride_of_file(tx, group, sha256, name).await? else {
            return Ok(self.of_new()?);
        };
        let jobs = Of::Ride(there);
        deletion::lock(tx, group, jobs).await?;
        if deletion::is_whole(tx, group, jobs).await? {
            return Ok(self.of_new()?);
        }
        let known = facts::of_ride(tx, there).await?;
        Ok(known.patched(self.given.clone())?)
    }

    /// Adds what the sender says to the ride of a job that is there.
    pub async fn add_to_job(&self, tx: &mut Tx, group: &str, id: Uuid) -> Result<(), Problem> {
        let Some(ride) = job::ride(tx, id).await?.filter(|_| !self.given.is_empty()) else {
            return Ok(());
        };
        deletion::lock(tx, group, Of::Ride(ride)).await?;
        let known = facts::of_ride(tx, ride).await?;
        facts::put(tx, ride, &known.patched(self.given.clone())?).await?;
        Ok(())
    }
}
