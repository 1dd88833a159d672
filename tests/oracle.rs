//! What must hold of an upload whatever happened to the processes that worked on it.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::harness::{Server, form};
use crate::ride;

/// A ride that is sent until it is acknowledged, under one idempotency key.
pub struct Upload {
    ride: Vec<u8>,
    parts: Vec<(String, String)>,
    key: String,
}

/// What a server that nothing happens to makes of an upload.
pub struct Undisturbed {
    /// From sending the ride to the end of its job.
    pub took: Duration,
    report: String,
    parameters: BTreeSet<String>,
}

impl Upload {
    /// Ten seconds of ride with quick settings and these parts.
    pub fn new(key: impl ToString, parts: &[(&str, &str)]) -> Self {
        let parts = ride::QUICK.iter().chain(parts);
        Self {
            ride: ride::table(1000, 100.0).into_bytes(),
            parts: parts
                .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()))
                .collect(),
            key: key.to_string(),
        }
    }

    /// Sends the ride; the address of its job, or none where no answer came.
    pub async fn send(&self, server: &Server) -> Option<String> {
        let parts: Vec<_> = (self.parts.iter())
            .map(|(key, value)| (key.as_str(), value.as_str()))
            .collect();
        let form = form(self.ride.clone(), ride::BIKE, &parts);
        let request = server.client.post(server.address("/v1/rides"));
        let request = request.header("Idempotency-Key", &self.key).multipart(form);
        let response = request.send().await.ok()?;
        let (status, location) = (
            response.status(),
            response.headers().get("location").cloned(),
        );
        // The process may die between head and body; the promise is given with the head.
        let body = response.text().await.unwrap_or_default();
        assert_eq!(status, 202, "{body}");
        Some(location.unwrap().to_str().unwrap().to_owned())
    }

    /// Sends the ride again to a server that was started anew: it must be the job that was
    /// acknowledged, if one was.
    pub async fn send_again(&self, server: &Server, acknowledged: Option<&str>) -> String {
        let job = self.send(server).await.expect("an answer");
        if let Some(acknowledged) = acknowledged {
            assert_eq!(job, acknowledged, "the acknowledged job");
        }
        job
    }

    pub async fn undisturbed(&self) -> Undisturbed {
        let server = Server::on_sqlite(&[]);
        let begin = Instant::now();
        let job = self.send(&server).await.unwrap();
        server.succeeded(&job).await;
        Undisturbed {
            took: begin.elapsed(),
            report: server.json(&format!("{job}/report")).await.to_string(),
            parameters: parameters(&server, &job).await.into_iter().collect(),
        }
    }

    /// The job has succeeded, once, with the report of a job that nothing happened to.
    pub async fn succeeded_once(&self, server: &Server, job: &str, expected: &Undisturbed) {
        let view = server.succeeded(job).await;
        let report = server.json(&format!("{job}/report")).await;
        assert_eq!(
            report.to_string(),
            expected.report,
            "the report of an undisturbed job"
        );
        let trials = server.json(&format!("{job}/trials")).await;
        let trials = trials["items"].as_array().unwrap();
        assert_eq!(view["trials"]["total"], trials.len());
        assert!(
            trials.iter().all(|trial| trial["result"].is_object()),
            "{trials:?}"
        );
        let found = parameters(server, job).await;
        assert_eq!(
            found.len(),
            expected.parameters.len(),
            "each parameter once in the fleet"
        );
        assert_eq!(
            found.into_iter().collect::<BTreeSet<_>>(),
            expected.parameters
        );
        self.is_kept(server, &view).await;
    }

    /// The job was cancelled: it has neither report nor a place in the fleet, but its ride is kept.
    pub async fn cancelled_once(&self, server: &Server, job: &str) {
        let view = server.json(job).await;
        assert_eq!(view["state"], "cancelled");
        assert_eq!(server.get(&format!("{job}/report")).await.status(), 409);
        assert_eq!(parameters(server, job).await, [] as [String; 0]);
        self.is_kept(server, &view).await;
    }

    /// The bytes that were sent are those that are kept.
    async fn is_kept(&self, server: &Server, view: &Value) {
        let file = format!("/v1/rides/{}/file", view["ride"]["id"].as_str().unwrap());
        let kept = server.get(&file).await.bytes().await.unwrap();
        assert_eq!(Sha256::digest(kept), Sha256::digest(&self.ride));
    }
}

/// The fleet's parameters of a job, every entry by itself.
async fn parameters(server: &Server, job: &str) -> Vec<String> {
    let id = job.rsplit('/').next().unwrap();
    let page = server
        .json(&format!("/v1/parameters?job={id}&limit=1000"))
        .await;
    assert!(page["next"].is_null());
    let text = |item: &Value| {
        ["method", "axle", "name", "value"]
            .map(|field| item[field].to_string())
            .join(" ")
    };
    page["items"].as_array().unwrap().iter().map(text).collect()
}

/// No piece of work was published more than once, or begun while another attempt of it held it;
/// nothing is left of it in the queue. Not for jobs that were begun anew by their user.
pub async fn nothing_ran_twice(server: &Server) {
    let twice = "SELECT COUNT(*) FROM (SELECT kind, args FROM river_job WHERE state = 'completed' \
                 GROUP BY kind, args HAVING COUNT(*) > 1) AS twice";
    assert_eq!(
        server.count(twice).await,
        0,
        "work that was published twice"
    );
    let at_once = "SELECT COUNT(*) FROM (SELECT kind, args FROM river_job \
                       GROUP BY kind, args HAVING COUNT(*) > 1) AS again \
                   JOIN river_job AS one ON one.kind = again.kind AND one.args = again.args \
                   JOIN river_job AS other ON other.kind = again.kind AND other.args = again.args \
                   WHERE one.id < other.id \
                     AND (one.finalized_at IS NULL OR other.attempted_at < one.finalized_at)";
    assert_eq!(server.count(at_once).await, 0, "work that two held at once");
    nothing_is_left(server).await;
}

/// The queue comes to hold nothing that is still to be done; a lease may have to end first.
pub async fn nothing_is_left(server: &Server) {
    let left =
        "SELECT COUNT(*) FROM river_job WHERE state NOT IN ('completed', 'cancelled', 'discarded')";
    for _ in 0..1200 {
        if server.count(left).await == 0 {
            return;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    panic!("work is left in the queue");
}

/// The server knows so many jobs.
pub async fn jobs_are(server: &Server, count: i64) {
    assert_eq!(
        server.count("SELECT COUNT(*) FROM job").await,
        count,
        "one job per upload"
    );
}
