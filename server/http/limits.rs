use std::time::Duration;

use clap::Args;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use super::account::Pace;

/// Descriptors of this process besides connections: files, database, listener.
const OTHERS: u64 = 256;

/// What strangers may hold open, and for how long.
#[derive(Args, Clone, Copy, Debug)]
pub struct HttpLimits {
    /// Simultaneous connections. Beyond this limit, idle ones are closed.
    #[arg(long, env = "VELOID_CONNECTIONS", default_value_t = 2048, value_parser = count)]
    pub connections: usize,
    /// Simultaneous connections of one address; by default half of all. Behind a proxy, which is the only address: as many as
    /// in total.
    #[arg(long, env = "VELOID_CONNECTIONS_PER_ADDRESS", value_parser = count)]
    pub connections_per_address: Option<usize>,
    /// Time in which the head of a request must arrive, and for which a connection may be idle (s): with a much shorter time,
    /// clients that keep their connections find them closed.
    #[arg(long, env = "VELOID_HEADER_TIMEOUT", default_value_t = 60, value_parser = seconds)]
    header_timeout: u64,
    /// Time in which more of a request's body must arrive (s).
    #[arg(long, env = "VELOID_BODY_TIMEOUT", default_value_t = 30, value_parser = seconds)]
    body_timeout: u64,
    /// Minimum rate of a request's body, once the server has waited for it for `--body-timeout` (bytes/s); 0 allows any rate.
    #[arg(long, env = "VELOID_BODY_RATE", default_value_t = 1000)]
    body_rate: u64,
    /// Time in which the client must read more of an answer (s).
    #[arg(long, env = "VELOID_ANSWER_TIMEOUT", default_value_t = 60, value_parser = seconds)]
    answer_timeout: u64,
    /// Minimum rate at which the client must read an answer, once the server has waited for it for `--answer-timeout`
    /// (bytes/s); 0 allows any rate.
    #[arg(long, env = "VELOID_ANSWER_RATE", default_value_t = 1000)]
    answer_rate: u64,
}

fn count(text: &str) -> Result<usize, String> {
    ranged(text, 1..=1_000_000).map(|count| count as usize)
}

fn seconds(text: &str) -> Result<u64, String> {
    ranged(text, 1..=86_400)
}

fn ranged(text: &str, range: std::ops::RangeInclusive<u64>) -> Result<u64, String> {
    let number = text.parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| format!("expected {} to {}", range.start(), range.end()))
}

#[cfg(test)]
impl Default for HttpLimits {
    fn default() -> Self {
        Self {
            connections: 2048,
            connections_per_address: None,
            header_timeout: 60,
            body_timeout: 30,
            body_rate: 1000,
            answer_timeout: 60,
            answer_rate: 1000,
        }
    }
}

impl HttpLimits {
    pub fn per_address(&self) -> usize {
        let half = (self.connections / 2).max(1);
        self.connections_per_address.unwrap_or(half)
    }

    pub fn header_timeout(&self) -> Duration {
        Duration::from_secs(self.header_timeout)
    }

    /// How fast a request's body has to come.
    pub fn body(&self) -> Pace {
        Pace {
            idle: Duration::from_secs(self.body_timeout),
            rate: self.body_rate,
        }
    }

    /// How fast an answer has to be taken.
    pub fn answer(&self) -> Pace {
        Pace {
            idle: Duration::from_secs(self.answer_timeout),
            rate: self.answer_rate,
        }
    }

    /// The limits that this process can keep: asks the system for as many descriptors as they need, and
    /// keeps to what it grants.
    pub fn granted(mut self) -> Self {
        let needed = self.connections as u64 + OTHERS;
        let limit = getrlimit(Resource::Nofile);
        if limit.current.is_none_or(|current| current >= needed) {
            return self;
        }
        let wanted = limit.maximum.map_or(needed, |most| most.min(needed));
        let raised = Rlimit {
            current: Some(wanted),
            maximum: limit.maximum,
        };
        let granted = match setrlimit(Resource::Nofile, raised) {
            Ok(()) => wanted,
            Err(_) => limit.current.unwrap_or(wanted),
        };
        if granted < needed {
            let connections = granted.saturating_sub(OTHERS).max(1) as usize;
            tracing::warn!(
                asked = self.connections,
                connections,
                descriptors = granted,
                "the system allows too few file descriptors for this many connections"
            );
            self.connections = connections;
        }
        self
    }
}
