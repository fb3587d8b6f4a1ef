//! The picture while a render goes on, elsewhere than in files: on a page, and in tev.

use super::stopping::Running;
use super::{TINY, folder, names, phototaxis, scene, stderr};
use crate::common::browser::{browser, verdicts};
use phototaxis::image::exr::read_layers;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

/// An answer by HTTP.
struct Answer {
    head: String,
    body: Vec<u8>,
}

impl Answer {
    fn status(&self) -> u16 {
        self.head.split(' ').nth(1).unwrap().parse().unwrap()
    }

    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }
}

/// A page of a program that runs.
struct Page {
    port: u16,
}

impl Page {
    /// As the program says where it is.
    fn of(render: &mut Running) -> Page {
        render.hear();
        let at = render.said().split("http://127.0.0.1:").nth(1).unwrap_or_else(|| panic!("{}", render.said()));
        Page { port: at.split('/').next().unwrap().parse().unwrap() }
    }

    fn request(&self, method: &str, path: &str, host: &str) -> std::io::Result<Answer> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        write!(stream, "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: 0\r\n\r\n")?;
        let mut all = Vec::new();
        stream.read_to_end(&mut all)?;
        let end = all.windows(4).position(|four| four == b"\r\n\r\n").ok_or(std::io::ErrorKind::UnexpectedEof)?;
        Ok(Answer { head: String::from_utf8(all[..end].to_vec()).unwrap(), body: all[end + 4..].to_vec() })
    }

    fn get(&self, path: &str) -> std::io::Result<Answer> {
        self.request("GET", path, &format!("127.0.0.1:{}", self.port))
    }

    /// Asks again and again until the page says so.
    fn wait(&self, is_there: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let status = self.get("/status?page=7").unwrap().json();
            if is_there(&status) {
                return status;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "{status}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Starts a render of the project's box, tiny, with a page.
fn served(here: &Path, arguments: &[&str]) -> (Running, Page) {
    let scene = scene("cornell.toml").display().to_string();
    let all: Vec<String> =
        [scene.as_str()].iter().chain(&TINY).chain(&["--serve"]).chain(arguments).map(|a| a.to_string()).collect();
    let mut render = Running::start(here, &all);
    let page = Page::of(&mut render);
    (render, page)
}

fn word(bytes: &[u8], at: usize) -> [u8; 4] {
    bytes[at..at + 4].try_into().unwrap()
}

/// Numbers in half precision that are finite.
fn half(bits: [u8; 2]) -> f32 {
    let bits = u16::from_le_bytes(bits);
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size =
        if exponent == 0 { mantissa * 2f32.powi(-24) } else { (1.0 + mantissa / 1024.0) * 2f32.powi(exponent - 15) };
    if bits >> 15 == 1 { -size } else { size }
}

#[test]
fn a_page_shows_a_render_until_its_end() {
    let here = folder();
    let (mut render, page) = served(here.path(), &["--time", "300", "-o", "a.exr", "--guide", "grid"]);
    let status = page.wait(|status| status["figures"]["relative_error"].is_number());
    let figures = &status["figures"];
    assert!(status["progress"]["share"].is_number() && status["progress"]["stage"] == "rendering", "{status}");
    assert!(
        figures["rays"].as_u64() > figures["paths"].as_u64() && figures["guide"]["bytes"].as_u64() > Some(0),
        "{status}"
    );
    assert!(status["ended"].is_null() && status["guide"] == "grid", "{status}");
    let before = page.get("/picture").unwrap();
    assert_eq!((before.status(), before.body.len()), (200, 16 + 16 * 12 * 6));

    let whole = page.get("/").unwrap();
    assert!(whole.status() == 200 && String::from_utf8(whole.body).unwrap().contains("cornell.toml</title>"));
    for header in ["Content-Security-Policy: default-src 'none'", "Cache-Control: no-store", "text/html; charset=utf-8"]
    {
        assert!(whole.head.contains(header), "{}", whole.head);
    }
    for (method, path, host, status) in [
        ("GET", "/", "localhost:80", 200),
        ("HEAD", "/", "[::1]", 200),
        ("GET", "/", "evil.example", 403),
        ("GET", "/picture", "127.0.0.1.evil.example:80", 403),
        ("POST", "/status", "localhost", 405),
        ("DELETE", "/", "localhost", 405),
        ("GET", "/../../etc/passwd", "localhost", 404),
    ] {
        let answer = page.request(method, path, host).unwrap();
        assert_eq!(answer.status(), status, "{method} {path} {host}");
        assert!(!answer.head.contains("Access-Control-Allow"), "{}", answer.head);
    }

    render.wait_until_it_catches_signals();
    render.send("INT");
    assert_eq!(page.wait(|status| status["ended"].is_string())["ended"], "stopped by a signal");
    let last = page.get("/picture?page=7").unwrap().body;
    assert_eq!(render.wait().code(), Some(130), "{}", render.said());
    assert!(page.get("/").is_err(), "the page closes with the render");
    let channels = read_layers(&here.path().join("a.exr")).unwrap().channels;
    let gain = 2f32.powi(i32::from_le_bytes(word(&last, 12)));
    for (i, pixel) in last[16..].chunks_exact(6).enumerate() {
        for (channel, at) in ["R", "G", "B"].into_iter().zip([0, 2, 4]) {
            let (shown, written) = (half([pixel[at], pixel[at + 1]]) / gain, channels[channel][i]);
            assert!(
                (shown - written).abs() <= written.abs() / 2048.0 + 2f32.powi(-25) / gain,
                "{channel} {i}: {shown}, {written}"
            );
        }
    }
}

#[test]
fn who_watches_changes_no_picture() {
    let here = folder();
    let (mut render, page) = served(here.path(), &["--spp", "256", "-o", "a.exr"]);
    let mut pictures = 0;
    while let Ok(status) = page.get("/status?page=7").map(|answer| answer.json()) {
        pictures += u32::from(page.get("/picture?page=7").is_ok_and(|answer| answer.status() == 200));
        if status["ended"].is_string() {
            break;
        }
    }
    assert!(render.wait().success() && pictures > 0, "{}", render.said());
    let scene = scene("cornell.toml");
    phototaxis(here.path()).arg("render").arg(scene).args(TINY).args(["--spp", "256", "-o", "b.exr"]).assert().code(0);
    let [a, b] = ["a.exr", "b.exr"].map(|name| read_layers(&here.path().join(name)).unwrap().channels);
    assert!(a == b);
}

/// What a render of the project's box says that fails before it begins.
fn refused(here: &Path, arguments: &[&str]) -> String {
    let mut command = phototaxis(here);
    command.arg("render").arg(scene("cornell.toml")).args(TINY).args(["-o", "a.exr"]).args(arguments);
    let said = stderr(command.assert().code(1).get_output()).to_string();
    assert!(names(here).is_empty(), "{said}");
    said
}

#[test]
fn a_port_in_use_and_a_missing_viewer_are_errors_before_the_render() {
    let here = folder();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let said = refused(here.path(), &[&format!("--serve={port}")]);
    assert!(said.contains(&format!("cannot be served at 127.0.0.1:{port}")) && said.contains("in use"), "{said}");
    drop(taken);
    let said = refused(here.path(), &[&format!("--tev=127.0.0.1:{port}")]);
    assert!(said.contains("no tev answers") && said.contains("start tev first"), "{said}");
}

/// A packet of tev's, as far as it is looked at.
#[derive(Debug, PartialEq)]
enum Packet {
    Close,
    Create { size: [u32; 2], channels: Vec<String> },
    Update { channels: Vec<String>, data: Vec<f32> },
}

/// Takes parts of a packet.
struct Parts<'a>(&'a [u8]);

impl Parts<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_at(N);
        self.0 = rest;
        first.try_into().unwrap()
    }

    fn number(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).unwrap();
        let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
        self.0 = &self.0[end + 1..];
        text
    }

    fn texts(&mut self) -> Vec<String> {
        (0..self.number()).map(|_| self.text()).collect()
    }

    /// All of a packet but its length, by tev's protocol.
    fn packet(&mut self) -> Packet {
        let [kind] = self.take();
        if kind == 2 {
            assert!(self.text().ends_with("cornell.toml"));
            return Packet::Close;
        }
        let [_grab] = self.take();
        assert!(self.text().ends_with("cornell.toml"));
        match kind {
            4 => {
                let size = [self.number(), self.number()];
                Packet::Create { size, channels: self.texts() }
            }
            6 => {
                let channels = self.texts();
                let place = [0; 4].map(|_| self.number());
                assert_eq!(place, [0, 0, 16, 12]);
                let layout: Vec<u64> = (0..2 * channels.len()).map(|_| u64::from_le_bytes(self.take())).collect();
                let (offsets, strides) = layout.split_at(channels.len());
                assert!(offsets.iter().zip(0..).all(|(offset, k)| *offset == k), "{offsets:?}");
                assert!(strides.iter().all(|stride| *stride == channels.len() as u64), "{strides:?}");
                Packet::Update {
                    channels,
                    data: self.0.chunks_exact(4).map(|x| f32::from_le_bytes(x.try_into().unwrap())).collect(),
                }
            }
            other => panic!("packet {other}"),
        }
    }
}

/// All packets of the first connection.
fn packets(listener: &TcpListener) -> Vec<Packet> {
    let (mut bytes, mut packets) = (Vec::new(), Vec::new());
    listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
    let mut rest = &bytes[..];
    while !rest.is_empty() {
        let (packet, after) = rest.split_at(u32::from_le_bytes(word(rest, 0)) as usize);
        packets.push(Parts(&packet[4..]).packet());
        rest = after;
    }
    packets
}

#[test]
fn tev_is_sent_the_picture_and_at_the_end_its_layers() {
    let here = folder();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let listening = std::thread::spawn(move || packets(&listener));
    let mut command = phototaxis(here.path());
    command.arg("render").arg(scene("cornell.toml")).args(TINY).args([
        "--spp",
        "64",
        "-o",
        "a.exr",
        &format!("--tev={port}"),
    ]);
    command.assert().code(0);
    let packets = listening.join().unwrap();
    let colours = ["R", "G", "B"].map(String::from).to_vec();
    assert_eq!(packets[0], Packet::Create { size: [16, 12], channels: colours.clone() });
    let Packet::Update { channels, data } = &packets[1] else { panic!("{:?}", packets[1]) };
    assert!(*channels == colours && data.len() == 16 * 12 * 3 && data.iter().any(|x| *x > 0.0));
    let end = packets.iter().position(|packet| *packet == Packet::Close).unwrap();
    let written = read_layers(&here.path().join("a.exr")).unwrap().channels;
    let Packet::Create { channels, .. } = &packets[end + 1] else { panic!("{:?}", packets[end + 1]) };
    let mut sorted = channels.clone();
    sorted.sort();
    assert_eq!(sorted, written.keys().cloned().collect::<Vec<_>>());
    assert_eq!(packets.len(), end + 2 + channels.len());
    for packet in &packets[end + 2..] {
        let Packet::Update { channels, data } = packet else { panic!("{packet:?}") };
        assert!(
            data.len() == 16 * 12 && (!["R", "G", "B", "A"].contains(&&*channels[0]) || written[&channels[0]] == *data)
        );
    }
}

#[test]
fn a_viewer_that_closes_is_told_of_once_and_the_render_goes_on() {
    let here = folder();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let closing = std::thread::spawn(move || drop(listener.accept().unwrap()));
    let mut command = phototaxis(here.path());
    command.arg("render").arg(scene("cornell.toml")).args(TINY).args([
        "-o",
        "a.exr",
        "--spp",
        "4096",
        &format!("--tev={port}"),
    ]);
    let said = stderr(command.assert().code(0).get_output()).to_string();
    closing.join().unwrap();
    assert!(said.matches("warning").count() == 1 && said.contains("tev takes no pictures any more"), "{said}");
    assert_eq!(names(here.path()), ["a.exr"]);
}

/// Bytes of a PNG's pixels.
fn pixels(path: &Path) -> Vec<u8> {
    image::open(path).unwrap().into_rgb8().into_raw()
}

/// The page of a finished render with its answers put before it, and what checks it behind.
fn recorded(here: &Path, page: &str, status: &Value, picture: &[u8]) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let script = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let [plain, bright] = ["a.png", "b.png"].map(|name| pixels(&here.join(name)));
    let answers = format!(
        "const answers = {{ status: {status}, picture: new Uint8Array({picture:?}).buffer, width: 32 }};
        const expected = {{ 0: {plain:?}, 2: {bright:?} }};
        window.fetch = async (path) => path.startsWith('status')
            ? {{ ok: true, json: async () => answers.status }}
            : {{ ok: true, arrayBuffer: async () => answers.picture }};"
    );
    page.replacen(
        "<style>",
        &format!("<script>{}</script><script>{answers}</script><style>", script("report/watch.js")),
        1,
    )
    .replacen("</body>", &format!("<script>{}</script></body>", script("page/checks.js")), 1)
}

#[test]
fn the_page_does_what_it_says_in_a_browser() {
    let Some(browser) = browser() else {
        eprintln!("SKIPPED: the page of a render was not tried: no Chromium in the path, nor by $CHROMIUM");
        return;
    };
    for tone in ["agx", "srgb", "aces"] {
        let here = folder();
        let size = ["--size", "32x24", "--spp", "16", "--guide", "grid", "--exposure", "-0.3", "--tone", tone];
        let (mut render, page) = served(here.path(), &[&size[..], &["-o", "a.exr", "-o", "a.png"]].concat());
        let html = String::from_utf8(page.get("/").unwrap().body).unwrap();
        let status = page.wait(|status| status["ended"].is_string());
        let picture = page.get("/picture?page=7").unwrap().body;
        assert!(render.wait().success(), "{}", render.said());
        let brighter = ["image", "a.exr", "-o", "b.png", "--exposure", "1.7", "--tone", tone];
        phototaxis(here.path()).args(brighter).assert().code(0);
        let html = recorded(here.path(), &html, &status, &picture);
        let quoted = html.replace('&', "&amp;").replace('"', "&quot;");
        let phone =
            format!(r#"<!DOCTYPE html><body><iframe width="375" height="800" srcdoc="{quoted}"></iframe></body>"#);
        let (html, flags, conditions): (_, &[&str], _) = match tone {
            "agx" => (&html, &[], "done, light, 1280 wide"),
            "srgb" => (&html, &["--blink-settings=preferredColorScheme=0"], "done, dark, 1280 wide"),
            _ => (&phone, &[], "done, light, 375 wide"),
        };
        let found = verdicts(&browser, html, flags);
        let (last, checks) = found.split_last().unwrap();
        let failed: Vec<_> = checks.iter().filter(|line| !line.starts_with("ok ")).collect();
        assert!(failed.is_empty() && checks.len() == 10, "{tone}: {checks:#?}");
        assert_eq!(last, conditions);
    }
}
