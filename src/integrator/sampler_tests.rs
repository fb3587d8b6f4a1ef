//! The numbers of paths: that they are the same however they are asked for, uniform, independent by name, pixel, branch and
//! sequence, and spread evenly over the samples of a pixel.

use super::*;
use crate::math::rng::Rng;
use crate::stats::chi2_discrete;

/// False alarm of each χ² test; some 1 300 run. Seeds are fixed, so that a test passes always or never.
const LEVEL: f64 = 1e-7;
const KINDS: [SamplerKind; 2] = [SamplerKind::Sobol, SamplerKind::Independent];

impl DirectionNumbers<1> {
    /// Numbers of no path.
    pub(crate) fn random(rng: &mut Rng) -> DirectionNumbers<1> {
        let (chooser, cell, [u, v]) = (rng.f32(), rng.f64(), rng.f32x2());
        DirectionNumbers { chooser: [chooser], cell: [cell], point: [[u], [v]] }
    }
}

/// All numbers of a path up to some vertices, by name.
fn numbers(sampler: Sampler, keys: &PathKey, vertices: u32) -> Vec<(String, f64)> {
    let mut all = Vec::new();
    let mut add = |name: &str, vertex: u32, u: f64| all.push((format!("{name} at {vertex}"), u));
    let CameraNumbers { film: [[x], [y]], lens: [[u], [v]] } = sampler.camera(keys);
    for (name, u) in [("film x", x), ("film y", y), ("lens u", u), ("lens v", v)] {
        add(name, 0, u.into());
    }
    for vertex in 1..=vertices {
        let LightNumbers { choice: [choice], point: [[u], [v]] } = sampler.light(keys, vertex);
        let roulette = sampler.roulette(keys, vertex)[0].into();
        for (name, u) in [("light", choice), ("light u", u.into()), ("light v", v.into()), ("roulette", roulette)] {
            add(name, vertex, u);
        }
        let DirectionNumbers { chooser: [chooser], cell: [cell], point: [[u], [v]] } = sampler.direction(keys, vertex);
        for (name, u) in [("chooser", chooser.into()), ("cell", cell), ("u", u.into()), ("v", v.into())] {
            add(name, vertex, u);
        }
    }
    all
}

#[test]
fn paths_side_by_side_have_the_numbers_of_each_alone() {
    let mut rng = Rng::new(1);
    for kind in KINDS {
        let (wide, alone) = (Sampler::new(kind, 1000), Sampler::new(kind, 4_000_000_000));
        let mut keys = PathKeys::<LANES>::NONE;
        (0..LANES).for_each(|k| keys.set(k, PathKey::new(5, rng.next_u32(), 3, rng.next_u32() % 1000)));
        for vertex in 1..STRATIFIED_VERTICES + 3 {
            let branches = keys.branch(vertex, 2);
            let (camera, light) = (wide.camera(&keys), wide.light(&keys, vertex));
            let (roulette, direction) = (wide.roulette(&keys, vertex), wide.direction(&keys, vertex));
            assert_eq!(wide.film(&keys), camera.film, "the same numbers, or all of them");
            assert_eq!(wide.direction_point(&keys, vertex), direction.point, "the same numbers, or all of them");
            for k in 0..LANES {
                let own = keys.get(k);
                let lane = |rows: [[f32; LANES]; 2]| rows.map(|row| [row[k]]);
                assert_eq!(branches.get(k), own.branch(vertex, 2));
                assert_eq!([lane(camera.film), lane(camera.lens)], [alone.camera(&own).film, alone.camera(&own).lens]);
                let one = alone.light(&own, vertex);
                assert_eq!(([light.choice[k]], lane(light.point)), (one.choice, one.point));
                assert_eq!([roulette[k]], alone.roulette(&own, vertex));
                assert_eq!(direction.get(k), alone.direction(&own, vertex));
            }
        }
    }
}

/// χ² of pairs in 16 × 16 cells.
fn independent(what: &str, pairs: impl Iterator<Item = (f64, f64)>) {
    let mut counts = [0u64; 256];
    pairs.for_each(|(a, b)| counts[(16.0 * a) as usize * 16 + (16.0 * b) as usize] += 1);
    let report = chi2_discrete(&counts, &[1.0 / 256.0; 256]);
    assert!(report.passes(LEVEL), "{what}: {report}");
}

#[test]
fn numbers_are_uniform_and_independent_of_those_of_other_names() {
    for kind in KINDS {
        for sample in [0, 1, 37] {
            let sampler = Sampler::new(kind, sample + 1);
            let paths: Vec<_> =
                (0..10_000).map(|pixel| numbers(sampler, &PathKey::new(1, pixel, 0, sample), 2)).collect();
            for a in 0..paths[0].len() {
                for b in 0..a {
                    let what = format!("{kind:?}, sample {sample}: {} and {}", paths[0][a].0, paths[0][b].0);
                    independent(&what, paths.iter().map(|path| (path[a].1, path[b].1)));
                }
            }
        }
    }
}

#[test]
fn numbers_beyond_the_stratified_vertices_are_independent_too() {
    let vertices = STRATIFIED_VERTICES + 2;
    let sampler = Sampler::new(SamplerKind::Sobol, 1);
    let paths: Vec<_> =
        (0..10_000).map(|i| numbers(sampler, &PathKey::new(2, i / 100, 0, i % 100), vertices)).collect();
    let last = paths[0].len();
    for (a, b) in (last - 12..last).flat_map(|a| (last - 20..a).map(move |b| (a, b))) {
        // of one pixel, too, whose samples are independent there
        let own = |path: &Vec<(String, f64)>| (path[a].1, path[b].1);
        if b >= last - 8 {
            independent(&format!("{} and {}", paths[0][a].0, paths[0][b].0), paths.iter().map(own));
        }
    }
}

#[test]
fn pixels_samples_sequences_seeds_and_branches_know_nothing_of_each_other() {
    for kind in KINDS {
        let sampler = Sampler::new(kind, 100);
        let at = |keys: PathKey| sampler.light(&keys, 1).point[0][0].into();
        let of = |seed, pixel, sequence, sample| PathKey::new(seed, pixel, sequence, sample);
        let pixels = || 0..40_000u32;
        independent("neighbours", pixels().map(|p| (at(of(1, p, 0, 5)), at(of(1, p + 1, 0, 5)))));
        independent("sequences", pixels().map(|p| (at(of(1, p, 0, 5)), at(of(1, p, 8, 5)))));
        independent("seeds", pixels().map(|p| (at(of(1, p, 0, 5)), at(of(2, p, 0, 5)))));
        independent("a branch", pixels().map(|p| (at(of(1, p, 0, 5)), at(of(1, p, 0, 5).branch(1, 1)))));
        let branches = |p| [of(1, p, 0, 5).branch(1, 1), of(1, p, 0, 5).branch(1, 2)].map(at);
        independent("branches", pixels().map(branches).map(|[a, b]| (a, b)));
        if kind == SamplerKind::Independent {
            independent("samples", pixels().map(|p| (at(of(1, p / 50, 0, p % 50)), at(of(1, p / 50, 0, p % 50 + 1)))));
        }
    }
}

#[test]
fn long_numbers_are_uniform_to_their_last_bits() {
    for kind in KINDS {
        let sampler = Sampler::new(kind, 100);
        let cell = |i: u32| sampler.direction(&PathKey::new(3, i / 100, 0, i % 100), 1).cell[0];
        let digits = |u: f64, from: i32| (u * 2f64.powi(from)).fract();
        independent("digits from the 20th", (0..40_000).map(|i| (digits(cell(i), 20), digits(cell(i), 36))));
        independent("digits from the 28th", (0..40_000).map(|i| (digits(cell(i), 28), digits(cell(i), 49))));
    }
}

/// The most by which a count in one of the cells of 64 samples of one pixel differs from one, over all cells of `columns` by
/// 64/`columns`.
fn unevenness(pairs: &[(f64, f64)]) -> usize {
    let counts = |columns: usize| {
        let mut counts = [0usize; 64];
        let rows = 64 / columns;
        pairs.iter().for_each(|(a, b)| {
            counts[(columns as f64 * a) as usize * rows + (rows as f64 * b) as usize] += 1;
        });
        counts.into_iter().map(|n| n.abs_diff(1)).max().unwrap_or(0)
    };
    (0..=6).map(|log| counts(1 << log)).max().unwrap_or(0)
}

#[test]
fn samples_of_a_pixel_fill_film_lights_and_directions_evenly() {
    for (pixel, first) in [(0, 0), (77, 64), (12_345, 640)] {
        let spread = |kind, a: &str, b: &str| {
            let sampler = Sampler::new(kind, first + 64);
            let path = |sample| numbers(sampler, &PathKey::new(9, pixel, 0, sample), STRATIFIED_VERTICES + 1);
            let find = |path: &[(String, f64)], name: &str| path.iter().find(|(n, _)| n == name).unwrap().1;
            let pair = |sample| (find(&path(sample), a), find(&path(sample), b));
            unevenness(&(first..first + 64).map(pair).collect::<Vec<_>>())
        };
        let mut pairs = vec![("film x at 0".to_string(), "film y at 0".to_string())];
        for vertex in 1..=STRATIFIED_VERTICES {
            pairs.push((format!("light u at {vertex}"), format!("light v at {vertex}")));
            pairs.push((format!("u at {vertex}"), format!("v at {vertex}")));
        }
        for (a, b) in &pairs {
            assert_eq!(spread(SamplerKind::Sobol, a, b), 0, "{a} and {b} of pixel {pixel}");
            assert!(spread(SamplerKind::Independent, a, b) > 0, "{a} and {b} of independent samples");
        }
        let beyond = STRATIFIED_VERTICES + 1;
        assert!(spread(SamplerKind::Sobol, &format!("u at {beyond}"), &format!("v at {beyond}")) > 0);
        assert!(spread(SamplerKind::Sobol, "film x at 0", "u at 1") > 0, "sets are not joined");
    }
}
