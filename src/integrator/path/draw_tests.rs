use super::*;
use crate::bsdf::{
    Bsdf, BsdfDescription, BsdfModel, BsdfTables, ConductorParameters, DiffuseParameters, MicrofacetDistribution,
    PlasticParameters,
};
use crate::geometry::surfaces::tests as surfaces;
use crate::guiding::settings::DirectionTable;
use crate::integrator::SamplerKind;
use crate::integrator::mixture::tests::learnt;
use crate::integrator::mixture::{DirectionSample, GuidedBy, GuidedLobes, Mixture};
use crate::integrator::sampler::{PathKey, PathKeys, Sampler};
use crate::math::rng::Rng;
use crate::math::warp;
use crate::texture::ColorTexture;

fn model(description: BsdfDescription) -> BsdfModel {
    BsdfModel::new(&description, true, &mut BsdfTables::default()).unwrap()
}

const COLOR: Rgb = Rgb::new(0.6, 0.5, 0.4);

/// Whether vertex `k` is Lambertian: of five the first three; then comes rough metal, and the end of a path.
fn is_matte(k: usize) -> bool {
    k % 5 < 3
}

/// Which guide vertex `k` has: of three the first a tree, the second strata, the third none.
fn table(k: usize) -> Option<DirectionTable> {
    [Some(DirectionTable::Tree), Some(DirectionTable::Hemisphere), None][k % 3]
}

fn fill<'a>(
    packet: &mut Packet<'a>,
    guides: &'a [(crate::guiding::Guide, crate::guiding::RegionInfo)],
    [matte, metal]: [Bsdf<'a>; 2],
    rng: &mut Rng,
) {
    packet.begin(0, PathKeys::NONE);
    for (k, (guide, summary)) in guides.iter().enumerate() {
        packet.keys.set(k, PathKey::new(1, rng.next_u32(), 0, k as u32));
        packet.lights.wi.set(k, warp::square_to_uniform_sphere(rng.f32x2()));
        packet.lights.pdf[k] = 1.0;
        if k % 5 == 4 {
            continue;
        }
        packet.bsdfs.set(k, if is_matte(k) { &matte } else { &metal });
        let (field, normal) = (guide.field(), packet.surfaces.facing_normal(k));
        match table(k) {
            Some(DirectionTable::Tree) => packet.set_tree_guide(k, field.tree(summary, normal).unwrap(), 0.4),
            Some(_) => packet.set_guide(k, field.distribution(summary, normal), 0.4),
            None => {}
        }
    }
    packet.resolve_trees();
}

fn proposal(proposals: &DirectionSamples, k: usize) -> DirectionSample {
    let pdf = Densities { mixture: proposals.mixture[k], bsdf: proposals.bsdf[k], guide: proposals.guide[k] };
    DirectionSample { wi: proposals.dir.get(k), weight: proposals.weight.get(k), pdf: Some(pdf) }
}

#[test]
fn a_packet_draws_what_its_vertices_would_draw_alone() {
    let reflectance = ColorTexture::Constant(COLOR);
    let matte = model(BsdfDescription::Diffuse(DiffuseParameters { reflectance: reflectance.clone() }));
    let (eta_k, distribution) = (None, MicrofacetDistribution::Ggx);
    let metal = model(BsdfDescription::Conductor(ConductorParameters {
        eta_k,
        specular_reflectance: reflectance,
        alpha: 0.4,
        distribution,
        energy_conserving: false,
    }));
    let mut rng = Rng::new(17);
    let mesh = surfaces::mesh(&mut rng, true);
    let (mut led, mut unled, mut ended) = (0, 0, 0);
    for _ in 0..40 {
        let surfaces = surfaces::packet(&mesh, &mut rng);
        let guide = |k| learnt(&surfaces.get(k), table(k).unwrap_or(DirectionTable::Sphere), &mut rng);
        let guides: Vec<_> = (0..LANES).map(guide).collect();
        let mut packet = Packet::new();
        packet.surfaces = surfaces;
        fill(&mut packet, &guides, [&matte, &metal].map(|model| model.at([COLOR, Rgb::ZERO])), &mut rng);
        let (sampler, vertex) = (Sampler::new(SamplerKind::Sobol, LANES as u32), 2);
        let wide = packet.vectorised();
        assert_eq!(wide, mask(|k| is_matte(k) && table(k) != Some(DirectionTable::Hemisphere)));
        let proposals = packet.propose(wide, sampler, vertex);
        let (mut f, mut pdf, mut albedo) = (Vec3Lanes::ZERO, [0.0; LANES], Vec3Lanes::ZERO);
        packet.eval_pdf(&mut f, &mut pdf);
        packet.albedo(&mut albedo);
        for k in 0..LANES {
            let Some(bsdf) = packet.bsdfs.get(k) else {
                assert!(packet.with_mixture(k, |_| ()).is_none());
                assert!(!proposals.goes.has(k), "nothing is drawn");
                continue;
            };
            let (si, wo) = (packet.surfaces.get(k), packet.surfaces.wo_local(k));
            let guide = guides[k].0.field().distribution(&guides[k].1, packet.surfaces.facing_normal(k));
            let mixture =
                Mixture::new(&bsdf, table(k).map(|_| &guide), 0.4, GuidedLobes::of(&bsdf, wo, GuidedBy::Radiance));
            let (value, density) = mixture.eval_pdf(&si, wo, packet.lights.wi.get(k));
            assert!(f.get(k) == value && (value == Rgb::ZERO || pdf[k] == density), "towards a light");
            assert_eq!(albedo.get(k), bsdf.albedo(wo));
            if !wide.has(k) {
                assert!(!proposals.goes.has(k), "nothing is drawn");
                continue;
            }
            let single = mixture.sample(&si, wo, &sampler.direction(&packet.keys.get(k), vertex));
            match (proposals.goes.has(k).then(|| proposal(&proposals, k)), single) {
                (None, None) => ended += 1,
                (Some(one), Some(other)) => {
                    let [a, b] = [one.pdf, other.pdf].map(|pdf| pdf.expect("no delta lobe"));
                    let org = proposals.org.get(k);
                    assert_eq!((one.wi, one.weight, org), (other.wi, other.weight, si.spawn(other.wi)));
                    assert_eq!((a.mixture, a.bsdf, a.guide), (b.mixture, b.bsdf, b.guide));
                    *(if a.guide >= 0.0 { &mut led } else { &mut unled }) += 1;
                }
                _ => panic!("one goes on and the other does not"),
            }
        }
    }
    assert!(led > 50 && unled > 50 && ended > 20, "{led}, {unled}, {ended}: too few to be a test");
}

#[test]
fn a_packet_without_a_guide_draws_what_its_bsdfs_would_draw_alone() {
    let reflectance = ColorTexture::Constant(COLOR);
    let metal = ConductorParameters { alpha: 0.4, ..ConductorParameters::default() };
    let coated = PlasticParameters { reflectance, alpha: 0.2, ..PlasticParameters::default() };
    // two kinds that draw side by side, one with a delta lobe, and one that packets ask one by one
    let models = [
        model(metal.into()),
        model(coated.clone().into()),
        model(PlasticParameters { alpha: 0.0, ..coated.clone() }.into()),
        model(PlasticParameters { distribution: MicrofacetDistribution::Beckmann, ..coated }.into()),
    ];
    let mut rng = Rng::new(18);
    let mesh = surfaces::mesh(&mut rng, true);
    let (mut smooth, mut delta, mut ended) = (0, 0, 0);
    for round in 0..60 {
        let mut packet = Packet::new();
        packet.surfaces = surfaces::packet(&mesh, &mut rng);
        packet.begin(0, PathKeys::NONE);
        for k in 0..LANES {
            packet.keys.set(k, PathKey::new(2, rng.next_u32(), 0, k as u32));
            let kind = (round + k * k) % 5;
            if let Some(model) = models.get(kind) {
                packet.bsdfs.set(k, &model.at([COLOR, Rgb::ZERO]));
            }
        }
        packet.bsdfs.find_groups();
        let numbers = Sampler::new(SamplerKind::Sobol, LANES as u32).direction(&packet.keys, 2);
        let draws = packet.bsdfs.are() & mask(|k| k != 6);
        let drawn = packet.draw_unguided(draws, &numbers);
        assert!(!(drawn.goes & !draws).any(), "nothing is drawn");
        for k in each(draws) {
            let (si, wo) = (packet.surfaces.get(k), packet.surfaces.wo_local(k));
            let bsdf = packet.bsdfs.get(k).unwrap();
            let single = Mixture::new(&bsdf, None, 1.0, GuidedLobes::ALL).sample(&si, wo, &numbers.get(k));
            assert_eq!(drawn.goes.has(k), single.is_some());
            let Some(DirectionSample { wi, weight, pdf }) = single else {
                ended += 1;
                continue;
            };
            let pdf = pdf.map_or(f32::INFINITY, |pdf| pdf.mixture);
            let told = (drawn.dir.get(k), drawn.weight.get(k), drawn.pdf[k], drawn.org.get(k));
            assert_eq!(told, (wi, weight, pdf, si.spawn(wi)));
            *(if pdf == f32::INFINITY { &mut delta } else { &mut smooth }) += 1;
        }
    }
    assert!(smooth > 200 && delta > 10 && ended > 50, "{smooth}, {delta}, {ended}: too few to be a test");
}
