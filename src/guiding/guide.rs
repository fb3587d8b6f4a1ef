//! A guide: a partition of space, a model of directions, and what is learnt of both.

use super::bsdf_fraction::logit;
use super::directional::{DirectionalModel, Model, SamplingOptions};
use super::memory::usual_region_bytes;
use super::persist::Stored;
use super::recorder::Recorder;
use super::schedule::Schedule;
use super::settings::{GuidingMethod, GuidingSettings, Rate};
use super::snapshot::Snapshot;
use super::spatial::{Partition, SpatialPartition};
use super::store::RegionStore;
use super::update_job::{Rules, UpdateJob};
use super::{ppg, refinement};
use glam::Vec3;
use rayon::prelude::*;

/// A guide of any partition `S` and any directional model `D`: what it has learnt so far, and the snapshot that is in use.
pub struct Guide<S: SpatialPartition = Partition, D: DirectionalModel = Model> {
    pub(super) partition: S,
    pub(super) store: RegionStore<D>,
    pub(super) snapshot: Snapshot<S, D>,
    method: GuidingMethod,
    schedule: Schedule,
    pub(super) rate: Rate,
    /// Logit of the BSDF's share where nothing is known yet.
    pub(super) origin: f32,
    /// An iteration ended, and the next one has not begun to learn: only then do earlier visits lose weight.
    pub(super) ended: bool,
    /// Bytes for partition and regions.
    memory: usize,
    /// Camera paths of all iterations that ended.
    pub(super) learnt_paths: f64,
    /// By how much of that the iteration under way, or the next, adds to it; 1 unless it is said.
    pub(super) growth: f64,
    /// What the snapshot was made of, where somebody asked for that and it may be something else than what is known.
    pub(super) remembered: Option<Stored<'static, S, D>>,
}

impl Guide {
    /// The guide that the settings ask for; `None` renders without one. `bounds` are the scene's, and `triangles` all
    /// of its surfaces, in world space: Voronoi sites are spread over them where the settings say so.
    pub fn new(
        settings: &GuidingSettings,
        bounds: (Vec3, Vec3),
        triangles: impl Iterator<Item = [Vec3; 3]> + Clone,
    ) -> Option<Guide> {
        let model = Model::new(settings);
        let partition = Partition::new(settings, bounds, triangles, usual_region_bytes(&model))?;
        Some(Guide::of(settings, partition, model))
    }
}

impl<S: SpatialPartition, D: DirectionalModel> Guide<S, D> {
    /// A guide of this partition and this model, which may be any; of the settings, those of schedule, sampling, learning
    /// and memory count.
    pub(super) fn of(settings: &GuidingSettings, partition: S, model: D) -> Guide<S, D> {
        let options = SamplingOptions {
            sampling: settings.sampling,
            bsdf_fraction: settings.bsdf_fraction,
            learnt_fraction: settings.learns_fraction(),
            compensation: settings.mis_compensation,
            smoothing: settings.smoothing,
        };
        let schedule = match settings.method {
            GuidingMethod::SdTree => Schedule::Ppg(ppg::SplitLimits { samples: settings.leaf_samples }),
            _ => Schedule::Continuous(refinement::DivisionLimits {
                visits: settings.refine_visits,
                difference: settings.refine_difference,
            }),
        };
        let memory = usize::try_from(settings.memory).unwrap_or(usize::MAX);
        let left = memory.saturating_sub(partition.bytes());
        let snapshot = Snapshot::empty(partition.frozen(), model.clone(), options, schedule.min_visits());
        let store = RegionStore::new(model, left, schedule.divides_only());
        let (rate, origin) = (settings.rate, logit(settings.bsdf_fraction));
        let method = settings.method.model();
        Guide {
            partition,
            store,
            snapshot,
            method,
            schedule,
            rate,
            origin,
            ended: false,
            memory,
            learnt_paths: 0.0,
            growth: 1.0,
            remembered: None,
        }
    }

    /// Whether it matters to the partition where paths will go.
    pub(crate) fn adapts_to_vertices(&self) -> bool {
        self.partition.adapts_to_vertices()
    }

    /// Says where paths will go, by some of their vertices (world space) with normals, before anything is learnt.
    pub(crate) fn expect_vertices(&mut self, vertices: &[(Vec3, Vec3)]) {
        self.partition.expect_vertices(vertices);
        self.freeze();
    }

    /// Camera paths of all iterations that ended.
    pub fn learnt_paths(&self) -> u64 {
        self.learnt_paths as u64
    }

    pub fn method(&self) -> GuidingMethod {
        self.method
    }

    /// The snapshot of this iteration.
    pub fn field(&self) -> &Snapshot<S, D> {
        &self.snapshot
    }

    /// Begins an iteration of `paths` camera paths: the longer it is beside what was learnt, the more of that is forgotten.
    pub fn begin_iteration(&mut self, paths: u64) {
        self.growth = paths as f64 / self.learnt_paths.max(1.0);
    }

    /// Learns from what tiles recorded, in their order. The snapshot stays as it is.
    pub fn learn(&mut self, recorders: &[&Recorder]) {
        self.update_jobs(recorders).1.into_par_iter().for_each(UpdateJob::learn);
    }

    /// What is to be learnt of what tiles recorded, in parts, for any threads in any order; and the snapshot, which may be
    /// in use meanwhile.
    pub fn update_jobs<'a>(
        &'a mut self,
        recorders: &'a [&'a Recorder],
    ) -> (&'a Snapshot<S, D>, Vec<UpdateJob<'a, S, D>>) {
        recorders.iter().for_each(|recorder| self.partition.observe(recorder.points()));
        self.forget();
        let (shards, model, room) = self.store.parts_mut();
        let rules = Rules { partition: &self.partition, model, rate: self.rate, origin: self.origin, room };
        let job = |(number, shard)| UpdateJob { rules, shard, number, recorders };
        (&self.snapshot, shards.iter_mut().enumerate().map(job).collect())
    }

    /// Begins to learn from an iteration, if that has not begun: earlier visits lose weight.
    pub(super) fn forget(&mut self) {
        if std::mem::take(&mut self.ended) {
            let retain = self.schedule.retain(self.rate, self.growth);
            self.store.for_each(|model, region| {
                region.decay(model, retain);
                region.begin();
            });
        }
    }

    /// What was learnt so far becomes the snapshot, in the middle of an iteration: the paper's on-line updates. Of the
    /// schedule that learns from whole iterations, it stays as it is.
    pub fn refresh(&mut self) {
        if self.refreshes() {
            self.freeze();
        }
    }

    pub(super) fn refreshes(&self) -> bool {
        self.schedule.refreshes()
    }

    pub(super) fn freeze(&mut self) {
        self.remembered = None;
        self.snapshot.freeze(&self.partition, &self.store);
    }

    /// Ends an iteration of `paths` camera paths: regions and their directions are refined, and what was learnt becomes
    /// the next snapshot.
    pub fn end_iteration(&mut self, paths: u64) {
        if self.partition.settle() {
            self.make_room();
        }
        self.store.end_iteration();
        self.schedule.divide(&mut self.partition, &mut self.store, paths);
        self.store.refine_directions();
        self.freeze();
        self.learnt_paths += paths as f64;
        self.ended = true;
    }

    /// Leaves the regions what the partition does not take.
    pub(super) fn make_room(&mut self) {
        self.store.keep_within(self.memory.saturating_sub(self.partition.bytes()));
    }

    /// Whether an iteration that recorded so many transitions has taught enough.
    pub fn has_enough(&self, transitions: u64) -> bool {
        self.schedule.has_enough(&self.partition, transitions, self.states(), self.growth)
    }

    /// Regions that something is known of.
    pub fn states(&self) -> usize {
        self.store.len()
    }

    /// Bytes of partition, regions and snapshot.
    pub fn bytes(&self) -> usize {
        self.store.bytes() + self.partition.bytes()
    }
}
