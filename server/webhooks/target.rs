//! Where webhooks may go. The operator names the hosts; what they resolve to is looked at again at each delivery, and the
//! connection is made to the very addresses that were looked at.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use url::{Host, Url};

use crate::unique::shown;

/// Longest address (characters).
const LONGEST: usize = 2000;

/// Where webhooks may go.
#[derive(Clone, Debug, Default)]
pub struct Targets {
    hosts: Vec<String>,
    /// Also to addresses of this machine and of networks that are not the internet, and without TLS.
    private: bool,
}

#[derive(Debug, thiserror::Error)]
pub enum TargetError {
    #[error("url: '{0}', expected an address such as https://example.org/hook")]
    Url(String),
    #[error("url: {0} characters, expected at most {LONGEST}")]
    Long(usize),
    #[error("url: '{0}' is not encrypted, expected https")]
    Scheme(String),
    #[error("url: it contains a name or a password, expected none")]
    Credentials,
    #[error(
        "url: the host '{0}' is not allowed here; the server's operator can allow hosts with `--webhook-allow`"
    )]
    Host(String),
    #[error(
        "{0} is {1}, which is not a public address; the server's operator can allow such addresses with `--webhook-private`"
    )]
    Private(String, IpAddr),
    #[error("{0} cannot be found: {1}")]
    Unknown(String, std::io::Error),
    #[error("{0} has no address")]
    NoAddress(String),
}

impl TargetError {
    /// Whether this is an address that the operator does not allow, rather than none.
    pub fn is_forbidden(&self) -> bool {
        matches!(self, Self::Scheme(_) | Self::Host(_) | Self::Private(..))
    }

    /// Whether the name leads nowhere.
    pub fn is_unknown(&self) -> bool {
        matches!(self, Self::Unknown(..) | Self::NoAddress(_))
    }
}

impl Targets {
    pub fn new(hosts: &[String], private: bool) -> Self {
        let hosts = hosts
            .iter()
            .map(|host| host.trim().trim_end_matches('.').to_ascii_lowercase());
        Self {
            hosts: hosts.filter(|host| !host.is_empty()).collect(),
            private,
        }
    }

    /// Reads an address, and refuses one whose host is not allowed or is no public address.
    pub fn check(&self, text: &str) -> Result<Url, TargetError> {
        let length = text.chars().count();
        if length > LONGEST {
            return Err(TargetError::Long(length));
        }
        let url = Url::parse(text).map_err(|_| TargetError::Url(shown(text)))?;
        let host = url.host().ok_or_else(|| TargetError::Url(shown(text)))?;
        match url.scheme() {
            "https" => {}
            "http" if self.private => {}
            scheme => return Err(TargetError::Scheme(shown(scheme))),
        }
        if !url.username().is_empty() || url.password().is_some() {
            return Err(TargetError::Credentials);
        }
        let name = host.to_string();
        let bare = name.trim_matches(['[', ']']).trim_end_matches('.');
        if !self
            .hosts
            .iter()
            .any(|allowed| allowed.trim_matches(['[', ']']) == bare)
        {
            return Err(TargetError::Host(shown(&name)));
        }
        match host {
            Host::Ipv4(ip) => self.admit(&name, ip.into())?,
            Host::Ipv6(ip) => self.admit(&name, ip.into())?,
            Host::Domain(_) => {}
        }
        Ok(url)
    }

    /// The addresses of a host, all of which may be gone to.
    pub async fn resolve(&self, url: &Url) -> Result<Vec<SocketAddr>, TargetError> {
        let name = url.host_str().unwrap_or_default().to_owned();
        let port = url.port_or_known_default().unwrap_or(443);
        let bare = name.trim_matches(['[', ']']);
        let found = tokio::net::lookup_host((bare, port)).await;
        let found: Vec<SocketAddr> = found
            .map_err(|e| TargetError::Unknown(name.clone(), e))?
            .collect();
        for address in &found {
            self.admit(&name, address.ip())?;
        }
        match found.is_empty() {
            true => Err(TargetError::NoAddress(name)),
            false => Ok(found),
        }
    }

    fn admit(&self, name: &str, ip: IpAddr) -> Result<(), TargetError> {
        match self.private || is_public(ip) {
            true => Ok(()),
            false => Err(TargetError::Private(shown(name), ip)),
        }
    }
}

/// Whether an address is one of the internet's (IANA's registries of special-purpose addresses).
fn is_public(ip: IpAddr) -> bool {
    match ip {
        IpAddr::V4(ip) => is_public_v4(ip),
        IpAddr::V6(ip) => is_public_v6(ip),
    }
}

fn is_public_v4(ip: Ipv4Addr) -> bool {
    let [a, b, c, _] = ip.octets();
    let special = ip.is_private()
        || ip.is_loopback()
        || ip.is_link_local()
        || ip.is_multicast()
        || ip.is_documentation()
        // This network, carriers' own, protocol assignments, relays, benchmarks, and what is reserved.
        || a == 0
        || a == 100 && (64..128).contains(&b)
        || (a, b, c) == (192, 0, 0)
        || (a, b, c) == (192, 88, 99)
        || a == 198 && (18..20).contains(&b)
        || a >= 240;
    !special
}

/// Global unicast, less what leads to an address of version 4 or is documentation.
fn is_public_v6(ip: Ipv6Addr) -> bool {
    let [a, b, ..] = ip.segments();
    if let Some(mapped) = ip.to_ipv4_mapped() {
        return is_public_v4(mapped);
    }
    let special =
        (a == 0x2001 && b < 0x200) || (a, b) == (0x2001, 0xdb8) || a == 0x2002 || a == 0x3fff;
    (a & 0xe000) == 0x2000 && !special
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn targets(private: bool) -> Targets {
        let hosts = [
            "Hooks.Example.org.",
            "127.0.0.1",
            "localhost",
            "::1",
            "192.0.2.7",
            "8.8.8.8",
        ];
        Targets::new(&hosts.map(str::to_owned), private)
    }

    #[test]
    fn only_hosts_that_are_allowed_are_gone_to() {
        let fault = |url: &str| targets(false).check(url).err().map(|e| e.to_string());
        assert_eq!(fault("https://hooks.example.org/a?b=c"), None);
        assert_eq!(fault("https://HOOKS.example.org:8443/"), None);
        assert_eq!(fault("https://8.8.8.8/"), None);
        for (url, said) in [
            ("https://hooks.example.org.evil.net/", "is not allowed here"),
            ("https://evil.net/#hooks.example.org", "is not allowed here"),
            (
                "https://hooks.example.org@evil.net/",
                "a name or a password",
            ),
            ("http://hooks.example.org/", "not encrypted"),
            ("file:///etc/passwd", "expected"),
            ("ftp://hooks.example.org/", "not encrypted"),
            ("hooks.example.org", "expected an address"),
            // However it is written, it is an address of this machine.
            ("https://127.0.0.1/", "not a public address"),
            ("https://0x7f.1/", "not a public address"),
            ("https://2130706433/", "not a public address"),
            ("https://[::1]/", "not a public address"),
        ] {
            let fault = fault(url).unwrap_or_default();
            assert!(fault.contains(said), "{url}: {fault}");
        }
        let long = format!("https://hooks.example.org/{}", "x".repeat(2000));
        assert!(fault(&long).unwrap().contains("2026 characters"));
        assert!(targets(true).check("http://127.0.0.1:9/").is_ok());
        assert!(Targets::default().check("https://example.org/").is_err());
    }

    #[tokio::test]
    async fn what_a_name_resolves_to_is_looked_at() {
        let url = Url::parse("https://localhost:9/").unwrap();
        let refused = targets(false).resolve(&url).await.unwrap_err().to_string();
        assert!(refused.contains("not a public address"), "{refused}");
        assert!(!targets(true).resolve(&url).await.unwrap().is_empty());
    }

    #[test]
    fn addresses_of_no_internet_are_reported() {
        for ip in [
            "0.0.0.0",
            "10.1.2.3",
            "100.64.0.1",
            "127.8.8.8",
            "169.254.169.254",
            "172.16.0.1",
            "192.168.1.1",
            "192.0.0.8",
            "198.18.0.1",
            "203.0.113.5",
            "224.0.0.1",
            "255.255.255.255",
            "::",
            "::1",
            "fe80::1",
            "fc00::1",
            "fd12::3",
            "ff02::1",
            "::ffff:10.0.0.1",
            "::ffff:127.0.0.1",
            "::127.0.0.1",
            "64:ff9b::7f00:1",
            "2002:7f00:1::",
            "2001::1",
            "2001:db8::1",
        ] {
            assert!(!is_public(ip.parse().unwrap()), "{ip}");
        }
        for ip in [
            "8.8.8.8",
            "1.1.1.1",
            "172.32.0.1",
            "100.128.0.1",
            "2606:4700::1111",
            "2a00:1450:4001::8a",
            "::ffff:8.8.8.8",
        ] {
            assert!(is_public(ip.parse().unwrap()), "{ip}");
        }
    }
}
