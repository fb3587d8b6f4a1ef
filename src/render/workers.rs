//! What all threads work on together: tasks to trace, results for the picture, lessons for the guide.

use super::limits::PassEnd;
use crate::film::accumulate::{FEATURE_SAMPLES, Film};
use crate::guiding::{Recorder, UpdateJob};
use crate::integrator::probe::Watch;
use crate::integrator::{Batch, BatchResult, PathIntegrator, Task};
use crate::io::clock::{CpuClock, CpuTime, WallClock};
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What was traced, until picture and guide have taken what it brought.
#[derive(Default)]
pub(super) struct PendingResults {
    pub tasks: Vec<Task>,
    pub results: Vec<BatchResult>,
}

impl PendingResults {
    pub fn recorders(&self) -> Vec<&Recorder> {
        self.results.iter().filter_map(|result| result.recorder.as_ref()).collect()
    }

    pub fn emptied(self) -> impl Iterator<Item = Recorder> {
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
    pub fn keep(&self, recorders: impl Iterator<Item = Recorder>, most: usize) {
        let mut kept = lock(&self.recorders);
        kept.extend(recorders);
        kept.truncate(most);
    }
}

/// Each thread takes the next piece when it is done with its last. Tasks are long and come first, lessons are short: threads
/// end together.
pub(super) struct WorkQueue<'a, W> {
    /// Of one task; whether it averages what the camera sees first depends on the task.
    pub integrator: PathIntegrator<'a>,
    pub watch: &'a W,
    pub end: PassEnd<'a>,
    pub pool: &'a BufferPool,
    pub tasks: Shared<std::iter::Enumerate<std::slice::Iter<'a, Task>>>,
    /// The film, and what was traced before, which the first thread that comes adds to it.
    pub film: Mutex<Option<&'a mut Film>>,
    pub pending: &'a PendingResults,
    pub lessons: Shared<std::vec::IntoIter<UpdateJob<'a>>>,
}

/// What a thread has done.
pub(super) struct WorkerResult {
    /// With the numbers of their tasks.
    pub results: Vec<(usize, BatchResult)>,
    /// Wall time of adding to the film.
    pub film: Duration,
    /// Wall time and processor time of lessons.
    pub learning: (Duration, CpuTime),
}

impl<W: Watch> WorkQueue<'_, W> {
    /// Has all threads of the pool work until nothing is left.
    pub fn run(&self) -> Vec<WorkerResult> {
        let threads = rayon::current_num_threads();
        (0..threads).into_par_iter().with_max_len(1).map(|_| self.work()).collect()
    }

    fn work(&self) -> WorkerResult {
        let film = self.add_to_film();
        let mut results = Vec::new();
        let mut batch = pop(&self.pool.batches);
        while !self.end.cuts_round()
            && let Some((k, task)) = self.tasks.next()
        {
            results.extend(self.trace(task, &mut batch).map(|result| (k, result)));
        }
        lock(&self.pool.batches).push(batch);
        WorkerResult { results, film, learning: self.learn() }
    }

    fn add_to_film(&self) -> Duration {
        let clock = WallClock::start();
        // the lock is not held while the film is used: others go on
        let film = lock(&self.film).take();
        if let Some(film) = film {
            let brought = self.pending.tasks.iter().zip(&self.pending.results);
            brought.for_each(|(task, result)| film.add(&task.tile, &result.samples));
        }
        clock.elapsed()
    }

    fn learn(&self) -> (Duration, CpuTime) {
        let (wall, cpu) = (WallClock::start(), CpuClock::thread());
        let mut learnt = false;
        while !self.end.ends_learning()
            && let Some(lesson) = self.lessons.next()
        {
            lesson.learn();
            learnt = true;
        }
        // reading clocks takes time too, and is no learning
        if learnt { (wall.elapsed(), cpu.elapsed()) } else { Default::default() }
    }

    /// `None` where it was given up.
    fn trace(&self, task: &Task, batch: &mut Batch) -> Option<BatchResult> {
        if self.integrator.guide.is_some_and(|guide| guide.learn) {
            batch.recorder = pop(&self.pool.recorders);
        }
        let mut probe = self.watch.begin(task);
        let integrator = PathIntegrator { features: task.first_sample < FEATURE_SAMPLES, ..self.integrator };
        let result = integrator.render_probed(task, batch, &mut probe, self.end.stop)?;
        self.watch.end(task, probe);
        Some(result)
    }
}

/// Pieces that threads share.
pub(super) struct Shared<I>(Mutex<I>);

impl<I: Iterator> Shared<I> {
    pub fn new(pieces: I) -> Shared<I> {
        Shared(Mutex::new(pieces))
    }

    /// The next piece. The lock is not held while it is used.
    fn next(&self) -> Option<I::Item> {
        lock(&self.0).next()
    }
}

fn pop<T: Default>(pool: &Mutex<Vec<T>>) -> T {
    lock(pool).pop().unwrap_or_default()
}

/// Whoever panics ends the render.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
