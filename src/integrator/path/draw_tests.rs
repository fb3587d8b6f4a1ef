use super::*;
use crate::bsdf::{Bsdf, BsdfModel, CoatTables};
use crate::geometry::surfaces::tests as surfaces;
use crate::integrator::mixture::tests::learnt;
use crate::math::{rng::Rng, warp};
use crate::scene::description::{BsdfDescription, ColorTexture, DirectionTable};

fn matte() -> BsdfModel {
    let reflectance = ColorTexture::Constant(Rgb::new(0.6, 0.5, 0.4));
    BsdfModel::new(&BsdfDescription::Diffuse { reflectance }, true, &mut CoatTables::default()).unwrap()
}

/// Puts a Lambertian surface at each vertex; a guide of a third of them is a tree, of another strata, the rest have none.
fn fill<'a>(
    packet: &mut Packet<'a>,
    guides: &'a [(crate::guiding::Guide, crate::guiding::Summary)],
    bsdf: Bsdf<'a>,
    rng: &mut Rng,
) {
    for k in 0..LANES {
        packet.bsdf[k] = Some(bsdf);
        packet.diffuse.set(k, Some(&bsdf));
        packet.rng[k] = Rng::new(rng.next_u32() as u64);
        let (guide, summary) = &guides[k];
        let directions = guide.field().distribution(summary, packet.surfaces.facing_normal(k));
        packet.lead(k, (k % 3 < 2).then_some((directions, 0.4)));
        packet.lights.wi.set(k, warp::square_to_uniform_sphere(rng.f32x2()));
        packet.lights.pdf[k] = 1.0;
    }
}

#[test]
fn a_packet_draws_what_its_vertices_would_draw_alone() {
    let (mut rng, model) = (Rng::new(17), matte());
    let mesh = surfaces::mesh(&mut rng, true);
    let (mut by_guide, mut by_bsdf, mut ended) = (0, 0, 0);
    for _ in 0..40 {
        let surfaces = surfaces::packet(&mesh, &mut rng);
        let table = |k: usize| if k.is_multiple_of(3) { DirectionTable::Tree } else { DirectionTable::Hemisphere };
        let guides: Vec<_> = (0..LANES).map(|k| learnt(&surfaces.get(k), table(k), &mut rng)).collect();
        let mut packet = Packet::new();
        packet.surfaces = surfaces;
        fill(&mut packet, &guides, model.at([Rgb::new(0.6, 0.5, 0.4), Rgb::ZERO]), &mut rng);
        let (mut alone, mut numbers) = (packet.rng, Numbers::default());
        for k in (0..LANES).filter(|k| k % 3 != 1) {
            assert!(packet.is_wide(k), "a tree, or no guide");
            packet.draw_numbers(k, &mut numbers);
        }
        let drawn = packet.draw(&numbers);
        let (mut f, mut pdf) = (Vec3Lanes::ZERO, [0.0; LANES]);
        packet.eval_pdf(&mut f, &mut pdf);
        for k in 0..LANES {
            let (mixture, si, wo) = (packet.mixture(k).unwrap(), packet.surfaces.get(k), packet.surfaces.wo_local(k));
            let (value, density) = mixture.eval_pdf(&si, wo, packet.lights.wi.get(k));
            assert!(f.get(k) == value && (value == Rgb::ZERO || pdf[k] == density), "towards a light");
            if !packet.is_wide(k) {
                assert_eq!(k % 3, 1, "strata are for one vertex at a time");
                continue;
            }
            let single = mixture.sample(&si, wo, &mut alone[k]);
            assert_eq!(alone[k].next_u32(), packet.rng[k].clone().next_u32(), "as many numbers");
            match (packet.drawn(k, &numbers, &drawn), single) {
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
