//! HTTP for the page. Nothing can be changed by it.
//!
//! A page of another site can send requests to this machine, but not read the answers: none allows another origin to. By DNS
//! rebinding, where such a page's own name comes to mean this machine, it could. So a request is answered only if the host that it
//! names is a number, `localhost`, or the name that was asked for on the command line: for these there is no such name.

use super::super::address::Address;
use super::board::Board;
use crate::image::Tone;
use rustix::net::sockopt::{Timeout, set_socket_timeout};
use std::io::{self, Cursor};
use std::net::{IpAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;
use tiny_http::{Header, Method, Request, Response, StatusCode};

/// Threads that answer.
const THREADS: usize = 4;
/// A client that takes nothing for so long loses its connection.
const PATIENCE: Duration = Duration::from_secs(5);

const HTML: &str = "text/html; charset=utf-8";
const JSON: &str = "application/json";
const DATA: &str = "application/octet-stream";
const TEXT: &str = "text/plain; charset=utf-8";

/// With each answer: nothing is taken from elsewhere, put into other pages, read by other sites, guessed at or kept.
const HEADERS: [(&str, &str); 5] = [
    (
        "Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'self'",
    ),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cache-Control", "no-store"),
];

type Answer = Response<Cursor<Body>>;

/// Shared by all that it is sent to.
struct Body(Arc<[u8]>);

impl AsRef<[u8]> for Body {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// Answers until it is dropped. Threads that wait for slow clients may be left then.
pub(super) struct Server(Arc<tiny_http::Server>);

impl Server {
    pub(super) fn start(listener: TcpListener, address: &Address, board: Arc<Board>) -> io::Result<Server> {
        // what the listener has, its connections have too
        set_socket_timeout(&listener, Timeout::Send, Some(PATIENCE))?;
        let server = Arc::new(tiny_http::Server::from_listener(listener, None).map_err(io::Error::other)?);
        for _ in 0..THREADS {
            let (server, board, host) = (server.clone(), board.clone(), address.host.clone());
            let answer = move || {
                while let Ok(request) = server.recv() {
                    // a client that is gone needs no answer
                    _ = respond(request, &host, &board);
                }
            };
            std::thread::Builder::new().name("page".into()).spawn(answer)?;
        }
        Ok(Server(server))
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        (0..THREADS).for_each(|_| self.0.unblock());
    }
}

fn respond(request: Request, host: &str, board: &Board) -> io::Result<()> {
    let named = request.headers().iter().find(|header| header.field.equiv("Host")).map(|header| header.value.as_str());
    if !named.is_some_and(|named| is_own(named, host)) {
        let said = "this page answers to its number, to localhost, and to the name that --serve gives it";
        return request.respond(answer(403, TEXT, said.as_bytes()));
    }
    if !matches!(request.method(), Method::Get | Method::Head) {
        return request.respond(answer(405, TEXT, b"nothing can be changed here"));
    }
    let (path, query) = request.url().split_once('?').unwrap_or((request.url(), ""));
    let visitor = query.strip_prefix("page=").and_then(|number| number.parse().ok());
    match path {
        "/" => request.respond(answer(200, HTML, page(board.name()).as_bytes())),
        "/status" => request.respond(answer(200, JSON, board.status(visitor).to_string().as_bytes())),
        "/picture" => match board.picture() {
            None => request.respond(answer(404, TEXT, b"there is no picture yet")),
            Some((picture, number)) => {
                request.respond(answer_with(200, DATA, picture))?;
                visitor.into_iter().for_each(|visitor| board.has_taken(visitor, number));
                Ok(())
            }
        },
        _ => request.respond(answer(404, TEXT, b"there is no such page")),
    }
}

fn answer(status: u16, kind: &str, body: &[u8]) -> Answer {
    answer_with(status, kind, body.into())
}

fn answer_with(status: u16, kind: &str, body: Arc<[u8]>) -> Answer {
    let length = body.len();
    let lines = HEADERS.into_iter().chain([("Content-Type", kind)]);
    let headers = lines.filter_map(|(name, value)| Header::from_bytes(name, value).ok()).collect();
    Response::new(StatusCode(status), headers, Cursor::new(Body(body)), Some(length), None)
        .with_chunked_threshold(usize::MAX)
}

/// Whether the host of a request, with or without a port, cannot be another site's name.
fn is_own(named: &str, host: &str) -> bool {
    let bare = match named.strip_prefix('[') {
        Some(rest) => rest.split_once(']').map_or(rest, |(bare, _)| bare),
        None => named.split_once(':').map_or(named, |(bare, _)| bare),
    };
    bare.parse::<IpAddr>().is_ok() || bare.eq_ignore_ascii_case("localhost") || bare.eq_ignore_ascii_case(host)
}

/// All in one file.
fn page(name: &str) -> String {
    let escaped = name.replace('&', "&amp;").replace('<', "&lt;");
    let tones: serde_json::Map<_, _> = Tone::constants().into_iter().map(|(name, v)| (name.into(), v.into())).collect();
    include_str!("page.html")
        .replacen("/*STYLE*/", include_str!("page.css"), 1)
        .replacen("/*SCRIPT*/", &(include_str!("tone.js").to_owned() + include_str!("page.js")), 1)
        .replacen("/*TONES*/", &serde_json::Value::from(tones).to_string(), 1)
        .replacen("NAME", &escaped, 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_sites_are_not_its_own() {
        for own in ["127.0.0.1:80", "localhost", "LOCALHOST:8080", "[::1]:3", "10.0.0.7", "render.example:99"] {
            assert!(is_own(own, "render.example"), "{own}");
        }
        for other in
            ["", "evil.example", "evil.example:80", "127.0.0.1.evil.example", "localhost.evil.example", "[evil]"]
        {
            assert!(!is_own(other, "render.example"), "{other}");
        }
    }

    /// Five clients that never read, of a picture that no buffer holds, take all threads; the next waits for their patience.
    #[test]
    fn slow_clients_are_given_up() {
        use std::io::{Read, Write};
        use std::net::TcpStream;
        let board = Arc::new(Board::new("a", Tone::Srgb));
        board.change(|shown| shown.show_bytes(vec![0; 1 << 26]));
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let at = listener.local_addr().unwrap();
        let _server = Server::start(listener, &super::super::super::address::serve("").unwrap(), board).unwrap();
        let ask = |path: &str| {
            let mut stream = TcpStream::connect(at).unwrap();
            write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
            stream
        };
        let slow: Vec<_> = (0..=THREADS).map(|_| ask("/picture")).collect();
        std::thread::sleep(Duration::from_millis(200));
        let (clock, mut answer) = (std::time::Instant::now(), String::new());
        ask("/status").read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        let waited = clock.elapsed();
        assert!(waited > PATIENCE / 2 && waited < 10 * PATIENCE, "{waited:?}");
        drop(slow);
    }

    #[test]
    fn the_page_needs_no_other_file() {
        let page = page("a<b & c");
        assert!(page.contains("<title>a&lt;b &amp; c</title>") && page.contains("<h1>a&lt;b &amp; c</h1>"), "{page}");
        for outside in ["/*STYLE", "/*SCRIPT", "/*TONES", "http:", "https:", "src=", "<link", "@import", "url("] {
            assert!(!page.contains(outside), "{outside}");
        }
    }
}
