use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::time::Duration;

use clap::Args;

use super::CliError;

const PATIENCE: Duration = Duration::from_secs(4);

/// Checks whether the server or worker on this machine is ready: exit status 0 or 1.
#[derive(Args)]
pub struct Health {
    /// Address on which it listens.
    #[arg(long, env = "VELOID_LISTEN", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
}

impl Health {
    pub async fn run(mut self) -> Result<(), CliError> {
        if self.listen.ip().is_unspecified() {
            self.listen.set_ip(IpAddr::V4(Ipv4Addr::LOCALHOST));
        }
        let client = reqwest::Client::builder().timeout(PATIENCE).build()?;
        let address = format!("http://{}/readyz", self.listen);
        let answer = client.get(address).send().await?.error_for_status()?;
        print!("{}", answer.text().await?);
        Ok(())
    }
}
