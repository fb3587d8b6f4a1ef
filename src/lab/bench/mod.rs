//! Measurements: how much of a render's time is Embree's, what the rest goes into, what loading costs, and how another
//! renderer does on the same work.
//!
//! Whatever is compared takes turns, so that a machine that changes its pace slows all alike; a figure is the median
//! over the turns with the interval of [`crate::stats::median`], a ratio the median of the ratios within turns.

mod clock;
mod cpu;
mod load;
mod mitsuba;
mod own;
mod pathtracer;
mod rays;
mod record;
mod replay;
mod stages;

#[cfg(test)]
mod tests;

pub(crate) use load::{LoadReport, load};
pub(crate) use mitsuba::{Mitsuba, MitsubaPlan, MitsubaReport};
pub use pathtracer::{EmbreeFigures, EmbreePlan, EmbreeReport, PointLight, embree, find_pathtracer};
pub(crate) use rays::{RaysReport, ReplayFigure, WholeFigure, rays};
pub(crate) use replay::RayOrder;
pub(crate) use stages::{MethodReport, render};

use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::render::Settings;
use crate::stats::Median;
use crate::{Error, Result};

/// What a scene file says of rendering, with this guide.
fn settings(description: &SceneFile, method: GuidingMethod) -> Settings {
    let mut guiding = description.guiding.clone();
    guiding.method = method;
    Settings { integrator: description.integrator.clone(), guiding, render: description.render.clone() }
}

/// The median of a measurement's turns.
fn median(values: &[f64]) -> Result<Median> {
    Median::of(values).ok_or_else(|| Error::Scene("a measurement took no time, or too little to be seen".into()))
}

/// Runs `work` with so many of rayon's threads.
fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    Ok(pool.map_err(|error| Error::Scene(format!("{threads} threads: {error}")))?.install(work))
}
