//! sqlx 0.9.0 leaves Nagle's algorithm on (github.com/transact-rs/sqlx, issue 4335, mended by pull request
//! 4336, which no release has yet): the end of a document then waits 40 ms for PostgreSQL's delayed
//! acknowledgement. It does not give its sockets away either, so they are found among this process's own.

use std::io;
use std::net::SocketAddr;
use std::os::fd::OwnedFd;
use std::sync::Once;

use rustix::io::Errno;
use rustix::net::{getpeername, sockopt};
use rustix::process::{PidfdFlags, PidfdGetfdFlags, getpid, pidfd_getfd, pidfd_open};

static TOLD: Once = Once::new();

/// Lets what goes to `port` leave at once; says so once where the system does not allow it.
pub fn send_at_once(port: u16) {
    if let Err(error) = try_send_at_once(port) {
        TOLD.call_once(|| {
            tracing::warn!(%error, "sending documents to PostgreSQL may take 40 ms longer (TCP_NODELAY)");
        });
    }
}

fn try_send_at_once(port: u16) -> io::Result<()> {
    let own = pidfd_open(getpid(), PidfdFlags::empty())?;
    for entry in std::fs::read_dir("/proc/self/fd")? {
        let path = entry?.path();
        // A copy of a file would give its locks up when it is closed.
        let is_socket = std::fs::read_link(&path)
            .is_ok_and(|target| target.to_string_lossy().starts_with("socket:"));
        let number = path
            .file_name()
            .and_then(|name| name.to_str()?.parse().ok());
        let Some(number) = number.filter(|_| is_socket) else {
            continue;
        };
        match pidfd_getfd(&own, number, PidfdGetfdFlags::empty()) {
            Ok(socket) if leads_to(&socket, port) => sockopt::set_tcp_nodelay(&socket, true)?,
            // Closed meanwhile.
            Ok(_) | Err(Errno::BADF) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

fn leads_to(socket: &OwnedFd, port: u16) -> bool {
    let peer = getpeername(socket).ok().flatten();
    peer.is_some_and(|peer| SocketAddr::try_from(peer).is_ok_and(|peer| peer.port() == port))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::net::{TcpListener, TcpStream};

    use super::*;

    #[test]
    fn sockets_to_the_port_send_at_once_and_others_as_before() {
        let listeners = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").unwrap());
        let addresses = listeners.each_ref().map(|l| l.local_addr().unwrap());
        let streams = addresses.map(|address| TcpStream::connect(address).unwrap());
        assert!(!streams[0].nodelay().unwrap());
        try_send_at_once(addresses[0].port()).unwrap();
        assert!(streams[0].nodelay().unwrap());
        assert!(!streams[1].nodelay().unwrap());
    }
}
