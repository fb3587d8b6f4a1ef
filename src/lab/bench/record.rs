//! The rays of a render, kept as its batches cast them.

use crate::embree::{Coherence, HitBatch, Scene, ShadowBatch};
use crate::geometry::Ray;
use crate::integrator::Task;
use crate::integrator::probe::{Cast, Probe, Watch};
use std::sync::Mutex;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Closest,
    Shadow,
}

/// Rays that a batch handed to Embree together.
#[derive(Clone, Debug)]
pub(crate) struct RecordedWave {
    pub(crate) kind: Kind,
    /// As [`Cast::depth`].
    pub(crate) depth: usize,
    pub(crate) coherence: Coherence,
    /// As they were before they were traced, in the renderer's order.
    pub(crate) rays: Vec<Ray>,
    /// The path of each, by its place in the batch.
    pub(crate) slots: Vec<u32>,
    /// How many met something.
    pub(crate) found: usize,
}

/// All waves of a render, batch by batch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recording {
    pub(crate) batches: Vec<Vec<RecordedWave>>,
}

impl Recording {
    /// Rays of one kind.
    pub(crate) fn rays(&self, kind: Kind) -> usize {
        self.batches.iter().flatten().filter(|wave| wave.kind == kind).map(|wave| wave.rays.len()).sum()
    }
}

/// Records a render: about 32 bytes a ray.
#[derive(Default)]
pub(crate) struct Recorder {
    batches: Mutex<Vec<(Task, Vec<RecordedWave>)>>,
}

impl Recorder {
    /// What was recorded, in an order that does not depend on threads.
    pub(crate) fn finish(self) -> Recording {
        let mut batches = self.batches.into_inner().expect("no thread fails while it holds the lock");
        batches.sort_by_key(|(task, _)| (task.first_sample, task.tile.y, task.tile.x));
        Recording { batches: batches.into_iter().map(|(_, waves)| waves).collect() }
    }
}

impl Watch for Recorder {
    type Probe = Vec<RecordedWave>;

    fn begin(&self, _task: &Task) -> Self::Probe {
        Vec::new()
    }

    fn end(&self, task: &Task, probe: Self::Probe) {
        self.batches.lock().expect("no thread fails while it holds the lock").push((*task, probe));
    }
}

impl Probe for Vec<RecordedWave> {
    fn trace(&mut self, cast: Cast<HitBatch>, scene: &Scene, coherence: Coherence) {
        let rays: Vec<Ray> = (0..cast.rays.len()).map(|i| cast.rays.ray(i)).collect();
        cast.rays.trace(scene, coherence);
        let found = (0..rays.len()).filter(|&i| cast.rays.hit(i).is_some()).count();
        let (kind, slots) = (Kind::Closest, (0..rays.len()).map(cast.slots).collect());
        self.push(RecordedWave { kind, depth: cast.depth, coherence, rays, slots, found });
    }

    fn trace_shadows(&mut self, cast: Cast<ShadowBatch>, scene: &Scene, coherence: Coherence) {
        let rays: Vec<Ray> = (0..cast.rays.len()).map(|i| cast.rays.ray(i)).collect();
        cast.rays.trace(scene, coherence);
        let found = (0..rays.len()).filter(|&i| cast.rays.occluded(i)).count();
        let (kind, slots) = (Kind::Shadow, (0..rays.len()).map(cast.slots).collect());
        self.push(RecordedWave { kind, depth: cast.depth, coherence, rays, slots, found });
    }
}
