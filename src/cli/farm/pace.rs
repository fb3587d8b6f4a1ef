//! How many samples a time allows: by what a few of them take on this machine, drawn as the render will draw them.

use crate::cli::render::{Ready, settings, subject, trained};
use crate::cli::render_arguments::RenderArguments;
use crate::io::clock::WallClock;
use crate::render::checkpoint::Header;
use crate::render::part::{Part, Wanted, render_part};
use crate::render::{Settings, Stop, guide_file, lesson};
use crate::scene::Scene;
use anyhow::{Context as _, Result, ensure};
use std::path::Path;

/// Samples per pixel of the iterations that the guide learns from first: roulette knows the picture after so many.
const PILOT: [u32; 3] = [1, 2, 4];

/// Samples per pixel that are timed then.
const TIMED: u32 = 2;

/// Seconds of wall time on this machine.
pub(super) struct Pace {
    /// Until a task begins to render.
    start: f64,
    /// For a sample of each pixel.
    sample: f64,
}

impl Pace {
    pub fn measure(asked: &RenderArguments) -> Result<Pace> {
        let clock = WallClock::start();
        let ready = Ready::without_outputs(asked)?;
        let start = clock.elapsed().as_secs_f64();
        let settings = settings(&ready.description);
        let here = tempfile::tempdir()?;
        let guide = here.path().join("guide");
        let guided = asked.learn_out.is_some();
        for (k, samples) in PILOT.into_iter().enumerate().filter(|_| guided) {
            learn(&ready, &settings, samples, (k > 0).then_some(&*guide), &guide)?;
        }
        let guide = trained(guided.then_some(&*guide), &ready.scene, &ready.description)?;
        let clock = WallClock::start();
        render(&ready.scene, &settings, guide.as_ref(), TIMED, Wanted { film: true, lesson: false })?;
        Ok(Pace { start, sample: clock.elapsed().as_secs_f64() / f64::from(TIMED) })
    }

    /// Samples per pixel of a picture that as many `machines` as this one make within `seconds`, with learning beforehand that takes
    /// the share `learning` more. Of an iteration, parts and the guide come one after the other.
    pub fn samples(&self, seconds: f64, machines: u32, learning: f64) -> Result<u32> {
        let within = |iterations: f64| {
            let rendering = seconds - self.start * (2.0 * iterations + 2.0);
            rendering * f64::from(machines) / (self.sample * (1.0 + learning))
        };
        let iterations = if learning > 0.0 { (learning * within(0.0)).max(1.0).log2().ceil() + 1.0 } else { 0.0 };
        let samples = within(iterations);
        ensure!(
            samples >= 1.0,
            "--time {seconds}: it is over before the first sample: a task takes {:.1} s to begin, and a sample per pixel {:.1} s",
            self.start,
            self.sample
        );
        Ok(samples.min(f64::from(u32::MAX / 2)) as u32)
    }
}

fn render(
    scene: &Scene,
    settings: &Settings,
    guide: Option<&guide_file::LoadedGuide>,
    samples: u32,
    wanted: Wanted,
) -> Result<crate::render::part::Done> {
    let part = Part::of(1, 1, samples).context("there are samples")?;
    let done = render_part(scene, settings, guide, (part, wanted), &Stop::new(), &mut |_| true);
    done.context("nobody stops it")
}

/// An iteration of the guide at `from`, or of one that knows nothing.
fn learn(ready: &Ready, settings: &Settings, samples: u32, from: Option<&Path>, to: &Path) -> Result<()> {
    let Ready { scene, description, .. } = ready;
    let guide = trained(from, scene, description)?;
    let done = render(scene, settings, guide.as_ref(), samples, Wanted { film: false, lesson: true })?;
    let path = to.with_extension("lesson");
    done.write(&Header::new(scene, settings, ()), None, Some(&path))?;
    let taught = lesson::teach(scene, settings, guide, vec![lesson::open::<()>(&path)?])?;
    let subject = subject(scene, description);
    Ok(guide_file::write_with_view(to, &taught.guide, &subject, taught.paths, taught.view.as_ref())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_machines_and_more_time_make_more_samples() {
        let pace = Pace { start: 1.0, sample: 0.5 };
        let samples = |seconds, machines, learning| pace.samples(seconds, machines, learning).unwrap();
        assert_eq!(samples(102.0, 1, 0.0), 200);
        assert_eq!(samples(102.0, 4, 0.0), 800);
        // 4/3 of the work, and seven iterations of two starts each
        assert_eq!(samples(102.0, 1, 1.0 / 3.0), 129);
        assert!(pace.samples(1.9, 9, 0.0).is_err());
    }
}
