use super::*;
use crate::bsdf::{
    BsdfDescription, BsdfModel, BsdfTables, ConductorParameters, DiffuseParameters, DiffuseTransmitterParameters,
    MicrofacetDistribution as Distribution, PlasticParameters, PrincipledParameters,
};
use crate::geometry::{Hit, Mesh};
use crate::guiding::settings::{DirectionTable, GuideSampling, GuidingMethod, GuidingSettings};
use crate::guiding::{Guide, Hue, PackedDirection, Recorder, RegionInfo, ShadowOutcome, Transition};
use crate::math::{luminance, rng::Rng, warp};
use crate::stats::{Chi2Report, DirectionTest, Domain, sidak};
use crate::texture::ColorTexture;

/// False alarm of all samplers together.
const LEVEL: f64 = 1e-6;
const WHITE: ColorTexture = ColorTexture::Constant(Rgb::ONE);

fn model(description: BsdfDescription) -> BsdfModel {
    BsdfModel::new(&description, true, &mut BsdfTables::default()).unwrap()
}

fn diffuse() -> BsdfModel {
    model(BsdfDescription::Diffuse(DiffuseParameters { reflectance: WHITE }))
}

fn metal(alpha: f32) -> BsdfModel {
    let copper = Some((Rgb::new(0.2, 0.924, 1.102), Rgb::new(3.912, 2.452, 2.142)));
    let distribution = Distribution::Ggx;
    model(BsdfDescription::Conductor(ConductorParameters {
        eta_k: copper,
        specular_reflectance: WHITE,
        alpha,
        distribution,
        energy_conserving: false,
    }))
}

fn paper() -> BsdfModel {
    model(BsdfDescription::DiffuseTransmitter(DiffuseTransmitterParameters {
        reflectance: WHITE,
        transmittance: WHITE,
    }))
}

/// A coat over a diffuse base; of roughness 0, a delta lobe beside a smooth one.
fn coated(alpha: f32) -> BsdfModel {
    model(BsdfDescription::Plastic(PlasticParameters {
        reflectance: WHITE,
        specular_reflectance: Rgb::ONE,
        int_ior: 1.5,
        ext_ior: 1.0,
        alpha,
        distribution: Distribution::Ggx,
        nonlinear: false,
        energy_conserving: false,
        additive: false,
    }))
}

/// A diffuse base, a specular lobe of alpha = roughness², and a coat of alpha 0.07, which is sharper.
fn principled(roughness: f32) -> BsdfModel {
    model(BsdfDescription::Principled(PrincipledParameters {
        base_color: WHITE,
        metallic: 0.2,
        roughness,
        specular: 0.7,
        spec_tint: 0.4,
        clearcoat: 0.8,
        clearcoat_gloss: 0.3,
        sheen: 0.5,
        sheen_tint: 0.6,
        ..PrincipledParameters::default()
    }))
}

/// What a guide can help with: all lobes of the first three, of the others the diffuse one, of the last the specular one
/// too.
fn models() -> [(&'static str, BsdfModel); 7] {
    [
        ("diffuse", diffuse()),
        ("metal", metal(0.4)),
        ("paper", paper()),
        ("plastic", coated(0.0)),
        ("rough plastic", coated(0.25)),
        ("principled", principled(0.5)),
        ("rough principled", principled(0.8)),
    ]
}

/// A point on a flat triangle with normal `n`, seen from `wo`.
fn surface(n: Vec3, wo: Vec3) -> SurfaceInteraction {
    let frame = crate::math::Frame::from_normal(n);
    let corners = [Vec3::ZERO, frame.s, frame.t];
    let mesh = Mesh {
        positions: corners.map(|p| p.to_array()).to_vec(),
        triangles: vec![[0, 1, 2]],
        materials: vec![0],
        ..Mesh::default()
    };
    let hit = Hit { t: 1.0, u: 0.3, v: 0.3, ng: n, primitive: 0, geometry: 0, instance: u32::MAX };
    SurfaceInteraction::new(&mesh, &hit, wo)
}

/// The tables of directions, in turn.
const TABLES: [DirectionTable; 3] = [DirectionTable::Tree, DirectionTable::Hemisphere, DirectionTable::Sphere];

/// A guide that has learnt something uneven about the state of `si`, and what it knows of it.
pub(crate) fn learnt(si: &SurfaceInteraction, table: DirectionTable, rng: &mut Rng) -> (Guide, RegionInfo) {
    let method = GuidingMethod::Grid;
    let sampling = GuideSampling::GlossyProduct;
    let settings =
        GuidingSettings { method, table, sampling, strata: 4, split_share: 0.03, ..GuidingSettings::default() };
    let mut guide = Guide::new(&settings, (-Vec3::ONE, Vec3::ONE), std::iter::empty()).unwrap();
    let key = guide.field().locate(si.p, si.frame.n, [0.5; 3]).unwrap().drawn;
    let axes = [(); 4].map(|_| warp::square_to_uniform_sphere(rng.f32x2()));
    for _ in 0..2 {
        let mut recorder = Recorder::new();
        for _ in 0..2000 {
            let wi = si.frame.to_world(warp::square_to_uniform_hemisphere(rng.f32x2()));
            let target = axes.iter().map(|axis| wi.dot(*axis).max(0.0).powi(8)).sum();
            let [packed, normal] = [wi, si.frame.n].map(PackedDirection::new);
            recorder.push(Transition {
                key,
                wi: packed,
                normal,
                target,
                bootstrapped: target,
                pdf: 1.0,
                bsdf_pdf: 1.0,
                guide_pdf: -1.0,
                scattered: 1.0,
                hue: Hue::GREY,
                rays: 1,
                shadow: ShadowOutcome::NONE,
            });
        }
        guide.learn(&[&recorder]);
        guide.end_iteration(1);
    }
    let summary = *guide.field().summary(key).expect("enough visits");
    (guide, summary)
}

const COLORS: [Rgb; 2] = [Rgb::new(0.6, 0.5, 0.4), Rgb::new(0.2, 0.3, 0.1)];

/// One vertex: a surface, a view, a BSDF and what a guide knows.
struct Vertex {
    si: SurfaceInteraction,
    wo: Vec3,
    guide: Guide,
    summary: RegionInfo,
}

impl Vertex {
    fn random(table: DirectionTable, rng: &mut Rng) -> Vertex {
        let n = warp::square_to_uniform_sphere(rng.f32x2());
        let local = warp::square_to_cosine_hemisphere(rng.f32x2());
        let wo_world = crate::math::Frame::from_normal(n).to_world(local);
        let si = surface(n, wo_world);
        let (guide, summary) = learnt(&si, table, rng);
        Vertex { wo: si.frame.to_local(wo_world), si, guide, summary }
    }

    fn guide(&self) -> GuidingDistribution<'_> {
        self.guide.field().distribution(&self.summary, self.si.frame.n)
    }

    fn mixture<'a>(&self, bsdf: &'a Bsdf<'a>, guide: &'a GuidingDistribution<'a>, fraction: f32) -> Mixture<'a> {
        let lobes = GuidedLobes::of(bsdf, self.wo, GuidedBy::Radiance);
        Mixture::new(bsdf, Some(guide).filter(|_| lobes.share() > 0.0), fraction, lobes)
    }

    /// `wrong` turns what the density is asked for; nothing for the truth.
    fn chi2(&self, mixture: &Mixture, rng: &mut Rng, wrong: impl Fn(Vec3) -> Vec3) -> Chi2Report {
        let test = DirectionTest { cos_bins: 12, phi_bins: 16, samples: 60_000, depth: 3, domain: Domain::Sphere };
        let sample = || {
            mixture.sample(&self.si, self.wo, &DirectionNumbers::random(rng)).filter(|s| s.pdf.is_some()).map(|s| s.wi)
        };
        // directions that the guide draws and the BSDF does not reflect are lost
        test.run(sample, |wi| {
            let (f, pdf) = mixture.eval_pdf(&self.si, self.wo, wrong(wi));
            if f == Rgb::ZERO { 0.0 } else { pdf }
        })
    }
}

#[test]
fn directions_follow_the_density_of_the_whole_mixture() {
    let mut rng = Rng::new(1);
    let models = models();
    let fractions = [0.05, 0.3, 0.5, 1.0];
    let level = sidak(LEVEL, TABLES.len() * models.len() * fractions.len());
    for ((name, model), table) in models.iter().flat_map(|model| TABLES.map(|table| (model, table))) {
        let bsdf = model.at(COLORS);
        for fraction in fractions {
            let vertex = Vertex::random(table, &mut rng);
            let guide = vertex.guide();
            let mixture = vertex.mixture(&bsdf, &guide, fraction);
            assert!(mixture.guide.is_some());
            assert_eq!(mixture.lobes.sharp() > 0.0, !["diffuse", "metal", "paper"].contains(name), "{name}");
            let report = vertex.chi2(&mixture, &mut rng, |wi| wi);
            assert!(report.passes(level), "{name}, {table:?}, BSDF share {fraction}: {report}");
            let turned = crate::math::Frame::from_normal(Vec3::new(0.1, 0.05, 0.99).normalize());
            let wrong = vertex.chi2(&mixture, &mut rng, |wi| turned.to_world(wi));
            assert!(!wrong.passes(1e-6), "{name}, {table:?}, BSDF share {fraction}: turned, and unseen: {wrong}");
        }
    }
    println!("{} mixtures follow their density; turned, none does", TABLES.len() * models.len() * fractions.len());
}

#[test]
fn another_share_of_the_bsdf_is_another_density() {
    let mut rng = Rng::new(2);
    let model = diffuse();
    let bsdf = model.at(COLORS);
    let vertex = Vertex::random(DirectionTable::Tree, &mut rng);
    let guide = vertex.guide();
    let (truth, lie) = (vertex.mixture(&bsdf, &guide, 0.3), vertex.mixture(&bsdf, &guide, 0.4));
    let test = DirectionTest { samples: 60_000, ..DirectionTest::new(Domain::Sphere) };
    let sample = || truth.sample(&vertex.si, vertex.wo, &DirectionNumbers::random(&mut rng)).map(|s| s.wi);
    let report = test.run(sample, |wi| {
        let (f, pdf) = lie.eval_pdf(&vertex.si, vertex.wo, wi);
        if f == Rgb::ZERO { 0.0 } else { pdf }
    });
    assert!(!report.passes(1e-6), "{report}");
}

#[test]
fn weights_are_value_over_density() {
    let mut rng = Rng::new(3);
    for ((name, model), table) in models().iter().flat_map(|model| TABLES.map(|table| (model, table))) {
        let bsdf = model.at(COLORS);
        for fraction in [0.05, 0.3, 1.0] {
            let vertex = Vertex::random(table, &mut rng);
            let guide = vertex.guide();
            let mixture = vertex.mixture(&bsdf, &guide, fraction);
            for _ in 0..500 {
                let Some(s) = mixture.sample(&vertex.si, vertex.wo, &DirectionNumbers::random(&mut rng)) else {
                    continue;
                };
                let Some(drawn) = s.pdf else { continue };
                let (share, wi) = (mixture.lobes.share(), vertex.si.frame.to_local(s.wi));
                let sharp = bsdf.pdf(vertex.wo, wi) - share * drawn.bsdf;
                let parts = share * (fraction * drawn.bsdf + (1.0 - fraction) * drawn.guide) + sharp;
                let near = (parts / drawn.mixture - 1.0).abs() < 1e-3;
                assert!(near, "{name}: {drawn:?}, {sharp} of sharp lobes, at a share of {fraction}");
                let drawn = drawn.mixture;
                let (f, pdf) = mixture.eval_pdf(&vertex.si, vertex.wo, s.wi);
                assert!((drawn / pdf - 1.0).abs() < 1e-3, "{drawn} drawn, {pdf} asked for");
                // f is in proportion to the cosine, which is rounded on its way through world space
                let tolerance = 1e-3 + f32::EPSILON / wi.z.abs();
                assert!(
                    (s.weight * pdf - f).abs().max_element() <= tolerance * f.max_element(),
                    "{} for {f}",
                    s.weight
                );
            }
        }
    }
}

#[test]
fn delta_lobes_keep_their_light_whatever_the_share() {
    // E[weight] of the coat's reflection is its Fresnel reflectance, guided or not
    let mut rng = Rng::new(4);
    let model = coated(0.0);
    let bsdf = model.at(COLORS);
    let vertex = Vertex::random(DirectionTable::Tree, &mut rng);
    let reflected = |fraction: f32, rng: &mut Rng| {
        let guide = vertex.guide();
        let mixture = vertex.mixture(&bsdf, &guide, fraction);
        let n = 100_000;
        let values: Vec<f64> = (0..n)
            .map(|_| mixture.sample(&vertex.si, vertex.wo, &DirectionNumbers::random(rng)).filter(|s| s.pdf.is_none()))
            .map(|s| s.map_or(0.0, |s| s.weight.x as f64))
            .collect();
        crate::stats::Summary::of(&values).unwrap()
    };
    let (plain, guided) = (reflected(1.0, &mut rng), reflected(0.3, &mut rng));
    let z = (plain.mean - guided.mean) / plain.std_error().hypot(guided.std_error());
    println!("reflected by the coat: {:.4} unguided, {:.4} guided, z = {z:.2}", plain.mean, guided.mean);
    assert!(plain.mean > 0.01 && z.abs() < 5.0);
}

#[test]
fn sharp_lobes_are_drawn_as_often_as_without_a_guide() {
    let mut rng = Rng::new(6);
    let vertex = Vertex::random(DirectionTable::Tree, &mut rng);
    for (name, model) in models() {
        let (bsdf, guide, n) = (model.at(COLORS), vertex.guide(), 200_000);
        for fraction in [0.05, 0.3, 0.7] {
            let mixture = vertex.mixture(&bsdf, &guide, fraction);
            let (mut by_guide, mut sharp) = (0, 0);
            for _ in 0..n {
                match mixture.chooses_guide(&DirectionNumbers::random(&mut rng)) {
                    true => by_guide += 1,
                    false => sharp += u32::from(mixture.lobe(rng.f32()) < mixture.lobes.sharp()),
                }
            }
            let guided = (1.0 - fraction) * mixture.lobes.share();
            for (what, count, p) in [("guide", by_guide, guided), ("sharp lobes", sharp, mixture.lobes.sharp())] {
                // six standard deviations of a binomial: false alarm 2·10⁻⁹ each
                let sigma = (n as f32 * p * (1.0 - p)).sqrt();
                let off = (count as f32 - n as f32 * p).abs();
                assert!(off <= 6.0 * sigma, "{name}, share {fraction}: {count} by the {what}, p = {p}");
            }
        }
    }
}

#[test]
fn what_a_product_helps_is_drawn_by_its_density_too() {
    let mut rng = Rng::new(7);
    let models = [("sharp coat", coated(0.01)), ("coat", coated(0.15)), ("principled", principled(0.5))];
    let level = sidak(LEVEL, models.len());
    for (name, model) in &models {
        let (bsdf, vertex) = (model.at(COLORS), Vertex::random(DirectionTable::Tree, &mut rng));
        let lobes = GuidedLobes::of(&bsdf, vertex.wo, GuidedBy::FullProduct);
        assert_eq!(lobes.sharp() > 0.0, *name == "sharp coat", "{name}");
        let guide = vertex.guide().times(|w| {
            let wi = vertex.si.frame.to_local(w);
            luminance(lobes.eval_pdf(&bsdf, vertex.wo, wi, bsdf.eval_pdf(vertex.wo, wi)).0) / wi.z.abs().max(1e-3)
        });
        let mixture = Mixture::new(&bsdf, Some(&guide), 0.3, lobes);
        let report = vertex.chi2(&mixture, &mut rng, |wi| wi);
        assert!(report.passes(level), "{name}: {report}");
    }
}

#[test]
fn sharp_lobes_are_left_to_their_own_sampling() {
    let vertex = Vertex::random(DirectionTable::Tree, &mut Rng::new(5));
    for (alpha, guided) in [(0.1, false), (0.29, false), (0.31, true)] {
        let model = metal(alpha);
        let bsdf = model.at(COLORS);
        let guide = vertex.guide();
        let mixture = vertex.mixture(&bsdf, &guide, 0.3);
        assert_eq!((mixture.guide.is_some(), mixture.bsdf_fraction), (guided, if guided { 0.3 } else { 1.0 }));
    }
}

/// A surface of metal, plastic and the principled model, each with facets of the roughness α.
fn glossy(alpha: f32) -> [(&'static str, BsdfModel); 3] {
    [("metal", metal(alpha)), ("plastic", coated(alpha)), ("principled", principled(alpha.sqrt()))]
}

/// Roughnesses and cosines of views of glossy surfaces.
const GLOSSY: [(f32, f32); 5] = [(0.08, 0.95), (0.08, 0.15), (0.15, 0.6), (0.25, 0.9), (0.29, 0.25)];

impl Vertex {
    /// Seen from a direction with the cosine `cos`.
    fn seen_at(cos: f32, rng: &mut Rng) -> Vertex {
        let mut vertex = Vertex::random(DirectionTable::Tree, rng);
        let side = (1.0 - cos * cos).sqrt();
        vertex.wo = Vec3::new(0.6 * side, -0.8 * side, cos);
        vertex
    }

    /// The lobe of the surface, and its product with what the guide knows.
    fn lobe(&self, bsdf: &Bsdf) -> GlossyLobe {
        let Gloss { alpha, specular, diffuse } = bsdf.gloss(self.wo).unwrap();
        GlossyLobe { wo: self.si.frame.to_world(self.wo), n: self.si.frame.n, alpha, specular, diffuse }
    }

    fn product(&self, lobe: &GlossyLobe) -> GuidingDistribution<'_> {
        self.guide.field().product(&self.summary, self.si.frame.n, lobe).unwrap()
    }
}

#[test]
fn products_with_glossy_lobes_are_drawn_by_their_density() {
    let mut rng = Rng::new(8);
    let level = sidak(LEVEL, 2 * 3 * GLOSSY.len());
    for (alpha, cos) in GLOSSY {
        for (name, model) in &glossy(alpha) {
            let (bsdf, vertex) = (model.at(COLORS), Vertex::seen_at(cos, &mut rng));
            let lobe = vertex.lobe(&bsdf);
            // of metal the width is seen, of a coat how much it reflects
            let other = GlossyLobe { alpha: 0.6 * alpha, specular: 4.0 * lobe.specular, ..lobe };
            let (guide, other) = (vertex.product(&lobe), vertex.product(&other));
            let lobes = GuidedLobes::of(&bsdf, vertex.wo, GuidedBy::GlossyProduct);
            let by = |guide| Mixture::new(&bsdf, Some(guide), 0.3, lobes);
            let report = vertex.chi2(&by(&guide), &mut rng, |wi| wi);
            assert!(report.passes(level), "{name} of {alpha}, seen at {cos}: {report}");
            // what the guide draws by itself, on all of its hemisphere
            let test = DirectionTest { samples: 60_000, ..DirectionTest::new(Domain::Sphere) };
            let mut alone =
                |pdf: &GuidingDistribution| test.run(|| Some(guide.sample(rng.f64(), rng.f32x2()).0), |wi| pdf.pdf(wi));
            let (report, wrong) = (alone(&guide), alone(&other));
            assert!(report.passes(level), "the guide for {name} of {alpha}, seen at {cos}: {report}");
            assert!(!wrong.passes(1e-6), "{name} of {alpha}, seen at {cos}: another lobe, and unseen: {wrong}");
        }
    }
}

#[test]
fn products_with_glossy_lobes_have_a_mass_of_one() {
    // densities are constant in each of 64×64 cells of the hemisphere
    let (mut rng, side) = (Rng::new(9), 64);
    for (alpha, cos) in GLOSSY {
        for (name, model) in &glossy(alpha) {
            let (bsdf, vertex) = (model.at(COLORS), Vertex::seen_at(cos, &mut rng));
            let guide = vertex.product(&vertex.lobe(&bsdf));
            let centre = |k: u32| (k as f32 + 0.5) / side as f32;
            let cells = (0..side * side).map(|k| [centre(k % side), centre(k / side)]);
            let mass: f64 = cells
                .map(|cell| guide.pdf(vertex.si.frame.to_world(warp::square_to_uniform_hemisphere(cell))) as f64)
                .sum::<f64>()
                * (std::f64::consts::TAU / (side * side) as f64);
            assert!((mass - 1.0).abs() < 1e-5, "{name} of {alpha}, seen at {cos}: {mass}");
        }
    }
}
