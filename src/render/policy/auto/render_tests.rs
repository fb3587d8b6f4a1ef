use crate::film::tile::Tile;
use crate::format;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::{Rgb, luminance};
use crate::render::policy::Reason;
use crate::render::{Rendering, Settings, render};
use crate::scene::Scene;

/// One of the project's scenes, small.
fn own(name: &str, set: &[&str]) -> (Scene, Settings) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

#[test]
fn bounced_light_is_what_direct_light_leaves() {
    let (scene, settings) = own("cornell.toml", &["film.width=32", "film.height=32"]);
    let task = Task { tile: Tile { x: 0, y: 0, width: 32, height: 32 }, first_sample: 0, samples: 4 };
    for (next_event, direct_depth) in [(true, 2), (false, 1)] {
        let render = |max_depth| {
            let settings =
                crate::integrator::IntegratorSettings { next_event, max_depth, ..settings.integrator.clone() };
            let integrator = PathIntegrator { bounced: true, ..PathIntegrator::plain(&scene, &settings, 1) };
            integrator.render(&task, &mut Batch::new())
        };
        let (all, direct) = (render(settings.integrator.max_depth), render(direct_depth));
        let mut light = 0.0;
        for (k, [sum, squares]) in all.bounced.iter().enumerate() {
            let expected = luminance(all.samples.sum[k] - direct.samples.sum[k]);
            assert!((sum - expected).abs() < 1e-4 * (1.0 + expected), "pixel {k}: {sum} and not {expected}");
            // of four numbers that are not negative
            assert!(*squares >= 0.2499 * sum * sum && *squares <= 1.0001 * sum * sum);
            light += sum;
        }
        assert!(light > 1.0, "{light}: too little to be a test");
        assert!(direct.bounced.iter().all(|&sums| sums == [0.0; 2]), "nothing bounces further");
    }
}

fn rendered(scene: &Scene, settings: &Settings, method: GuidingMethod) -> Rendering {
    let mut settings = settings.clone();
    settings.guiding.method = method;
    render(scene, &settings, &mut |_| true)
}

#[test]
fn what_is_not_worth_a_trial_is_rendered_as_without_a_guide() {
    let small = ["film.width=48", "film.height=40", "render.spp=64"];
    let cases = [
        ("cornell.toml", "integrator.max_depth=2", Reason::Calm),
        ("cornell.toml", "integrator.max_depth=16", Reason::Short),
        ("door.toml", "integrator.max_depth=16", Reason::Short),
    ];
    for (scene, depth, reason) in cases {
        let (scene, settings) = own(scene, &[small[0], small[1], small[2], depth]);
        let picture = |method| rendered(&scene, &settings, method).estimate.mean;
        let auto = rendered(&scene, &settings, GuidingMethod::Auto);
        let verdict = auto.verdict.expect("it was measured");
        assert!(!verdict.guided && verdict.reason == reason && verdict.trial.is_none(), "{verdict:?}");
        // sums are rounded in another order
        let same =
            |other: &[Rgb]| auto.estimate.mean.iter().zip(other).all(|(a, b)| (*a - *b).length() <= 1e-5 * b.length());
        assert!(same(&picture(GuidingMethod::None)), "{depth}");
        assert!(!same(&picture(GuidingMethod::Adaptive)), "{depth}: a guide would have rendered it otherwise");
    }
}

#[test]
fn a_door_ajar_is_worth_a_guide_where_there_is_time_to_learn() {
    let small = ["film.width=64", "film.height=36"];
    let picture = |spp: &str, threads| {
        let (scene, settings) = own("door.toml", &[small[0], small[1], spp]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let rendering = pool.install(|| rendered(&scene, &settings, GuidingMethod::Auto));
        (rendering.verdict.expect("it was measured"), rendering.estimate.mean)
    };
    assert_eq!(picture("render.spp=40", 2).0.reason, Reason::Short);
    let (long, mean) = picture("render.spp=400", 2);
    assert!((long, mean) == picture("render.spp=400", 3), "decided by the seed alone");
    let gain = long.trial.expect("it was tried").gain();
    assert!(long.guided && long.lost < 0.0 && gain > 1.5, "{long:?}");
}

#[test]
fn evenness_is_that_of_the_sampler() {
    let evenness = |sampler: &str| {
        let set = ["film.width=64", "film.height=64", "render.spp=400", sampler];
        let (scene, settings) = own("cornell.toml", &set);
        let verdict = rendered(&scene, &settings, GuidingMethod::Auto).verdict.expect("it was measured");
        verdict.trial.expect("it was tried").evenness
    };
    let (even, independent) = (evenness("render.sampler=sobol"), evenness("render.sampler=independent"));
    assert!(even > 0.1 && independent < 0.02, "{even} and {independent}");
}
