//! A round: its tasks are traced by all threads, which meanwhile take what those before brought into the picture and the
//! guide.

use super::IterationReport;
use super::driver::{Driver, timed};
use super::end::End;
use super::schedule::rounds;
use crate::film::accumulate::{FEATURE_SAMPLES, Film};
use crate::guiding::{Recorder, UpdateJob};
use crate::integrator::path::GuideUse;
use crate::integrator::probe::Watch;
use crate::integrator::{Batch, BatchResult, PathIntegrator, Task};
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Paths for each thread that are traced together while the guide learns. What they bring takes memory until it is learnt,
/// and again as much what is traced meanwhile: few paths stay in caches, very few leave threads waiting. No result
/// depends on it, as all is learnt in its order.
const LEARNING_PATHS: usize = 1 << 15;

/// What was traced, until picture and guide have taken what it brought.
#[derive(Default)]
pub(super) struct PendingResults {
    tasks: Vec<Task>,
    results: Vec<BatchResult>,
}

impl PendingResults {
    fn recorders(&self) -> Vec<&Recorder> {
        self.results.iter().filter_map(|result| result.recorder.as_ref()).collect()
    }

    fn emptied(self) -> impl Iterator<Item = Recorder> {
        self.results.into_iter().filter_map(|result| result.recorder).map(Recorder::emptied)
    }
}

/// Buffers that are used again from round to round: fresh memory costs page faults, more than writing to it does.
#[derive(Default)]
pub(super) struct BufferPool {
    batches: Mutex<Vec<Batch>>,
    recorders: Mutex<Vec<Recorder>>,
}

impl BufferPool {
    fn keep(&self, recorders: impl Iterator<Item = Recorder>, most: usize) {
        let mut kept = lock(&self.recorders);
        kept.extend(recorders);
        kept.truncate(most);
    }
}

/// What all threads work on together, each taking the next piece when it is done with its last. Tasks are long and come
/// first, lessons are short: threads end together.
struct WorkQueue<'a, W> {
    integrator: PathIntegrator<'a>,
    watch: &'a W,
    end: End<'a>,
    spare: &'a BufferPool,
    tasks: Mutex<std::iter::Enumerate<std::slice::Iter<'a, Task>>>,
    film: Mutex<Option<&'a mut Film>>,
    traced: &'a PendingResults,
    lessons: Mutex<std::vec::IntoIter<UpdateJob<'a>>>,
}

/// One thread's share of it: results with the numbers of their tasks.
struct WorkerResult {
    results: Vec<(usize, BatchResult)>,
    film: Duration,
    learning: Duration,
}

impl<W: Watch> WorkQueue<'_, W> {
    fn work(&self) -> WorkerResult {
        let film = timed(|| {
            if let Some(film) = lock(&self.film).take() {
                let brought = self.traced.tasks.iter().zip(&self.traced.results);
                brought.for_each(|(task, result)| film.add(&task.tile, &result.samples));
            }
        });
        let mut results = Vec::new();
        let mut batch = pop(&self.spare.batches);
        while !self.end.is_due()
            && let Some((k, task)) = next(&self.tasks)
        {
            results.extend(self.trace(task, &mut batch).map(|result| (k, result)));
        }
        lock(&self.spare.batches).push(batch);
        let mut learning = Duration::ZERO;
        while !self.end.is_urgent()
            && let Some(lesson) = next(&self.lessons)
        {
            learning += timed(|| lesson.learn());
        }
        WorkerResult { results, film, learning }
    }

    /// `None` where it was given up.
    fn trace(&self, task: &Task, batch: &mut Batch) -> Option<BatchResult> {
        if self.integrator.guide.is_some_and(|guide| guide.learn) {
            batch.recorder = pop(&self.spare.recorders);
        }
        let mut probe = self.watch.begin(task);
        let integrator = PathIntegrator { features: task.first_sample < FEATURE_SAMPLES, ..self.integrator };
        let result = integrator.render_probed(task, batch, &mut probe, self.end.stop)?;
        self.watch.end(task, probe);
        Some(result)
    }
}

impl<W: Watch> Driver<'_, W> {
    /// Traces the tasks of a round, and returns those that were traced, which are all unless rendering is to end. What
    /// they bring is taken in with the next tasks, or by [`Self::take_in`].
    pub(super) fn round(&mut self, round: &[Task], learn: bool, report: &mut IterationReport) -> Vec<Task> {
        let learn = learn && self.can_learn_more(report);
        let most = if learn { LEARNING_PATHS * rayon::current_num_threads() } else { usize::MAX };
        let mut done = Vec::with_capacity(round.len());
        for part in rounds(round, most) {
            if self.end.is_due() {
                break;
            }
            self.trace(&part, learn, report);
            done.extend(&self.traced.tasks);
        }
        if self.online() {
            self.take_in(report);
            if let Some(guide) = self.guide.as_mut().filter(|_| learn) {
                report.learn_seconds += timed(|| guide.refresh()).as_secs_f64();
            }
        }
        done
    }

    fn trace(&mut self, tasks: &[Task], learn: bool, report: &mut IterationReport) {
        let (tasks, results): (Vec<Task>, Vec<BatchResult>) = self.work(tasks, learn, report).into_iter().unzip();
        for (task, result) in tasks.iter().zip(&results) {
            self.add_bounced(&task.tile, &result.bounced);
            report.counters.add(&result.counters);
            self.paths += result.counters.paths;
        }
        self.traced = PendingResults { tasks, results };
    }

    /// Picture and guide take what the last tasks brought.
    pub(super) fn take_in(&mut self, report: &mut IterationReport) {
        self.work(&[], false, report);
    }

    /// Whether the guide still learns in this iteration.
    fn can_learn_more(&mut self, report: &mut IterationReport) -> bool {
        let enough = |driver: &Self, transitions| driver.guide.as_ref().is_some_and(|g| g.has_enough(transitions));
        let transitions = report.counters.transitions;
        // what is yet to be taken in may bring states, which ask for more, and never takes any
        if !self.online() && enough(self, transitions) && !self.traced.recorders().is_empty() {
            self.take_in(report);
        }
        self.online() || !enough(self, transitions)
    }

    /// All threads trace tasks, and take in what the last brought; the tasks that were traced, in their order, and what
    /// they brought.
    fn work(&mut self, tasks: &[Task], learn: bool, report: &mut IterationReport) -> Vec<(Task, BatchResult)> {
        let traced = std::mem::take(&mut self.traced);
        let (guided, bounced, recorders) = (self.guided(), self.measures(), traced.recorders());
        let (field, lessons) = match self.guide.as_mut() {
            Some(guide) if !recorders.is_empty() && !self.end.is_urgent() => {
                let start = Instant::now();
                let (field, lessons) = guide.update_jobs(&recorders);
                report.learn_seconds += start.elapsed().as_secs_f64();
                (Some(field), lessons)
            }
            guide => (guide.map(|guide| guide.field()), Vec::new()),
        };
        let guide = field.filter(|_| guided).map(|field| GuideUse {
            field,
            settings: &self.settings.guiding,
            learn,
            efficiency: self.efficiency.as_ref(),
        });
        let (scene, settings) = (self.scene, &self.settings.integrator);
        let crew = WorkQueue {
            integrator: PathIntegrator { scene, settings, guide, seed: self.seed, features: false, bounced },
            watch: self.watch,
            end: self.end,
            spare: &self.spare,
            tasks: Mutex::new(tasks.iter().enumerate()),
            film: Mutex::new(Some(&mut self.film)),
            traced: &traced,
            lessons: Mutex::new(lessons.into_iter()),
        };
        let threads = rayon::current_num_threads();
        let shares: Vec<WorkerResult> = (0..threads).into_par_iter().with_max_len(1).map(|_| crew.work()).collect();
        report.add_times(&shares);
        let most = tasks.len().max(traced.tasks.len());
        self.spare.keep(traced.emptied(), most);
        in_order(shares).map(|(k, result)| (tasks[k], result)).collect()
    }
}

impl IterationReport {
    /// Adds what threads did beside tracing, as if all of them had done nothing else meanwhile.
    fn add_times(&mut self, shares: &[WorkerResult]) {
        let whole = |of: fn(&WorkerResult) -> Duration| shares.iter().map(of).sum::<Duration>().as_secs_f64();
        self.film_seconds += whole(|share| share.film) / shares.len() as f64;
        self.learn_seconds += whole(|share| share.learning) / shares.len() as f64;
    }
}

fn in_order(shares: Vec<WorkerResult>) -> impl Iterator<Item = (usize, BatchResult)> {
    let mut results: Vec<_> = shares.into_iter().flat_map(|share| share.results).collect();
    results.sort_unstable_by_key(|(k, _)| *k);
    results.into_iter()
}

/// The next piece of what threads share; apart from its use, so that others need not wait for that.
fn next<I: Iterator>(pieces: &Mutex<I>) -> Option<I::Item> {
    lock(pieces).next()
}

fn pop<T: Default>(spare: &Mutex<Vec<T>>) -> T {
    lock(spare).pop().unwrap_or_default()
}

/// Whoever panics ends the render.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
