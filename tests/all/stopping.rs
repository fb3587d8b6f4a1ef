//! Renders that are stopped in the middle of a pass: each pixel is the mean of the samples that it has, and says how many.

use crate::common::{Loaded, own};
use phototaxis::film::Combine;
use phototaxis::integrator::Task;
use phototaxis::integrator::probe::Watch;
use phototaxis::math::Rgb;
use phototaxis::render::{GuideIo, Order, Rendering, Settings, Stop, render, render_watched};
use std::sync::atomic::{AtomicUsize, Ordering};

/// 15 tiles, those of the last row not square.
const SMALL: [&str; 4] = ["film.width=160", "film.height=90", "guiding.method=none", "render.spp=64"];
const PIXELS: usize = 160 * 90;
const TILES: usize = 15;

/// States a wish when so many tasks have begun.
struct Stopper {
    stop: Stop,
    wish: fn(&Stop),
    begun: AtomicUsize,
    at: usize,
}

impl Watch for Stopper {
    type Probe = ();

    fn begin(&self, _task: &Task) {
        if self.begun.fetch_add(1, Ordering::Relaxed) + 1 == self.at {
            (self.wish)(&self.stop);
        }
    }

    fn end(&self, _task: &Task, _probe: ()) {}
}

/// Renders on one thread, which takes tasks one after the other, until the task number `at` has begun.
fn stopped(loaded: &Loaded, settings: &Settings, keep: bool, wish: fn(&Stop), at: usize) -> Rendering {
    let watch = Stopper { stop: Stop::new(), wish, begun: AtomicUsize::new(0), at };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let keeping = GuideIo { from: None, keep };
    pool.install(|| render_watched(&loaded.scene, settings, keeping, &watch, &watch.stop, &mut |_| true))
}

fn counts(rendering: &Rendering) -> Vec<u32> {
    (0..rendering.estimate.mean.len()).map(|i| rendering.estimate.count(i)).collect()
}

fn is_close(a: Rgb, b: Rgb, tolerance: f32) -> bool {
    (a - b).abs().max_element() <= tolerance * b.max_element()
}

/// Unguided samples are the same in every render: a pixel with n of them is that of a picture with n.
fn assert_means_of_own_samples(loaded: &Loaded, settings: &Settings, rendering: &Rendering) {
    let counts = counts(rendering);
    let mut different = counts.clone();
    different.sort_unstable();
    different.dedup();
    for &n in different.iter().filter(|&&n| n > 0) {
        let mut settings = settings.clone();
        settings.render.spp = n;
        let full = render(&loaded.scene, &settings, &mut |_| true).estimate;
        for i in (0..counts.len()).filter(|&i| counts[i] == n) {
            let (mean, variance) = (rendering.estimate.mean[i], rendering.estimate.variance[i]);
            assert!(is_close(mean, full.mean[i], 1e-4), "pixel {i} of {n}: {mean} and {}", full.mean[i]);
            let depths = [&rendering.estimate, &full].map(|e| e.features[i].depth);
            assert!((depths[0] - depths[1]).abs() <= 1e-4 * depths[1], "pixel {i} of {n}: {depths:?}");
            assert!(variance.is_finite() && variance.min_element() >= 0.0);
        }
    }
    for i in (0..counts.len()).filter(|&i| counts[i] == 0) {
        assert_eq!(rendering.estimate.mean[i], Rgb::ZERO);
    }
}

#[test]
fn a_pass_that_is_cut_leaves_each_pixel_with_the_mean_of_its_own_samples() {
    let loaded = own("cornell", &SMALL);
    let mut settings = loaded.settings.clone();
    settings.render.combine = Combine::All;
    // iterations of 1, 2, 4 and 8 samples, each in two passes of 4 at most: the second half of the fourth, and the very first
    for (at, whole, more) in [(6 * TILES + 6, 11, 4), (6, 0, 1)] {
        let rendering = stopped(&loaded, &settings, false, Stop::insist, at);
        let counts = counts(&rendering);
        // the task under way is given up: the picture has those before it
        let ahead = counts.iter().filter(|&&n| n == whole + more).count();
        assert!((5 * 32 * 26..=5 * 32 * 32).contains(&ahead), "{ahead} pixels of five tiles");
        assert_eq!(counts.iter().filter(|&&n| n == whole).count(), PIXELS - ahead);
        let paths: u64 = rendering.iterations.iter().map(|i| i.counters.paths).sum();
        assert_eq!(paths, counts.iter().map(|&n| u64::from(n)).sum::<u64>(), "what was traced is in the picture");
        assert_eq!(u64::from(rendering.samples), paths / PIXELS as u64);
        assert_means_of_own_samples(&loaded, &settings, &rendering);
    }
}

#[test]
fn a_short_pass_is_finished_unless_somebody_insists() {
    let loaded = own("cornell", &SMALL);
    let rendering = stopped(&loaded, &loaded.settings, false, Stop::ask, 2 * TILES + 3);
    assert_eq!((rendering.samples, rendering.estimate.spread()), (3, (3, 3, 0)), "all of the third pass");
}

#[test]
fn blocks_may_be_cut_too() {
    let loaded = own("cornell", &SMALL);
    let mut settings = loaded.settings.clone();
    (settings.render.order, settings.render.combine) = (Order::Blocks, Combine::All);
    // a block is 16 tasks; the first stretch has four
    let rendering = stopped(&loaded, &settings, false, Stop::insist, 16 + 6);
    assert_eq!(rendering.estimate.spread(), (0, 64, PIXELS - 2 * 1024));
    assert_eq!(counts(&rendering).iter().filter(|&&n| n == 20).count(), 1024, "five tasks of the second block");
    assert_means_of_own_samples(&loaded, &settings, &rendering);
}

#[test]
fn a_guided_render_that_is_cut_has_a_picture_and_a_guide() {
    let loaded = own("cornell", &["film.width=160", "film.height=90", "guiding.method=grid", "render.spp=64"]);
    for wish in [Stop::ask, Stop::insist] {
        let rendering = stopped(&loaded, &loaded.settings, true, wish, 7 * TILES + 6);
        assert!(rendering.guide.as_ref().is_some_and(|guide| guide.states() > 0));
        let (least, most, blank) = rendering.estimate.spread();
        assert!((15..=19).contains(&least) && most <= 19 && blank == 0, "{least} to {most}");
        let full = loaded.render(&loaded.settings);
        let mean = |r: &Rendering| r.estimate.mean.iter().map(|c| f64::from(c.y)).sum::<f64>() / PIXELS as f64;
        let noise =
            |r: &Rendering| r.estimate.variance.iter().map(|c| f64::from(c.y)).sum::<f64>().sqrt() / PIXELS as f64;
        let error = noise(&rendering).hypot(noise(&full));
        // 5 standard errors: a false alarm in 2 million
        assert!((mean(&rendering) - mean(&full)).abs() < 5.0 * error, "{} ± {error}", mean(&rendering) - mean(&full));
        assert!(rendering.estimate.mean.iter().all(|c| c.is_finite()));
    }
}

#[test]
fn time_cuts_a_long_pass_but_leaves_no_pixel_without_samples() {
    let loaded = own("cornell", &["film.width=640", "film.height=480", "guiding.method=none", "render.spp=1"]);
    let render = |settings: &Settings| render(&loaded.scene, settings, &mut |_| true);
    // a limit in the middle of the second pass, as long as nobody else takes the processors meanwhile
    let cut = (0..8).any(|_| {
        let mut settings = loaded.settings.clone();
        let pass = render(&settings).wall_seconds;
        (settings.render.spp, settings.render.time) = (1 << 20, Some(2.0 * pass));
        let rendering = render(&settings);
        let (least, most, blank) = rendering.estimate.spread();
        assert_eq!(blank, 0);
        (1..most).contains(&least)
    });
    assert!(cut, "no pass was ever cut");
}
