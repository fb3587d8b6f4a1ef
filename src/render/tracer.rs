//! Rounds of tasks: all threads trace those of one while picture and guide take in what those before have brought.

use super::driver::Job;
use super::limits::PassEnd;
use super::policy::Mode;
use super::schedule::rounds;
use super::state::{Record, RenderState};
use super::workers::{BufferPool, PendingResults, Shared, WorkQueue, WorkerResult};
use crate::integrator::path::GuideUse;
use crate::integrator::probe::Watch;
use crate::integrator::{BatchResult, PathIntegrator, Task};
use std::sync::Mutex;

/// Paths for each thread that are traced together while the guide learns. What they bring takes memory until it is learnt,
/// and again as much what is traced meanwhile: few paths stay in caches, very few leave threads waiting. No result
/// depends on it, as all is learnt in its order.
const LEARNING_PATHS: usize = 1 << 15;

/// What is kept from round to round; of it, only buffers from iteration to iteration.
#[derive(Default)]
pub(super) struct Tracer {
    pending: PendingResults,
    pool: BufferPool,
}

/// What the tasks of a round work on, and when they end.
pub(super) struct Target<'r, 'a, W> {
    pub job: &'r Job<'a, W>,
    pub state: &'r mut RenderState,
    pub record: &'r mut Record,
    pub end: PassEnd<'a>,
}

impl Tracer {
    /// Whether a round that begins now is learnt from, in an iteration that is to be learnt from if `learn`.
    pub fn learns<W: Watch>(&mut self, target: &mut Target<W>, learn: bool) -> bool {
        learn && (target.state.is_online(target.job.settings) || self.can_learn_more(target))
    }

    /// Traces the tasks of a round, and returns how many were: all unless rendering is to end, else the first of them. What
    /// they bring is taken in with the next tasks, or by [`Self::take_in`].
    pub fn round<W: Watch>(&mut self, target: &mut Target<W>, round: &[Task], learn: bool) -> usize {
        let online = target.state.is_online(target.job.settings);
        let most = if learn { LEARNING_PATHS * rayon::current_num_threads() } else { usize::MAX };
        let mut done = 0;
        for part in rounds(round, most) {
            if target.end.cuts_round() {
                break;
            }
            self.trace(target, &part, learn);
            done += self.pending.tasks.len();
        }
        if online {
            self.take_in(target);
            if let Some(guide) = target.state.guide.as_mut().filter(|_| learn) {
                target.record.report.add_learning(|| guide.refresh());
            }
        }
        done
    }

    /// Picture and guide take what the last tasks brought.
    pub fn take_in<W: Watch>(&mut self, target: &mut Target<W>) {
        self.work(target, &[], false);
    }

    fn trace<W: Watch>(&mut self, target: &mut Target<W>, tasks: &[Task], learn: bool) {
        let (tasks, results): (Vec<Task>, Vec<BatchResult>) = self.work(target, tasks, learn).into_iter().unzip();
        for (task, result) in tasks.iter().zip(&results) {
            target.state.add_bounced(&task.tile, &result.bounced);
            target.record.add(&result.counters);
            target.state.paths += result.counters.paths;
        }
        self.pending = PendingResults { tasks, results };
    }

    /// Whether a frozen guide still learns in this iteration.
    fn can_learn_more<W: Watch>(&mut self, target: &mut Target<W>) -> bool {
        let transitions = target.record.report.counters.transitions;
        let enough = |state: &RenderState| state.guide.as_ref().is_some_and(|guide| guide.has_enough(transitions));
        // what is yet to be taken in may bring states, which ask for more, and never takes any
        if enough(target.state) && !self.pending.recorders().is_empty() {
            self.take_in(target);
        }
        !enough(target.state)
    }

    /// All threads trace tasks, and take in what the last brought; returns the first of the tasks, all that were traced
    /// before one that was not, and what they brought: so a render that goes on later knows which are left.
    fn work<W: Watch>(&mut self, target: &mut Target<W>, tasks: &[Task], learn: bool) -> Vec<(Task, BatchResult)> {
        let pending = std::mem::take(&mut self.pending);
        let Target { job, state, record, end } = target;
        let (guided, recorders) = (state.is_guided(), pending.recorders());
        let (field, lessons) = match state.guide.as_mut() {
            Some(guide) if !recorders.is_empty() && !end.ends_learning() => {
                let (field, lessons) = record.report.add_learning(|| guide.update_jobs(&recorders));
                (Some(field), lessons)
            }
            guide => (guide.map(|guide| guide.field()), Vec::new()),
        };
        let (guiding, efficiency) = (&job.settings.guiding, state.roulette.as_ref());
        let integrator = PathIntegrator {
            scene: job.scene,
            camera: job.camera,
            settings: &job.settings.integrator,
            guide: field.filter(|_| guided).map(|field| GuideUse { field, settings: guiding, learn, efficiency }),
            seed: state.seed,
            sampler: job.settings.render.sampler,
            sequence: state.sequence,
            features: false,
            ids: job.settings.render.wants_ids(),
            bounced: state.plan.mode == Mode::Pilot,
            layers: &state.layers,
        };
        let queue = WorkQueue {
            integrator,
            watch: job.watch,
            end: *end,
            pool: &self.pool,
            tasks: Shared::new(tasks.iter().enumerate()),
            film: Mutex::new(Some(&mut state.film)),
            pending: &pending,
            lessons: Shared::new(lessons.into_iter()),
        };
        let shares = queue.run();
        record.report.add_shares(&shares);
        let most = tasks.len().max(pending.tasks.len());
        self.pool.keep(pending.emptied(), most);
        let first = in_order(shares).enumerate().take_while(|(place, (k, _))| place == k);
        first.map(|(_, (k, result))| (tasks[k], result)).collect()
    }
}

fn in_order(shares: Vec<WorkerResult>) -> impl Iterator<Item = (usize, BatchResult)> {
    let mut results: Vec<_> = shares.into_iter().flat_map(|share| share.results).collect();
    results.sort_unstable_by_key(|(k, _)| *k);
    results.into_iter()
}
