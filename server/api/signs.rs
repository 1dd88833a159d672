//! What is known of the server's state.

use std::time::{Duration, Instant};

use tokio::sync::Mutex;

use super::problem::{Kind, Problem};

/// Why the server cannot work.
#[derive(Clone)]
pub struct NotReady {
    /// What anybody may hear.
    what: &'static str,
    /// What only operators hear.
    detail: String,
}

impl NotReady {
    pub fn new(what: &'static str, detail: impl ToString) -> Self {
        let detail = detail.to_string();
        tracing::warn!(what, detail, "not ready");
        Self { what, detail }
    }

    /// What the log has already.
    pub fn known(what: &'static str, detail: impl ToString) -> Self {
        let detail = detail.to_string();
        Self { what, detail }
    }

    pub fn to_strangers(&self) -> Problem {
        Problem::new(Kind::Unavailable, self.what)
    }

    pub fn to_operators(&self) -> Problem {
        Problem::new(Kind::Unavailable, format!("{}: {}", self.what, self.detail))
    }
}

/// How long an answer of /readyz holds: who asks more often learns no more, and costs nothing.
const HOLDS: Duration = Duration::from_secs(1);
/// Whether the server can work, as it was when it was looked at last.
#[derive(Default)]
pub struct Signs {
    last: Mutex<Option<(Instant, Result<(), NotReady>)>>,
}

impl Signs {
    /// What is known of late, or what `look` finds.
    pub async fn fresh(
        &self,
        look: impl Future<Output = Result<(), NotReady>>,
    ) -> Result<(), NotReady> {
        let mut last = self.last.lock().await;
        match &*last {
            Some((at, outcome)) if at.elapsed() < HOLDS => outcome.clone(),
            _ => {
                let outcome = look.await;
                *last = Some((Instant::now(), outcome.clone()));
                outcome
            }
        }
    }
}
