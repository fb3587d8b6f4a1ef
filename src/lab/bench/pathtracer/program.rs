//! Running the program, without a screen, and reading its figures.

use super::super::cpu;
use super::stand_in::StandIn;
use crate::{Error, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What both renderers do.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EmbreePlan {
    /// Samples per pixel and frame. Phototaxis renders all frames' samples as one picture.
    pub(crate) spp: u32,
    pub(crate) frames: u32,
    /// Segments of a path at most.
    pub(crate) depth: u32,
    /// Of every surface, in all colours.
    pub(crate) albedo: f32,
    /// Threads; 0 takes all of the machine's.
    pub(crate) threads: usize,
}

/// Names of the program in Debian 13 and 12.
const NAMES: [&str; 2] = ["embree_pathtracer", "pathtracer"];

/// The program, in the folders of `path` (as the environment's PATH); `None` where it is not installed.
pub fn find_pathtracer(path: &std::ffi::OsStr) -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(path).collect();
    NAMES.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|file| file.is_file())
}

/// What its frames took.
pub(crate) struct Frames {
    /// Of the long run, as it prints them.
    pub(crate) msamples_per_second: f64,
    pub(crate) mrays_per_second: f64,
    msamples: f64,
    /// Processor seconds of all frames: loading, building and warming up are taken off.
    cpu_seconds: f64,
}

impl Frames {
    pub(crate) fn msamples_per_cpu_second(&self) -> f64 {
        self.msamples / self.cpu_seconds
    }

    pub(crate) fn rays_per_sample(&self) -> f64 {
        self.mrays_per_second / self.msamples_per_second
    }
}

/// A run with one frame and one with `plan.frames` more, each after a frame that is not counted.
pub(crate) fn run(program: &Path, stand_in: &StandIn, plan: &EmbreePlan) -> Result<Frames> {
    let (short, _) = timed(program, stand_in, plan, 1)?;
    let (long, text) = timed(program, stand_in, plan, 1 + plan.frames)?;
    let figure = |key: &str| {
        let number = text.lines().find_map(|line| line.trim().strip_prefix(key)?.trim().parse::<f64>().ok());
        number.filter(|n| *n > 0.0).ok_or_else(|| Error::file(program, format!("it printed no {key}")))
    };
    let film = &stand_in.description.scene.film;
    let per_frame = film.width as f64 * film.height as f64 * plan.spp as f64 * 1e-6;
    Ok(Frames {
        msamples_per_second: per_frame * figure("BENCHMARK_RENDER_AVG ")?,
        mrays_per_second: figure("BENCHMARK_RENDER_MRAYPS_AVG ")?,
        msamples: per_frame * plan.frames as f64,
        cpu_seconds: long - short,
    })
}

/// Processor seconds of a run, and what it printed.
fn timed(program: &Path, stand_in: &StandIn, plan: &EmbreePlan, frames: u32) -> Result<(f64, String)> {
    let before = cpu::of_children()?;
    let mut command = Command::new(program);
    command.args(arguments(stand_in, plan)).args(["--benchmark", "1", &frames.to_string()]);
    let output = command.output().map_err(Error::io(program))?;
    let cpu = cpu::of_children()?.without(before);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        let last = String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned();
        return Err(Error::file(program, format!("it failed with {}: {last}", output.status)));
    }
    Ok((cpu.seconds(), text))
}

/// `--legacy` keeps the plain text of figures where the program was built with another library for them.
fn arguments(stand_in: &StandIn, plan: &EmbreePlan) -> Vec<String> {
    let camera = stand_in.camera();
    let film = &stand_in.description.scene.film;
    let vector = |v: glam::Vec3| v.to_array().map(|x| x.to_string());
    let mut arguments = vec!["-i".to_owned(), stand_in.model().display().to_string(), "--pointlight".to_owned()];
    let mut add = |name: &str, values: &[String]| {
        arguments.extend((!name.is_empty()).then(|| name.to_owned()));
        arguments.extend_from_slice(values);
    };
    add("", &vector(stand_in.light.position));
    add("", &vector(stand_in.light.intensity));
    add("--vp", &vector(camera.origin.as_vec3()));
    add("--vi", &vector(camera.target.as_vec3()));
    add("--vu", &vector(camera.up));
    add("--fov", &[camera.vfov.to_string()]);
    add("--size", &[film.width.to_string(), film.height.to_string()]);
    add("--spp", &[plan.spp.to_string()]);
    add("--max-path-length", &[plan.depth.to_string()]);
    if plan.threads > 0 {
        add("--threads", &[plan.threads.to_string()]);
    }
    add("--legacy", &[]);
    arguments
}
