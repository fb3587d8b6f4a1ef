//! No file makes the program panic, abort, hang or take more memory than there is: each loader reads thousands of
//! damaged files, in a process of its own whose address space is limited, so that a huge request fails.
//!
//! An input is decided by its loader and its index alone. Environment variables, all optional:
//! `PHOTOTAXIS_FUZZ_COUNT` inputs of each loader; `PHOTOTAXIS_FUZZ_FIRST`, the index of the first;
//! `PHOTOTAXIS_FUZZ_ONLY`, the loader's name. What failed is named with its index and stays in the folder that is named.

mod loaders;
mod mutate;
mod pictures;
mod seeds;

use loaders::{LOADERS, Loader};
use std::fs::File;
use std::os::unix::fs::FileExt as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Inputs of each loader where nobody says how many.
const COUNT: u64 = 3000;

/// KiB of address space of the process that reads them.
const ADDRESS_SPACE: u64 = 1 << 20;

/// Seconds after which an input counts as one that hangs. Those that do not take milliseconds; machines may be busy.
const PATIENCE: u64 = 20;

/// Says to the test [`child`] which loader it is to run.
const LOADER: &str = "PHOTOTAXIS_FUZZ_LOADER";

/// Says to it where its files are to be.
const FOLDER: &str = "PHOTOTAXIS_FUZZ_FOLDER";

fn variable(name: &str) -> Option<u64> {
    Some(std::env::var(name).ok()?.parse().unwrap_or_else(|_| panic!("{name} is no number")))
}

#[test]
fn damaged_files_are_refused_or_read() {
    let only = std::env::var("PHOTOTAXIS_FUZZ_ONLY").ok();
    let chosen: Vec<_> = LOADERS.iter().filter(|(name, _)| only.as_ref().is_none_or(|only| only == name)).collect();
    assert!(!chosen.is_empty(), "no such loader");
    let failures: Vec<String> = chosen.into_iter().filter_map(|&(name, share)| failure(name, share)).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

/// What went wrong with a loader.
fn failure(name: &str, share: u64) -> Option<String> {
    let count = variable("PHOTOTAXIS_FUZZ_COUNT").unwrap_or(COUNT).div_ceil(share);
    let folder = tempfile::tempdir().unwrap();
    let output = run(name, folder.path(), variable("PHOTOTAXIS_FUZZ_FIRST").unwrap_or(0), count);
    let (said, wrong) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    print!(
        "{}",
        said.lines().filter(|line| line.starts_with("fuzz: ")).fold(String::new(), |all, line| all + line + "\n")
    );
    (!output.status.success()).then(|| {
        let folder = folder.keep();
        let at = std::fs::read_to_string(folder.join("index")).unwrap_or_default();
        format!("{name}: input {} in {}: {}\n{wrong}", at.trim(), folder.display(), output.status)
    })
}

/// Runs the test [`child`] of this program under a limit of memory.
fn run(name: &str, folder: &Path, first: u64, count: u64) -> Output {
    let limited = format!("ulimit -v {ADDRESS_SPACE} && exec \"$0\" \"$@\"");
    let program = std::env::current_exe().unwrap();
    let mut command = Command::new("sh");
    command.arg("-c").arg(limited).arg(program).args(["child", "--exact", "--nocapture", "--test-threads=1"]);
    command.env(LOADER, name).env(FOLDER, folder).env("RAYON_NUM_THREADS", "1").env("MALLOC_ARENA_MAX", "2");
    command.env("PHOTOTAXIS_FUZZ_FIRST", first.to_string()).env("PHOTOTAXIS_FUZZ_COUNT", count.to_string());
    command.output().unwrap()
}

/// Reads the inputs of one loader, in the process that [`run`] makes; alone it does nothing.
#[test]
fn child() {
    let Ok(name) = std::env::var(LOADER) else { return };
    if name == "greedy" {
        return drop(std::hint::black_box(vec![1u8; (ADDRESS_SPACE as usize) << 10]));
    }
    let folder = PathBuf::from(std::env::var_os(FOLDER).unwrap());
    let loader = Loader::new(&name, &folder);
    let first = variable("PHOTOTAXIS_FUZZ_FIRST").unwrap_or(0);
    let indices = first..first + variable("PHOTOTAXIS_FUZZ_COUNT").unwrap_or(COUNT).max(loader.seeds());
    static LAST_PANIC: Mutex<String> = Mutex::new(String::new());
    std::panic::set_hook(Box::new(|panic| *LAST_PANIC.lock().unwrap() = panic.to_string()));
    let start = Instant::now();
    let watch = Watch::start();
    let kept = File::create(folder.join("index")).unwrap();
    let (mut accepted, mut slowest) = (0, (Duration::ZERO, 0));
    for index in indices.clone() {
        std::fs::write(loader.path(), loader.input(index)).unwrap();
        kept.write_all_at(format!("{index:<20}").as_bytes(), 0).unwrap();
        watch.begin();
        let began = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| loader.load(index)));
        slowest = slowest.max((began.elapsed(), index));
        match result {
            Ok(Ok(())) => accepted += 1,
            Ok(Err(message)) if index < loader.seeds() => fail(&format!("a valid file: {message}")),
            Ok(Err(message)) if message.is_empty() => fail("refused without a word"),
            Ok(Err(_)) => (),
            Err(_) => fail(&LAST_PANIC.lock().unwrap()),
        }
    }
    let (inputs, seconds) = (indices.end - indices.start, start.elapsed().as_secs_f64());
    let (longest, at) = slowest;
    println!("\nfuzz: {name}: {inputs} inputs, {accepted} accepted, {seconds:.1} s; the slowest, {at}, {longest:.1?}");
}

fn fail(what: &str) -> ! {
    eprintln!("{what}");
    std::process::exit(1)
}

/// Ends the process where an input takes too long.
struct Watch {
    began: Instant,
    /// Milliseconds from `began` to the beginning of the input.
    input: &'static AtomicU64,
}

impl Watch {
    fn start() -> Watch {
        let (began, input): (_, &'static AtomicU64) = (Instant::now(), Box::leak(Box::default()));
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(Duration::from_millis(200));
                let passed = began.elapsed().as_millis() as u64 - input.load(Ordering::SeqCst);
                if passed > PATIENCE * 1000 {
                    fail("it takes too long");
                }
            }
        });
        Watch { began, input }
    }

    fn begin(&self) {
        self.input.store(self.began.elapsed().as_millis() as u64, Ordering::SeqCst);
    }
}

/// The limit is one: a request beyond it ends the process, which [`failure`] would report.
#[test]
fn huge_requests_end_the_process() {
    assert!(!run("greedy", Path::new(""), 0, 1).status.success());
}
