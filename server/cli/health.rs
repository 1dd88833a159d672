use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::time::Duration;

use clap::Args;

use super::CliError;
use super::client::Client;

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
        let (client, address) = (Client::new(), format!("http://{}/readyz", self.listen));
        let answer = tokio::time::timeout(PATIENCE, client.get(&address)).await;
        let answer = answer.map_err(|_| {
            CliError::NotReady(format!("no answer within {} s", PATIENCE.as_secs()))
        })??;
        let said = String::from_utf8_lossy(&answer.body);
        match answer.status.is_success() {
            true => print!("{said}"),
            false => {
                let said = format!("{}: {}", answer.status, said.trim_end());
                return Err(CliError::NotReady(said));
            }
        }
        Ok(())
    }
}
