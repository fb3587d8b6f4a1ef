use super::super::{Rendering, Settings, render};
use super::*;
use crate::film::accumulate::Estimate;
use crate::format;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::Stop;
use crate::math::luminance;
use crate::scene::Scene;
use crate::stats::{ImageMoments, ImageZTest, z_test_images};
use std::path::Path;

const SPP: u32 = 16;

/// One of the project's scenes in a picture of 512 × 256 pixels, which is just large enough for training.
fn own(name: &str, method: GuidingMethod) -> (Scene, Settings) {
    let spp = format!("render.spp={SPP}");
    let set = ["film.width=512", "film.height=256", "integrator.max_depth=6", &spp].map(String::from);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, mut guiding, render) = (description.integrator, description.guiding, description.render);
    guiding.method = method;
    (scene, Settings { integrator, guiding, render })
}

fn rendered(name: &str, method: GuidingMethod) -> Rendering {
    let (scene, settings) = own(name, method);
    render(&scene, &settings, &mut |_| true)
}

/// Share of paths that found no light.
fn dark(report: &super::super::IterationReport) -> f64 {
    report.counters.zero_contribution as f64 / report.counters.paths as f64
}

#[test]
fn training_takes_a_share_of_the_budget_and_a_pass_at_most() {
    let (small, hd, uhd) = (1 << 15, 1280 * 720, 3840 * 2160);
    assert_eq!([4.0, 1e9].map(|budget| samples(small, budget)), [0, 0], "a pass over it is training");
    assert_eq!([2.0, 4.0, 8.0, 16.0, 1e9].map(|budget| samples(hd, budget)), [3, 7, 7, 15, 15]);
    assert_eq!(samples(uhd, 1e9), 127);
    for budget in 1..100 {
        let paths = u64::from(samples(hd, f64::from(budget))) * PIXELS;
        assert!(paths as f64 <= (SHARE * f64::from(budget)).min(1.0) * hd as f64);
    }
}

#[test]
fn a_trained_guide_finds_light_from_its_first_sample_on_whatever_the_number_of_threads() {
    let picture = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| rendered("door.toml", GuidingMethod::Auto))
    };
    let (one, three) = (picture(1), picture(3));
    assert!(one.estimate.mean == three.estimate.mean);
    assert_eq!(one.training.iter().map(|lesson| lesson.samples).collect::<Vec<_>>(), [1, 2]);
    assert_eq!(one.iterations.iter().map(|iteration| iteration.samples).sum::<u32>(), SPP);
    let [pilot, first] = [&one.iterations[0], &one.iterations[1]];
    assert!(pilot.counters.guided_directions == 0 && first.counters.guided_directions > 0);
    let [blind, led] = [pilot, first].map(dark);
    assert!(led < 0.97 * blind, "{led} of the paths of the first guided iteration, {blind} of unguided ones");
    assert!(one.training.iter().skip(1).all(|lesson| lesson.counters.guided_directions > 0), "it learns");
    assert!(one.total().rays > one.iterations.iter().map(|i| i.counters.rays).sum(), "its rays count");
}

/// Luminance of blocks of 32 × 32 pixels, which are many samples together, with variances.
fn blocks(estimate: &Estimate) -> [Vec<f32>; 2] {
    let (width, side) = (estimate.width as usize, 32);
    let mut sums = [(); 2].map(|()| vec![0.0f64; (width / side) * (estimate.height as usize / side)]);
    for (i, (&mean, &variance)) in estimate.mean.iter().zip(&estimate.variance).enumerate() {
        let block = i / width / side * (width / side) + i % width / side;
        sums[0][block] += f64::from(luminance(mean));
        sums[1][block] += f64::from(luminance(variance));
    }
    sums.map(|sums| sums.into_iter().map(|sum| sum as f32).collect())
}

#[test]
fn a_picture_with_a_trained_guide_has_the_same_mean() {
    let [unguided, guided] = [GuidingMethod::None, GuidingMethod::Adaptive].map(|m| rendered("cornell.toml", m));
    assert!(unguided.training.is_empty() && !guided.training.is_empty());
    let [[a, va], [b, vb]] = [&unguided, &guided].map(|rendering| blocks(&rendering.estimate));
    // one false alarm in 10⁴ runs over all blocks; the variances are upper bounds
    let test = |scale: f32| -> ImageZTest {
        let scaled: Vec<f32> = b.iter().map(|mean| scale * mean).collect();
        let guided = ImageMoments { mean: &scaled, variance: &vb };
        z_test_images(ImageMoments { mean: &a, variance: &va }, guided, 1e-4).unwrap()
    };
    let (same, off) = (test(1.0), test(1.03));
    assert!(same.passed_sidak == 1.0, "{same:?}");
    assert!(off.passed_sidak < 1.0, "3 % would not be seen: {off:?}");
}

#[test]
fn a_render_goes_on_after_its_training() {
    let (scene, mut settings) = own("door.toml", GuidingMethod::Adaptive);
    settings.render.spp = 12;
    let (stop, camera) = (Stop::new(), &scene.camera);
    let job = Job { scene: &scene, camera, settings: &settings, watch: &(), keep_guide: false, keeps_state: false };
    let mut state = RenderState::new(&scene, camera, &settings, GuideIo::default());
    for _ in 0..2 {
        let mut driver = Driver::new(job, state, Limits::from_now(None, &stop));
        assert!(driver.iterate(&mut |_| true, &mut ()));
        state = driver.into_state();
    }
    let mut driver = Driver::new(job, state, Limits::from_now(None, &stop));
    driver.run(&mut |_| true, &mut ());
    assert!(driver.finish().estimate.mean == render(&scene, &settings, &mut |_| true).estimate.mean);
}

#[test]
fn roulette_goes_by_the_nearest_pixel_of_the_small_picture() {
    let (scene, _) = own("cornell.toml", GuidingMethod::None);
    let from = scene.camera.coarser(512 * 256 / 16);
    assert_eq!([from.width, from.height], [128, 64]);
    let inverse_luminance = (0..128 * 64).map(|k| k as f32).collect();
    let large = enlarged(&RouletteNormalisation { inverse_luminance, scale: 3.0 }, &from, &scene.camera);
    let at = |x: usize, y: usize| large.inverse_luminance[512 * y + x];
    assert_eq!([at(0, 0), at(3, 3), at(4, 0), at(511, 255), at(0, 4)], [0.0, 0.0, 1.0, 8191.0, 128.0]);
    assert_eq!((large.inverse_luminance.len(), large.scale), (512 * 256, 3.0));
}

#[test]
fn training_is_told_of_before_the_first_pass() {
    let (scene, settings) = own("door.toml", GuidingMethod::Adaptive);
    let (mut told, mut stop) = (Vec::new(), false);
    let mut observer = |progress: &crate::render::Progress| {
        told.push(progress.training);
        stop |= !progress.training;
        !stop
    };
    let rendering = render(&scene, &settings, &mut observer);
    assert!(!rendering.training.is_empty());
    // at its beginning, after each of its passes, and then the first of the picture
    assert!(told.len() > 3 && told.iter().rev().skip(1).all(|training| *training), "{told:?}");
    assert_eq!(told.last(), Some(&false));
}
