//! Embree's own tutorial path tracer (Debian's package embree-tools) on the same work.
//!
//! Both get one OBJ file written for them: the scene's triangles, all of one grey diffuse material, lit by one point
//! light, which is what that program knows of lights; the scene's camera and picture size; paths of the same length
//! without roulette. `docs/performance.md` says what still differs.

mod program;
mod stand_in;
#[cfg(test)]
mod tests;

pub use program::{EmbreePlan, find_pathtracer};
pub use stand_in::PointLight;

use super::own::{OurFigures, Own};
use super::{median, settings};
use crate::Result;
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::scene::Scene;
use crate::stats::Median;
use program::{Frames, run};
use serde::Serialize;
use stand_in::StandIn;
use std::path::Path;

/// Both renderers' figures.
#[derive(Clone, Debug, Serialize)]
pub struct EmbreeReport {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) triangles: usize,
    pub(crate) plan: EmbreePlan,
    pub(crate) light: PointLight,
    pub(crate) phototaxis: OurFigures,
    /// `None` where the program is not installed.
    pub(crate) pathtracer: Option<EmbreeFigures>,
}

/// As the program prints them, and from the processor time of whole runs of it.
#[derive(Clone, Debug, Serialize)]
pub struct EmbreeFigures {
    pub(crate) msamples_per_second: Median,
    pub(crate) mrays_per_second: Median,
    /// From the difference between a long and a short run, in which loading and building cancel.
    pub(crate) msamples_per_cpu_second: Option<Median>,
    pub(crate) rays_per_sample: f64,
    /// Phototaxis' figures over these, turn by turn: samples per second, samples and rays per processor second.
    pub(crate) ratio: Median,
    pub(crate) cpu_ratio: Option<Median>,
    pub(crate) cpu_ray_ratio: Option<Median>,
}

/// Measures both in turns. `program` is what [`find_pathtracer`] found; without it only Phototaxis is measured.
///
/// # Errors
/// Files that cannot be written, a program that fails or prints no figures.
pub fn embree(
    scene: &Scene,
    description: &SceneFile,
    plan: &EmbreePlan,
    program: Option<&Path>,
    threads: usize,
    turns: usize,
) -> Result<EmbreeReport> {
    let stand_in = StandIn::write(scene, description, plan)?;
    let (own, _) = Scene::load(&stand_in.description.scene, threads, stand_in.description.render.build)?;
    let (settings, mut taken) = (settings(&stand_in.description, GuidingMethod::None), Vec::new());
    for _ in 0..turns {
        let theirs = program.map(|program| run(program, &stand_in, plan)).transpose()?;
        taken.push((Own::render(&own, &settings)?.0, theirs));
    }
    Ok(EmbreeReport {
        width: own.camera.width,
        height: own.camera.height,
        triangles: own.triangles(),
        plan: *plan,
        light: stand_in.light,
        phototaxis: OurFigures::of(taken.iter().map(|(ours, _)| ours))?,
        pathtracer: program.map(|_| their_figures(&taken)).transpose()?,
    })
}

type Turn = (Own, Option<Frames>);

fn their_figures(taken: &[Turn]) -> Result<EmbreeFigures> {
    let of = |figure: fn(&Own, &Frames) -> f64| {
        taken.iter().filter_map(|(ours, theirs)| Some(figure(ours, theirs.as_ref()?))).collect::<Vec<f64>>()
    };
    Ok(EmbreeFigures {
        msamples_per_second: median(&of(|_, f| f.msamples_per_second))?,
        mrays_per_second: median(&of(|_, f| f.mrays_per_second))?,
        msamples_per_cpu_second: Median::of(&of(|_, f| f.msamples_per_cpu_second())),
        rays_per_sample: median(&of(|_, f| f.rays_per_sample()))?.median,
        ratio: median(&of(|o, f| o.msamples_per_second() / f.msamples_per_second))?,
        cpu_ratio: Median::of(&of(|o, f| o.msamples_per_cpu_second() / f.msamples_per_cpu_second())),
        cpu_ray_ratio: Median::of(&of(|o, f| {
            o.rays * 1e-6 / o.cpu_seconds / (f.msamples_per_cpu_second() * f.rays_per_sample())
        })),
    })
}
