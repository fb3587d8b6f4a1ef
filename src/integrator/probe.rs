//! Watching a renderer at work, for measurements: which rays it casts, and what its time goes into.
//!
//! The integrator is generic over its [`Probe`]. That of a usual render is `()`, whose calls are empty and compile to
//! nothing; only a measurement pays for what it measures.

use super::Task;
use crate::embree::{Coherence, HitBatch, Scene, ShadowBatch};

/// What a batch is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Camera rays.
    Generate,
    /// Closest hits and shadow rays, by Embree.
    Intersect,
    /// Surfaces: interpolation, emission, BSDFs, the next direction.
    Shade,
    /// A light drawn and weighed, its shadow ray made, and what it brings added up.
    NextEvent,
    /// The guide's state found, its table read, its distribution made ready. Draws and densities count where they are
    /// asked for, in [`Stage::Shade`] and [`Stage::NextEvent`].
    Guide,
    /// What is kept of vertices for learning, and the backward pass over them.
    Record,
    /// Sums over the samples of each pixel.
    Film,
}

impl Stage {
    pub(crate) const ALL: [Stage; 7] =
        [Stage::Generate, Stage::Intersect, Stage::Shade, Stage::NextEvent, Stage::Guide, Stage::Record, Stage::Film];
}

/// Rays of a wave and the paths they belong to.
pub(crate) struct Cast<'a, Rays> {
    pub(crate) rays: &'a mut Rays,
    /// Place of each ray's path in its batch.
    pub(crate) slots: &'a dyn Fn(usize) -> u32,
    /// Segments from the camera, from 1: of the rays, or up to the vertex that shadow rays leave.
    pub(crate) depth: usize,
}

/// Watches one batch. Everything has a body that watches nothing.
#[expect(private_interfaces, reason = "outside this crate only `()` watches batches, and it needs none of their types")]
pub trait Probe {
    /// Finds the closest hits of a wave.
    #[inline(always)]
    fn trace(&mut self, cast: Cast<HitBatch>, scene: &Scene, coherence: Coherence) {
        cast.rays.trace(scene, coherence);
    }

    /// Answers the shadow rays of a wave.
    #[inline(always)]
    fn trace_shadows(&mut self, cast: Cast<ShadowBatch>, scene: &Scene, coherence: Coherence) {
        cast.rays.trace(scene, coherence);
    }

    /// The batch goes over to another stage: a few times in a wave.
    #[inline(always)]
    fn stage(&mut self, _stage: Stage) {}

    /// The same within the work on one vertex: a few times for each.
    #[inline(always)]
    fn step(&mut self, _stage: Stage) {}
}

impl Probe for () {}

/// Gives each batch of a render its probe, and takes it back. Batches run on any thread, in any order.
pub trait Watch: Sync {
    type Probe: Probe;

    fn begin(&self, task: &Task) -> Self::Probe;

    fn end(&self, task: &Task, probe: Self::Probe);
}

impl Watch for () {
    type Probe = ();

    #[inline(always)]
    fn begin(&self, _task: &Task) {}

    #[inline(always)]
    fn end(&self, _task: &Task, _probe: ()) {}
}
