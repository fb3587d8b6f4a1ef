//! A packet's lights against those drawn one by one.

use super::lights::{ceiling, wall};
use super::patterns::Spot;
use crate::geometry::surfaces::tests::{mesh, packet};
use crate::light::{ConstantLight, DirectionalLight, EmitterPattern, LightSamples, Lights, PointLight};
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::simd::{LANES, Vec3Lanes, mask};
use glam::Vec3;
use std::sync::Arc;

/// `patterned`: one triangle glows by a picture, beside others that do not.
fn lights(patterned: bool) -> Lights {
    let mut triangles = ceiling();
    triangles[0].pattern = patterned.then(|| Arc::new(Spot) as Arc<dyn EmitterPattern>);
    triangles.extend(wall().into_iter().map(|t| crate::light::EmissiveTriangle { mesh: 1, two_sided: true, ..t }));
    let others = vec![
        PointLight { position: Vec3::new(0.2, 0.7, 2.0), intensity: Rgb::new(1.0, 2.0, 3.0) }.into(),
        DirectionalLight { direction: Vec3::new(1.0, -2.0, 0.5), irradiance: Rgb::ONE }.into(),
        ConstantLight { radiance: Rgb::splat(0.3) }.into(),
    ];
    Lights::build(&triangles, others, 1.0).unwrap()
}

#[test]
fn lights_of_a_packet_are_those_of_single_draws() {
    let (lit, dark, deltas) = compared(&lights(false));
    // 900 lanes were skipped
    assert!(lit > 1000 && dark > 950 && deltas > 300, "{lit} lit, {dark} dark, {deltas} by delta lights");
    let (lit, _, deltas) = compared(&lights(true));
    assert!(lit > deltas + 1000, "{lit} lit, {deltas} by delta lights");
}

/// How many draws agreed that were lit, dark, and of delta lights.
fn compared(lights: &Lights) -> (u32, u32, u32) {
    let (mut rng, mut drawn) = (Rng::new(31), LightSamples::new());
    let (mut lit, mut dark, mut deltas) = (0, 0, 0);
    for _ in 0..300 {
        let mesh = mesh(&mut rng, true);
        let surfaces = packet(&mesh, &mut rng);
        let mut single = [None; LANES];
        let (mut u, mut u_choice) = ([[0.0; LANES]; 2], [0.0; LANES]);
        drawn.clear();
        for (k, single) in single.iter_mut().enumerate() {
            u_choice[k] = rng.f64();
            [u[0][k], u[1][k]] = rng.f32x2();
            if k % 5 != 4 {
                *single = lights.sample(surfaces.p(k), u_choice[k], [u[0][k], u[1][k]]);
            }
        }
        drawn.choose(mask(|k| k % 5 != 4), lights, surfaces.places(), &u_choice, &mut u);
        drawn.resolve(surfaces.places(), &u);
        let (mut org, mut dir, mut tfar) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO, [0.0; LANES]);
        drawn.shadow_rays(&surfaces, &mut org, &mut dir, &mut tfar);
        for (k, single) in single.iter().enumerate() {
            let Some(light) = single else {
                assert_eq!(drawn.pdf[k], 0.0);
                dark += 1;
                continue;
            };
            assert_eq!((drawn.wi.get(k), drawn.radiance.get(k)), (light.wi, light.radiance));
            assert_eq!((drawn.pdf[k], drawn.delta.has(k)), (light.pdf, light.delta));
            let ray = light.shadow_ray(surfaces.get(k).spawn(light.wi));
            assert_eq!((org.get(k), dir.get(k), tfar[k]), (ray.org, ray.dir, ray.tfar));
            lit += 1;
            deltas += light.delta as u32;
        }
    }
    (lit, dark, deltas)
}
