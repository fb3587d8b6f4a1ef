//! What it costs to find the state of a path vertex: the grid's hash against Voronoi states, by the tree and by cells.
//!
//! A room with boxes in it; each look-up reads one number of its state, as the guide does. `coherent` goes along the
//! surfaces as a batch of camera rays does, `scattered` is the order of later bounces.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{Quat, Vec3};
use phototaxis::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings};
use phototaxis::guiding::spatial::voronoi::{Facet, Site, Voronoi, sites_by_area, sites_from_visits};
use phototaxis::guiding::{Guide, Hue, PackedDirection, Recorder, RegionId, ShadowOutcome, Transition};
use phototaxis::math::rng::Rng;
use std::collections::HashSet;

const SITES: [usize; 3] = [1_000, 10_000, 100_000];
const ORDERS: [Order; 2] = [Order::Coherent, Order::Scattered];
const LOOK_UPS: usize = 100_000;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    Coherent,
    Scattered,
}

struct Query {
    p: Vec3,
    n: Vec3,
    jitter: [f32; 2],
}

fn main() {
    divan::main();
}

/// Faces of boxes: the room's inwards, those of eight boxes in it outwards.
fn facets() -> Vec<Facet> {
    let mut facets = cuboid(|p| p * Vec3::new(4.0, 2.5, 5.0), true);
    for i in 0..8 {
        let (turn, at) =
            (Quat::from_rotation_y(0.7 * i as f32), Vec3::new(0.5 + (i % 3) as f32, 0.0, 0.5 + (i / 3) as f32));
        let size = Vec3::new(0.5, 0.3 + 0.2 * (i % 4) as f32, 0.6);
        facets.extend(cuboid(|p| at + turn * (p * size), false));
    }
    facets
}

fn cuboid(place: impl Fn(Vec3) -> Vec3, inwards: bool) -> Vec<Facet> {
    let mut facets = Vec::new();
    for (axis, high) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
        let corner = |u: f32, v: f32| {
            let mut p = Vec3::splat(high as u8 as f32);
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = if high == inwards { (v, u) } else { (u, v) };
            place(p)
        };
        let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        facets.extend([[a, b, c], [a, c, d]].map(|corners| Facet { corners, two_sided: false }));
    }
    facets
}

fn points(n: usize, seed: u64) -> Vec<(Vec3, Vec3)> {
    sites_by_area(facets().into_iter(), n, seed).into_iter().map(|Site { p, n }| (p, n)).collect()
}

/// Points in cubes of an eighth metre, cube after cube; or shuffled (Fisher & Yates 1938).
fn queries(order: Order) -> Vec<Query> {
    let mut rng = Rng::new(1);
    let mut points = points(LOOK_UPS, 2);
    match order {
        Order::Coherent => points.sort_by_key(|(p, _)| (*p * 8.0 + 64.0).as_uvec3().to_array()),
        Order::Scattered => (1..points.len()).rev().for_each(|i| points.swap(i, rng.next_u32() as usize % (i + 1))),
    }
    points.into_iter().map(|(p, n)| Query { p, n, jitter: rng.f32x2() }).collect()
}

/// A guide on a grid with about `states` states on the surfaces, each of which it knows.
fn grid_guide(states: usize) -> Guide {
    let points = points(20 * states, 3);
    let keys =
        |guide: &Guide| -> HashSet<RegionId> { points.iter().map(|(p, n)| key(guide, *p, *n, [0.5; 2])).collect() };
    let guide = |resolution: u32| {
        let (method, table) = (GuidingMethod::Grid, DirectionTable::Hemisphere);
        let settings = GuidingSettings { method, table, resolution, strata: 2, memory: 4 << 30, ..Default::default() };
        Guide::new(&settings, (Vec3::ZERO, Vec3::new(4.0, 2.5, 5.0)), std::iter::empty()).expect("it is a grid")
    };
    let resolution = (4..400).find(|resolution| keys(&guide(*resolution)).len() >= states).expect("cells get small");
    let mut guide = guide(resolution);
    let mut recorder = Recorder::new();
    let up = PackedDirection::new(Vec3::Y);
    for key in keys(&guide) {
        let (density, scattered) = (std::f32::consts::FRAC_1_PI, 1.0);
        let (wi, normal, target, hue, rays, shadow) = (up, up, 1.0, Hue::GREY, 1, ShadowOutcome::NONE);
        let (pdf, bsdf_pdf, guide_pdf) = (density, density, -1.0);
        (0..20).for_each(|_| {
            recorder.push(Transition {
                key,
                wi,
                normal,
                target,
                bootstrapped: target,
                hue,
                pdf,
                bsdf_pdf,
                guide_pdf,
                scattered,
                rays,
                shadow,
            });
        });
    }
    guide.learn(&[&recorder]);
    guide.end_iteration(1);
    guide
}

fn key(guide: &Guide, p: Vec3, n: Vec3, [x, y]: [f32; 2]) -> RegionId {
    guide.field().locate(p, n, [x, y, 0.5]).expect("a grid has a state for every point").recorded
}

fn voronoi(sites: usize) -> Voronoi {
    Voronoi::new(sites_by_area(facets().into_iter(), sites, 4), &points(8 * sites, 5)).expect("there are sites")
}

fn time(bencher: Bencher, order: Order, look_up: impl Fn(&Query) -> f32 + Sync) {
    let queries = queries(order);
    bencher.counter(ItemsCount::new(LOOK_UPS)).bench(|| queries.iter().map(|q| look_up(black_box(q))).sum::<f32>());
}

#[divan::bench(args = ORDERS, consts = SITES)]
fn a_grid<const N: usize>(bencher: Bencher, order: Order) {
    let guide = grid_guide(N);
    let field = guide.field();
    time(bencher, order, |q| field.summary(key(&guide, q.p, q.n, q.jitter)).map_or(0.0, |summary| summary.irradiance));
}

#[divan::bench(args = ORDERS, consts = SITES)]
fn b_cells<const N: usize>(bencher: Bencher, order: Order) {
    let (voronoi, irradiance) = (voronoi(N), vec![1.0; N]);
    time(bencher, order, |q| irradiance[voronoi.state(q.p, q.n, q.jitter) as usize]);
}

#[divan::bench(consts = SITES, sample_count = 5, sample_size = 1)]
fn c_build<const N: usize>(bencher: Bencher) {
    let (sites, samples) = (sites_by_area(facets().into_iter(), N, 4), points(8 * N, 5));
    bencher.bench(|| Voronoi::new(black_box(sites.clone()), &samples));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn e_thin_a_million_visits(bencher: Bencher) {
    let visits = points(1_000_000, 6);
    bencher.bench(|| sites_from_visits(black_box(&visits), 10_000));
}
