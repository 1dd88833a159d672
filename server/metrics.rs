//! What this process counts and measures, for Prometheus. A figure is listed from its first value on.

use std::fmt::{self, Write};
use std::sync::LazyLock;

use axum::extract::MatchedPath;
use prometheus_client::encoding::text::encode_registry;
use prometheus_client::encoding::{EncodeLabelValue, LabelValueEncoder};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::{Metric, Registry};

/// Buckets of the histograms.
const SECONDS: [f64; 9] = [0.001, 0.005, 0.02, 0.1, 0.5, 2.0, 10.0, 60.0, 300.0];
const BYTES: [f64; 6] = [1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

type Labels = Vec<(&'static str, Label)>;

/// The value of a label, from a set that the program fixes: each one is kept as long as the process lives.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Label {
    Word(&'static str),
    Status(u16),
    /// The pattern of a route.
    Route(String),
}

impl From<&'static str> for Label {
    fn from(word: &'static str) -> Self {
        Self::Word(word)
    }
}

impl From<MatchedPath> for Label {
    fn from(path: MatchedPath) -> Self {
        Self::Route(path.as_str().to_owned())
    }
}

impl EncodeLabelValue for Label {
    fn encode(&self, encoder: &mut LabelValueEncoder) -> fmt::Result {
        match self {
            Self::Word(word) => encoder.write_str(word),
            Self::Status(status) => write!(encoder, "{status}"),
            Self::Route(pattern) => encoder.write_str(pattern),
        }
    }
}

/// A count by labels.
pub struct Counts(Family<Labels, Counter>);

impl Counts {
    pub fn add<const N: usize>(&self, count: u64, labels: [(&'static str, Label); N]) {
        self.0.get_or_create(&labels.to_vec()).inc_by(count);
    }
}

/// A number by labels, which falls as well as it rises.
pub struct Level(Family<Labels, Gauge>);

impl Level {
    pub fn set<const N: usize>(&self, level: i64, labels: [(&'static str, Label); N]) {
        self.0.get_or_create(&labels.to_vec()).set(level);
    }

    pub fn change(&self, by: i64) {
        self.0.get_or_create(&Labels::new()).inc_by(by);
    }
}

/// How values are spread, by labels.
pub struct Spread(Family<Labels, Histogram>);

impl Spread {
    fn of(registry: &mut Registry, name: &str, empty: fn() -> Histogram) -> Self {
        let family = Family::new_with_constructor(empty);
        registry.register(name, "", family.clone());
        Self(family)
    }

    pub fn record<const N: usize>(&self, value: f64, labels: [(&'static str, Label); N]) {
        self.0.get_or_create(&labels.to_vec()).observe(value);
    }
}

pub struct Metrics {
    registry: Registry,
    pub jobs: Level,
    pub workers: Level,
    pub build: Level,
    pub listeners: Level,
    pub requests: Spread,
    pub uploads: Counts,
    pub upload_sizes: Spread,
    pub refused: Counts,
    pub connections_refused: Counts,
    pub answers_cut: Counts,
    pub rescues: Counts,
    pub stale_completions: Counts,
}

/// Those of this process.
pub static METRICS: LazyLock<Metrics> = LazyLock::new(Metrics::new);

impl Metrics {
    fn new() -> Self {
        let mut registry = Registry::default();
        let r = &mut registry;
        Self {
            jobs: Level(known(r, "veloid_jobs")),
            workers: Level(known(r, "veloid_workers")),
            build: Level(known(r, "veloid_build_info")),
            listeners: Level(known(r, "veloid_sse_clients")),
            requests: Spread::of(r, "veloid_http_request_duration_seconds", || {
                Histogram::new(SECONDS)
            }),
            uploads: Counts(known(r, "veloid_uploads")),
            upload_sizes: Spread::of(r, "veloid_upload_size_bytes", || Histogram::new(BYTES)),
            refused: Counts(known(r, "veloid_refused")),
            connections_refused: Counts(known(r, "veloid_connections_refused")),
            answers_cut: Counts(known(r, "veloid_answers_cut")),
            rescues: Counts(known(r, "veloid_job_rescues")),
            stale_completions: Counts(known(r, "veloid_stale_completions")),
            registry,
        }
    }

    /// All of them in Prometheus's text format.
    pub fn render(&self) -> String {
        let mut text = String::new();
        // Writing to memory cannot fail.
        let _ = encode_registry(&mut text, &self.registry);
        text.lines().filter_map(classic).collect()
    }
}

fn known<M: Metric + Clone + Default>(registry: &mut Registry, name: &str) -> M {
    let metric = M::default();
    registry.register(name, "", metric.clone());
    metric
}

/// A line of OpenMetrics as version 0.0.4 of the text format has it: a counter's type is given under the name of its value,
/// and the limit of a bucket is written like any number. The names are all the help there is.
fn classic(line: &str) -> Option<String> {
    if line.starts_with("# HELP") {
        return None;
    }
    if let Some(counter) = line.strip_suffix(" counter") {
        return Some(format!("{counter}_total counter\n"));
    }
    let limit = line.split_once("le=\"").and_then(|(begin, rest)| {
        let (limit, rest) = rest.split_once(".0\"")?;
        let is_number = limit.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| format!("{begin}le=\"{limit}\"{rest}\n"))
    });
    Some(limit.unwrap_or_else(|| format!("{line}\n")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_written_as_the_text_format_has_it_from_their_first_value_on() {
        let metrics = Metrics::new();
        assert_eq!(metrics.render(), "");
        metrics.rescues.add(3, []);
        metrics.uploads.add(1, [("outcome", "accepted".into())]);
        metrics.jobs.set(2, [("state", "queued".into())]);
        metrics.listeners.change(1);
        metrics.listeners.change(-1);
        metrics.requests.record(0.25, [("route", "none".into())]);
        assert_eq!(
            metrics.render(),
            "# TYPE veloid_jobs gauge\n\
             veloid_jobs{state=\"queued\"} 2\n\
             # TYPE veloid_sse_clients gauge\n\
             veloid_sse_clients 0\n\
             # TYPE veloid_http_request_duration_seconds histogram\n\
             veloid_http_request_duration_seconds_sum{route=\"none\"} 0.25\n\
             veloid_http_request_duration_seconds_count{route=\"none\"} 1\n\
             veloid_http_request_duration_seconds_bucket{le=\"0.001\",route=\"none\"} 0\n\
             veloid_http_request_duration_seconds_bucket{le=\"0.005\",route=\"none\"} 0\n\
             veloid_http_request_duration_seconds_bucket{le=\"0.02\",route=\"none\"} 0\n\
             veloid_http_request_duration_seconds_bucket{le=\"0.1\",route=\"none\"} 0\n\
             veloid_http_request_duration_seconds_bucket{le=\"0.5\",route=\"none\"} 1\n\
             veloid_http_request_duration_seconds_bucket{le=\"2\",route=\"none\"} 1\n\
             veloid_http_request_duration_seconds_bucket{le=\"10\",route=\"none\"} 1\n\
             veloid_http_request_duration_seconds_bucket{le=\"60\",route=\"none\"} 1\n\
             veloid_http_request_duration_seconds_bucket{le=\"300\",route=\"none\"} 1\n\
             veloid_http_request_duration_seconds_bucket{le=\"+Inf\",route=\"none\"} 1\n\
             # TYPE veloid_uploads_total counter\n\
             veloid_uploads_total{outcome=\"accepted\"} 1\n\
             # TYPE veloid_job_rescues_total counter\n\
             veloid_job_rescues_total 3\n"
        );
    }
}
