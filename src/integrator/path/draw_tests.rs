use super::*;
use crate::bsdf::{Bsdf, BsdfModel, CoatTables};
use crate::geometry::surfaces::tests as surfaces;
use crate::integrator::mixture::tests::learnt;
use crate::math::{rng::Rng, warp};
use crate::scene::description::{BsdfDescription, ColorTexture, DirectionTable, MicrofacetDistribution};

fn model(description: BsdfDescription) -> BsdfModel {
    BsdfModel::new(&description, true, &mut CoatTables::default()).unwrap()
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
    guides: &'a [(crate::guiding::Guide, crate::guiding::Summary)],
    [matte, metal]: [Bsdf<'a>; 2],
    rng: &mut Rng,
) {
    for (k, (guide, summary)) in guides.iter().enumerate() {
        packet.bsdf[k] = [Some(matte), Some(metal), None][if is_matte(k) { 0 } else { k % 5 - 2 }];
        packet.diffuse.set(k, packet.bsdf[k].as_ref());
        packet.rng[k] = Rng::new(rng.next_u32() as u64);
        let directions = guide.field().distribution(summary, packet.surfaces.facing_normal(k));
        packet.lead(k, table(k).filter(|_| packet.bsdf[k].is_some()).map(|_| (directions, 0.4)));
        packet.lights.wi.set(k, warp::square_to_uniform_sphere(rng.f32x2()));
        packet.lights.pdf[k] = 1.0;
    }
}

#[test]
fn a_packet_draws_what_its_vertices_would_draw_alone() {
    let reflectance = ColorTexture::Constant(COLOR);
    let matte = model(BsdfDescription::Diffuse { reflectance: reflectance.clone() });
    let (eta_k, distribution) = (None, MicrofacetDistribution::Ggx);
    let metal =
        model(BsdfDescription::Conductor { eta_k, specular_reflectance: reflectance, alpha: 0.4, distribution });
    let mut rng = Rng::new(17);
    let mesh = surfaces::mesh(&mut rng, true);
    let (mut by_guide, mut by_bsdf, mut ended) = (0, 0, 0);
    for _ in 0..40 {
        let surfaces = surfaces::packet(&mesh, &mut rng);
        let guide = |k| learnt(&surfaces.get(k), table(k).unwrap_or(DirectionTable::Sphere), &mut rng);
        let guides: Vec<_> = (0..LANES).map(guide).collect();
        let mut packet = Packet::new();
        packet.surfaces = surfaces;
        fill(&mut packet, &guides, [&matte, &metal].map(|model| model.at([COLOR, Rgb::ZERO])), &mut rng);
        let (mut alone, mut numbers) = (packet.rng, Numbers::default());
        for k in 0..LANES {
            assert_eq!(packet.is_wide(k), is_matte(k) && table(k) != Some(DirectionTable::Hemisphere));
            if packet.is_wide(k) {
                packet.draw_numbers(k, &mut numbers);
            }
        }
        let proposals = packet.propose(&numbers);
        let (mut f, mut pdf) = (Vec3Lanes::ZERO, [0.0; LANES]);
        packet.eval_pdf(&mut f, &mut pdf);
        for k in 0..LANES {
            let Some(mixture) = packet.mixture(k) else { continue };
            let (si, wo) = (packet.surfaces.get(k), packet.surfaces.wo_local(k));
            let (value, density) = mixture.eval_pdf(&si, wo, packet.lights.wi.get(k));
            assert!(f.get(k) == value && (value == Rgb::ZERO || pdf[k] == density), "towards a light");
            if !numbers.has(k) {
                continue;
            }
            let single = mixture.sample(&si, wo, &mut alone[k]);
            assert_eq!(alone[k].next_u32(), packet.rng[k].clone().next_u32(), "as many numbers");
            match (packet.proposal(k, &numbers, &proposals), single) {
                (None, None) => ended += 1,
                (Some((org, one)), Some(other)) => {
                    let [a, b] = [one.pdf, other.pdf].map(|pdf| pdf.expect("no delta lobe"));
                    assert_eq!((one.wi, one.weight, org), (other.wi, other.weight, si.spawn(other.wi)));
                    assert_eq!((a.mixture, a.bsdf, a.guide), (b.mixture, b.bsdf, b.guide));
                    *(if numbers.by_guide[k] { &mut by_guide } else { &mut by_bsdf }) += 1;
                }
                _ => panic!("one goes on and the other does not"),
            }
        }
    }
    assert!(by_guide > 20 && by_bsdf > 50 && ended > 20, "{by_guide}, {by_bsdf}, {ended}: too few to be a test");
}
