//! The small things a path does at every vertex: directions drawn and weighed by the guide's tables, what the tables
//! learn, BSDFs, warps, and the point of a hit. `states` times how a state is found.
//!
//! Each figure is of a run over as many inputs as a batch has paths, in an order like a batch's.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::Vec3;
use phototaxis::bsdf::{
    BsdfDescription, BsdfModel, BsdfTables, ConductorParameters, DielectricParameters, DiffuseParameters,
    MicrofacetDistribution, PlasticParameters, PrincipledParameters,
};
use phototaxis::geometry::{Attribute, Hit, Indices, Mesh, SurfaceInteraction};
use phototaxis::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings};
use phototaxis::guiding::{Guide, Hue, PackedDirection, Recorder, RegionId, ShadowOutcome, Transition};
use phototaxis::math::{Rgb, alias::AliasTable, rng::Rng, warp};
use phototaxis::texture::ColorTexture;
use std::f32::consts::FRAC_1_PI;

/// Inputs of a run.
const PATHS: usize = 4096;

fn main() {
    divan::main();
}

/// Times `kernel` over inputs that `input` draws.
fn time<I: Sync>(bencher: Bencher, mut input: impl FnMut(&mut Rng) -> I, kernel: impl Fn(&I) -> f32 + Sync) {
    let mut rng = Rng::new(1);
    let inputs: Vec<I> = (0..PATHS).map(|_| input(&mut rng)).collect();
    bencher.counter(ItemsCount::new(PATHS)).bench(|| inputs.iter().map(|i| kernel(black_box(i))).sum::<f32>());
}

/// A guide's directions in a box, of which the walls `x = 0` and `x = 1` are bright.
#[derive(Clone, Copy, Debug)]
enum TableKind {
    Strata,
    Sphere,
    Tree,
    Quadtree,
}

const TABLES: [TableKind; 4] = [TableKind::Strata, TableKind::Sphere, TableKind::Tree, TableKind::Quadtree];

impl TableKind {
    fn settings(self) -> GuidingSettings {
        let (method, table) = match self {
            TableKind::Strata => (GuidingMethod::Grid, DirectionTable::Hemisphere),
            TableKind::Sphere => (GuidingMethod::Grid, DirectionTable::Sphere),
            TableKind::Tree => (GuidingMethod::Grid, DirectionTable::Tree),
            TableKind::Quadtree => (GuidingMethod::SdTree, DirectionTable::Tree),
        };
        GuidingSettings { method, table, ..Default::default() }
    }

    fn empty(self) -> Guide {
        Guide::new(&self.settings(), (Vec3::ZERO, Vec3::ONE), std::iter::empty()).expect("a guide was asked for")
    }

    /// After four iterations.
    fn learnt(self) -> Guide {
        let mut guide = self.empty();
        for iteration in 0..4 {
            guide.learn(&[&transitions(&guide, 400_000, iteration)]);
            guide.end_iteration(4 << iteration);
        }
        guide
    }
}

/// A point on the floor.
fn point(rng: &mut Rng) -> Vec3 {
    let [x, z] = rng.f32x2();
    Vec3::new(x, 1e-4, z)
}

fn state(guide: &Guide, p: Vec3) -> RegionId {
    guide.field().locate(p, Vec3::Y, [0.5; 3]).expect("grids and trees have a state for every point").recorded
}

/// Visits to the floor by cosine-distributed directions.
fn transitions(guide: &Guide, n: usize, seed: u64) -> Recorder {
    let (mut rng, mut recorder) = (Rng::new(seed), Recorder::new());
    for _ in 0..n {
        let (p, local) = (point(&mut rng), warp::square_to_cosine_hemisphere(rng.f32x2()));
        let wi = Vec3::new(local.x, local.z, local.y);
        let target = if wi.x.abs() > 0.7 { 10.0 } else { 0.1 };
        let pdf = (wi.y * FRAC_1_PI).max(1e-6);
        recorder.push(Transition {
            key: state(guide, p),
            wi: PackedDirection::new(wi),
            normal: PackedDirection::new(Vec3::Y),
            target,
            bootstrapped: target,
            pdf,
            bsdf_pdf: pdf,
            guide_pdf: -1.0,
            scattered: pdf,
            hue: Hue::GREY,
            rays: 3,
            shadow: ShadowOutcome::NONE,
        });
    }
    recorder
}

#[divan::bench(args = TABLES)]
fn table_look_up(bencher: Bencher, table: TableKind) {
    let guide = table.learnt();
    let field = guide.field();
    let look_up = |p: &Vec3| {
        let place = field.locate(*p, Vec3::Y, [0.5; 3]);
        place.and_then(|place| field.summary(place.drawn)).map_or(0.0, |summary| summary.irradiance)
    };
    time(bencher, point, look_up);
}

/// With the distribution made ready, as at a vertex.
#[divan::bench(args = TABLES)]
fn table_sample(bencher: Bencher, table: TableKind) {
    let guide = table.learnt();
    let field = guide.field();
    let summary = field.summary(state(&guide, Vec3::new(0.5, 1e-4, 0.5))).expect("the floor was visited");
    let draw = |(u, inside): &(f64, [f32; 2])| field.distribution(summary, Vec3::Y).sample(*u, *inside).0.y;
    time(bencher, |rng| (rng.f64(), rng.f32x2()), draw);
}

#[divan::bench(args = TABLES)]
fn table_pdf(bencher: Bencher, table: TableKind) {
    let guide = table.learnt();
    let field = guide.field();
    let summary = field.summary(state(&guide, Vec3::new(0.5, 1e-4, 0.5))).expect("the floor was visited");
    let upwards = |rng: &mut Rng| {
        let local = warp::square_to_uniform_hemisphere(rng.f32x2());
        Vec3::new(local.x, local.z, local.y)
    };
    time(bencher, upwards, |wi| field.distribution(summary, Vec3::Y).pdf(*wi));
}

/// What a guide takes to learn from a hundred thousand visits, all threads at it.
#[divan::bench(args = TABLES, sample_count = 20, sample_size = 1)]
fn table_update(bencher: Bencher, table: TableKind) {
    const VISITS: usize = 100_000;
    let recorder = transitions(&table.empty(), VISITS, 9);
    let learn = |mut guide: Guide| {
        guide.learn(&[&recorder]);
        guide
    };
    bencher.counter(ItemsCount::new(VISITS)).with_inputs(|| table.empty()).bench_values(learn);
}

const KINDS: [&str; 7] = ["diffuse", "mirror", "glass", "copper", "rough glass", "rough plastic", "principled"];

fn model(kind: &str) -> BsdfModel {
    let white = ColorTexture::Constant(Rgb::ONE);
    let copper = (Rgb::new(0.2, 0.924, 1.102), Rgb::new(3.913, 2.453, 2.142));
    let distribution = MicrofacetDistribution::Ggx;
    let conductor = |eta_k, alpha| {
        BsdfDescription::Conductor(ConductorParameters {
            eta_k,
            specular_reflectance: white.clone(),
            alpha,
            distribution,
            energy_conserving: false,
        })
    };
    let glass = |alpha| {
        BsdfDescription::Dielectric(DielectricParameters {
            int_ior: 1.5,
            ext_ior: 1.0,
            specular_reflectance: Rgb::ONE,
            specular_transmittance: Rgb::ONE,
            alpha,
            distribution,
            thin: false,
        })
    };
    let description = match kind {
        "diffuse" => BsdfDescription::Diffuse(DiffuseParameters { reflectance: white }),
        "mirror" => conductor(None, 0.0),
        "glass" => glass(0.0),
        "copper" => conductor(Some(copper), 0.3),
        "rough glass" => glass(0.3),
        "rough plastic" => BsdfDescription::Plastic(PlasticParameters {
            reflectance: white,
            specular_reflectance: Rgb::ONE,
            int_ior: 1.5,
            ext_ior: 1.0,
            alpha: 0.2,
            distribution,
            nonlinear: true,
            energy_conserving: false,
            additive: false,
        }),
        _ => BsdfDescription::Principled(PrincipledParameters {
            base_color: white,
            metallic: 0.3,
            roughness: 0.4,
            specular: 0.5,
            spec_tint: 0.0,
            clearcoat: 0.5,
            clearcoat_gloss: 0.8,
            sheen: 0.2,
            sheen_tint: 0.5,
            ..PrincipledParameters::default()
        }),
    };
    BsdfModel::new(&description, false, &mut BsdfTables::default()).expect("all numbers are in their domains")
}

fn above(rng: &mut Rng) -> Vec3 {
    warp::square_to_uniform_hemisphere(rng.f32x2())
}

#[divan::bench(args = KINDS)]
fn bsdf_eval_pdf(bencher: Bencher, kind: &str) {
    let model = model(kind);
    let eval = |(wo, wi): &(Vec3, Vec3)| {
        let (f, pdf) = model.at([Rgb::splat(0.7); 2]).eval_pdf(*wo, *wi);
        f.x + pdf
    };
    time(bencher, |rng| (above(rng), above(rng)), eval);
}

#[divan::bench(args = KINDS)]
fn bsdf_sample(bencher: Bencher, kind: &str) {
    let model = model(kind);
    let draw = |(wo, u_lobe, u): &(Vec3, f32, [f32; 2])| {
        model.at([Rgb::splat(0.7); 2]).sample(*wo, *u_lobe, *u).map_or(0.0, |drawn| drawn.weight.x)
    };
    time(bencher, |rng| (above(rng), rng.f32(), rng.f32x2()), draw);
}

#[divan::bench]
fn warp_disk(bencher: Bencher) {
    time(bencher, Rng::f32x2, |u| warp::square_to_disk(*u).x);
}

#[divan::bench]
fn warp_cosine_hemisphere(bencher: Bencher) {
    time(bencher, Rng::f32x2, |u| warp::square_to_cosine_hemisphere(*u).z);
}

#[divan::bench]
fn warp_uniform_hemisphere(bencher: Bencher) {
    time(bencher, Rng::f32x2, |u| warp::square_to_uniform_hemisphere(*u).z);
}

#[divan::bench]
fn warp_uniform_hemisphere_back(bencher: Bencher) {
    time(bencher, above, |w| warp::uniform_hemisphere_to_square(*w)[0]);
}

#[divan::bench]
fn warp_triangle(bencher: Bencher) {
    time(bencher, Rng::f32x2, |u| warp::square_to_triangle(*u)[0]);
}

#[divan::bench]
fn random_numbers(bencher: Bencher) {
    let draw = |rng: &Rng| {
        let mut rng = *rng;
        rng.f32()
    };
    time(bencher, |rng| Rng::new(rng.next_u32() as u64), draw);
}

/// Of a thousand lights.
#[divan::bench]
fn alias_sample(bencher: Bencher) {
    let weights: Vec<f64> = (1..=1000).map(f64::from).collect();
    let table = AliasTable::new(&weights).expect("weights are positive");
    time(bencher, Rng::f32, |u| table.sample(*u).0 as f32);
}

/// A grid of `side`² quads with bumps, normals and texture coordinates.
fn mesh(side: u32, attributes: bool) -> Mesh {
    let at = |i: u32| [(i / (side + 1)) as f32 / side as f32, (i % (side + 1)) as f32 / side as f32];
    let height = |[x, z]: [f32; 2]| 0.1 * (9.0 * x).sin() * (7.0 * z).cos();
    let positions = (0..(side + 1).pow(2)).map(at).map(|[x, z]| [x, height([x, z]), z]).collect();
    let mut mesh = Mesh { positions, ..Default::default() };
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let a = i * (side + 1) + j;
        mesh.triangles.extend([[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]);
    }
    mesh.materials = vec![0; mesh.triangles.len()];
    if attributes {
        let indices = Indices::Own(mesh.triangles.clone());
        let values = mesh.positions.iter().map(|p| Vec3::new(0.1 * p[0], 1.0, 0.1 * p[2]).normalize().into()).collect();
        mesh.normals = Some(Attribute { values, indices: indices.clone() });
        mesh.uvs = Some(Attribute { values: mesh.positions.iter().map(|p| [p[0], p[2]]).collect(), indices });
    }
    mesh
}

/// The point, frame and texture coordinates of a hit, in meshes that fit into the caches and that do not, without and
/// with normals and texture coordinates.
#[divan::bench(args = [(32, false), (32, true), (700, false), (700, true)])]
fn triangle_interpolation(bencher: Bencher, (side, attributes): (u32, bool)) {
    let mesh = mesh(side, attributes);
    let n = mesh.triangles.len();
    let hit = |rng: &mut Rng| {
        let primitive = (rng.f64() * n as f64) as u32;
        let [a, b, c] = mesh.triangles[primitive as usize].map(|i| Vec3::from(mesh.positions[i as usize]));
        let [u, v] = warp::square_to_triangle(rng.f32x2());
        Hit { t: 1.0, u, v, ng: (b - a).cross(c - a), primitive, geometry: 0, instance: u32::MAX }
    };
    let interpolate = |hit: &Hit| {
        let si = SurfaceInteraction::new(&mesh, hit, Vec3::Y);
        si.p.x + si.frame.s.x + si.uv[0]
    };
    time(bencher, hit, interpolate);
}
