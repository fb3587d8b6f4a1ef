//! Pages in a real browser, which write down what they find.

use std::io::{BufRead, BufReader};
use std::process::{ChildStderr, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// What the checks may take; they take some two seconds.
const PATIENCE: Duration = Duration::from_secs(120);

/// A Chromium, by `$CHROMIUM` or in the path.
pub fn browser() -> Option<String> {
    let named = std::env::var("CHROMIUM").ok();
    let candidates = named.into_iter().chain(BROWSERS.map(str::to_owned));
    let runs = |name: &String| {
        let tried = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        tried.is_ok_and(|status| status.success())
    };
    candidates.into_iter().find(runs)
}

/// What the checks found: a line each, the last one telling the colours and the width that they saw.
pub fn verdicts(browser: &str, html: &str, flags: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    std::fs::write(&file, html).unwrap();
    // The sandbox cannot be had as root or within some containers; what is shown is this test's own page.
    let mut child = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--force-color-profile=srgb"])
        .args(["--window-size=1280,900", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .args(flags)
        .arg(format!("file://{}", file.display()))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let found = console(child.stderr.take().unwrap());
    child.kill().unwrap();
    child.wait().unwrap();
    found
}

/// The verdicts on a browser's console, up to the last one. Lines are read elsewhere, so that a page that never ends
/// cannot hold up the test.
fn console(lines: ChildStderr) -> Vec<String> {
    let (sender, receiver) = mpsc::channel();
    let read = move || BufReader::new(lines).lines().map_while(Result::ok).try_for_each(|line| sender.send(line));
    std::thread::spawn(read);
    let deadline = Instant::now() + PATIENCE;
    let (mut said, mut verdicts) = (Vec::new(), Vec::new());
    while let Ok(line) = receiver.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
        let verdict = line.split_once("\"verdict: ").and_then(|(_, rest)| rest.rsplit_once("\", source: "));
        verdicts.extend(verdict.map(|(words, _)| words.to_owned()));
        if verdict.is_some_and(|(words, _)| words.starts_with("done, ")) {
            return verdicts;
        }
        said.push(line);
    }
    panic!("the checks did not end: {said:#?}")
}
