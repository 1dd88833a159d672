use clap::Args;

use crate::built::NotBuilt;
use crate::webhooks::{self, Targets};

/// Where webhooks may go.
#[derive(Args, Clone)]
pub struct WebhookOptions {
    /// Host to which webhooks may be sent, as in its address; comma-separated or given several times.
    #[arg(
        long = "webhook-allow",
        env = "VELOID_WEBHOOK_ALLOW",
        value_name = "HOST",
        value_delimiter = ','
    )]
    hosts: Vec<String>,
    /// Allow webhooks to this machine and private networks too, and without TLS.
    #[arg(long = "webhook-private", env = "VELOID_WEBHOOK_PRIVATE")]
    private: bool,
}

impl WebhookOptions {
    pub fn targets(&self) -> Result<Targets, NotBuilt> {
        if !self.hosts.is_empty() || self.private {
            webhooks::built()?;
        }
        Ok(Targets::new(&self.hosts, self.private))
    }
}
