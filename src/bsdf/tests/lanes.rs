//! Lambertian surfaces of a packet against single ones.

use super::*;
use crate::math::rng::Rng;
use crate::math::warp::square_to_uniform_sphere;
use crate::simd::{LANES, Vec3Lanes};

#[test]
fn surfaces_of_a_packet_scatter_like_single_ones() {
    let (both, front, metal) = (diffuse(), diffuse().sided(false), conductor(None, Ggx, 0.3));
    let (mut rng, mut lanes) = (Rng::new(41), DiffuseLanes::new());
    let (mut lit, mut dark) = (0, 0);
    for _ in 0..200 {
        let bsdfs: Vec<Option<Bsdf>> =
            (0..LANES).map(|k| [Some(both.bsdf()), Some(front.bsdf()), Some(metal.bsdf()), None][k % 4]).collect();
        let [mut wo, mut wi, mut f, mut drawn, mut albedo] = [Vec3Lanes::ZERO; 5];
        let ([mut pdf, mut density], mut u) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        lanes.clear();
        for (k, bsdf) in bsdfs.iter().enumerate() {
            if let Some(bsdf) = bsdf {
                lanes.set(k, bsdf);
            }
            wo.set(k, square_to_uniform_sphere(rng.f32x2()));
            wi.set(k, square_to_uniform_sphere(rng.f32x2()));
            (u[0][k], u[1][k]) = (rng.f32(), rng.f32());
        }
        lanes.eval_pdf(&wo, &wi, &mut f, &mut pdf);
        lanes.albedo(&wo, &mut albedo);
        lanes.sample(&wo, &u, &mut drawn, &mut density);
        for (k, bsdf) in bsdfs.iter().enumerate() {
            let Some(bsdf) = bsdf else {
                assert!(!lanes.are().has(k), "nothing is there");
                continue;
            };
            assert_eq!(albedo.get(k), if lanes.are().has(k) { bsdf.albedo(wo.get(k)) } else { Rgb::ZERO });
            assert_eq!(lanes.are().has(k), bsdf.lambertian().is_some());
            if !lanes.are().has(k) {
                assert_eq!(f.get(k), Rgb::ZERO);
                continue;
            }
            assert_eq!((f.get(k), pdf[k]), bsdf.eval_pdf(wo.get(k), wi.get(k)));
            match bsdf.sample(wo.get(k), 0.5, [u[0][k], u[1][k]]) {
                Some(sample) => {
                    assert_eq!((drawn.get(k), density[k]), (sample.wi, sample.pdf));
                    assert_eq!(lanes.reflectance(k), sample.weight);
                    lit += 1;
                }
                None => {
                    assert_eq!(density[k], 0.0);
                    dark += 1;
                }
            }
        }
    }
    assert!(lit > 1000 && dark > 300, "{lit} lit, {dark} dark");
}
