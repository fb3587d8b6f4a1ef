use super::*;
use crate::bsdf::{
    Bsdf, BsdfDescription, BsdfModel, BsdfTables, ConductorParameters, DiffuseParameters, MicrofacetDistribution,
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
