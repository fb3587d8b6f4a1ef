//! Where other programs are found: `HOST:PORT`, or a part of it.

use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::time::Duration;

const LOOPBACK: &str = "127.0.0.1";

/// Where tev listens unless it is told otherwise.
const TEV_PORT: u16 = 14158;

/// A host, by name or number, and a port; 0 for any that is free.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Address {
    pub(super) host: String,
    port: u16,
}

/// Where the page is served.
pub(super) fn serve(text: &str) -> Result<Address, String> {
    Address::parse(text, 0)
}

/// Where tev listens.
pub(super) fn tev(text: &str) -> Result<Address, String> {
    Address::parse(text, TEV_PORT)
}

impl Address {
    /// `HOST:PORT`, `HOST` or `PORT`, where a host may be a name, an IPv4 address or, in brackets, an IPv6 address. What is left
    /// out is the loopback address and `port`.
    fn parse(text: &str, port: u16) -> Result<Address, String> {
        let wrong = || format!("expected HOST:PORT, HOST or PORT, as 127.0.0.1:8080, and found `{text}`");
        let number = |text: &str| text.parse::<u16>().map_err(|_| wrong());
        let (host, port) = match text.rsplit_once(':') {
            _ if text.is_empty() => (LOOPBACK, port),
            _ if text.bytes().all(|b| b.is_ascii_digit()) => (LOOPBACK, number(text)?),
            _ if text.ends_with(']') => (text, port),
            Some((host, end)) => (host, number(end)?),
            None => (text, port),
        };
        let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
        match bare.unwrap_or(host) {
            "" => Err(wrong()),
            name if bare.is_none() && name.contains([':', '/', ' ']) => Err(wrong()),
            name => Ok(Address { host: name.to_owned(), port }),
        }
    }

    fn found(&self) -> std::io::Result<Vec<SocketAddr>> {
        (&*self.host, self.port).to_socket_addrs().map(Iterator::collect)
    }

    pub(super) fn listen(&self) -> std::io::Result<TcpListener> {
        TcpListener::bind(&*self.found()?)
    }

    /// Connects to the first of its numbers that answers, each within `patience`.
    pub(super) fn connect(&self, patience: Duration) -> std::io::Result<TcpStream> {
        let mut newest = Err(std::io::ErrorKind::NotFound.into());
        for address in self.found()? {
            newest = TcpStream::connect_timeout(&address, patience);
            if newest.is_ok() {
                break;
            }
        }
        newest
    }
}

impl std::fmt::Display for Address {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Address { host, port } = self;
        if host.contains(':') { write!(f, "[{host}]:{port}") } else { write!(f, "{host}:{port}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_may_be_left_out() {
        let cases = [
            ("", "127.0.0.1:7"),
            ("8080", "127.0.0.1:8080"),
            ("0.0.0.0", "0.0.0.0:7"),
            ("render.example:80", "render.example:80"),
            ("[::1]", "[::1]:7"),
            ("[::1]:9", "[::1]:9"),
        ];
        for (text, address) in cases {
            assert_eq!(Address::parse(text, 7).unwrap().to_string(), address, "{text}");
        }
        for wrong in [":80", "host:", "host:x", "99999", "::1", "http://host", "a b", "[]:3"] {
            assert!(Address::parse(wrong, 7).is_err(), "{wrong}");
        }
    }
}
