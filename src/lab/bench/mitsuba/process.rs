//! A Python process that holds a scene in one variant of Mitsuba's, and renders it on demand.

use crate::io::atomic::write_atomically;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

const DRIVER: &str = include_str!("driver.py");

/// A variant that waits for orders.
pub(crate) struct Process {
    pub(crate) variant: &'static str,
    pub(crate) version: String,
    program: PathBuf,
    child: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// What it says on standard error.
    log: PathBuf,
}

/// What starting one comes to.
pub(crate) enum Started {
    Ready(Process),
    /// There is no such interpreter, module, variant or compiler.
    Missing(String),
}

/// One render.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) struct Timing {
    pub(crate) seconds: f64,
    /// Processor seconds of all threads.
    pub(crate) cpu_seconds: f64,
}

#[derive(Serialize)]
struct Order<'a> {
    spp: u32,
    seed: u32,
    picture: &'a Path,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Greeting {
    Version(String),
    Missing(String),
}

impl Process {
    /// Loads the scene `file`; driver and log are written beside it.
    ///
    /// # Errors
    /// A process that ends, or says anything else than what the driver says.
    pub(crate) fn start(program: &Path, variant: &'static str, file: &Path, threads: usize) -> Result<Started> {
        let [driver, log] = ["driver.py".to_owned(), format!("{variant}.log")].map(|name| file.with_file_name(name));
        write_atomically(&driver, |out| out.write_all(DRIVER.as_bytes()))?;
        let errors = File::create(&log).map_err(Error::io(&log))?;
        let mut command = Command::new(program);
        command.arg(&driver).arg(variant).arg(file).arg(threads.to_string());
        let mut child = match command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(errors).spawn() {
            Ok(child) => child,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Started::Missing(error.to_string())),
            Err(error) => return Err(Error::io(program)(error)),
        };
        let orders = child.stdin.take().expect("it was asked for");
        let answers = BufReader::new(child.stdout.take().expect("it was asked for"));
        let (program, version) = (program.to_owned(), String::new());
        let mut process = Process { variant, version, program, child, orders, answers, log };
        Ok(match process.answer()? {
            Greeting::Version(version) => {
                process.version = version;
                Started::Ready(process)
            }
            Greeting::Missing(what) => Started::Missing(what),
        })
    }

    #[cfg(test)]
    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Renders, and leaves the picture as OpenEXR in `picture`.
    pub(crate) fn render(&mut self, spp: u32, seed: u32, picture: &Path) -> Result<Timing> {
        let order = serde_json::to_string(&Order { spp, seed, picture }).expect("numbers and a path are JSON");
        if writeln!(self.orders, "{order}").and_then(|()| self.orders.flush()).is_err() {
            return Err(self.ended());
        }
        let timing: Timing = self.answer()?;
        if timing.seconds > 0.0 && timing.cpu_seconds > 0.0 { Ok(timing) } else { Err(self.fault("it took no time")) }
    }

    fn answer<T: for<'a> Deserialize<'a>>(&mut self) -> Result<T> {
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(0) => Err(self.ended()),
            Ok(_) => {
                serde_json::from_str(&line).map_err(|_| self.fault(&format!("unexpected answer: {}", line.trim())))
            }
            Err(error) => Err(Error::io(&self.program)(error)),
        }
    }

    /// What an end of the process that nobody asked for is.
    fn ended(&mut self) -> Error {
        let status = self.child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
        let said = std::fs::read(&self.log).unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default().to_owned();
        self.fault(&format!("it failed with {status}: {last}"))
    }

    fn fault(&self, message: &str) -> Error {
        Error::file(&self.program, format!("Mitsuba's {}: {message}", self.variant))
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // where it has ended already there is nothing to do
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
