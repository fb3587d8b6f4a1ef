//! A packet's lights against those drawn one by one.

use super::BOTH;
use super::lights::{ceiling, wall};
use super::patterns::Spot;
use super::tree::random_lights;
use crate::geometry::surfaces::tests::{mesh, packet};
use crate::light::{
    ConstantLight, DirectionalLight, EmitterPattern, LightSampleContext, LightSampler, LightSamples, Lights, PointLight,
};
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
    for by in BOTH {
        let (lit, dark, deltas) = compared(&lights(false), by);
        // 900 lanes were skipped; the tree may draw no light at all that does not reach
        let least = if by == LightSampler::Power { 951 } else { 900 };
        assert!(
            lit > 1000 && dark >= least && deltas > 300,
            "{by:?}: {lit} lit, {dark} dark, {deltas} by delta lights"
        );
        let (lit, _, deltas) = compared(&lights(true), by);
        assert!(lit > deltas + 1000, "{by:?}: {lit} lit, {deltas} by delta lights");
    }
    // a tree of several levels
    let mut rng = Rng::new(32);
    let (lit, dark, _) = compared(&random_lights(&mut rng, 600), LightSampler::Tree);
    assert!(lit > 1000 && dark > 900, "{lit} lit, {dark} dark");
}

/// How many draws agreed that were lit, dark, and of delta lights.
fn compared(lights: &Lights, by: LightSampler) -> (u32, u32, u32) {
    let (mut rng, mut drawn) = (Rng::new(31), LightSamples::new());
    let (mut lit, mut dark, mut deltas) = (0, 0, 0);
    for _ in 0..300 {
        let mesh = mesh(&mut rng, true);
        let surfaces = packet(&mesh, &mut rng);
        let mut single = [None; LANES];
        let (mut u, mut u_choice) = ([[0.0; LANES]; 2], [0.0; LANES]);
        let mut normals = Vec3Lanes::ZERO;
        drawn.clear();
        for (k, single) in single.iter_mut().enumerate() {
            u_choice[k] = rng.f64();
            [u[0][k], u[1][k]] = rng.f32x2();
            normals.set(k, if k % 3 == 0 { Vec3::ZERO } else { surfaces.facing_normal(k) });
            if k % 5 != 4 {
                let ctx = LightSampleContext { p: surfaces.p(k), n: normals.get(k) };
                *single = lights.sample(by, &ctx, u_choice[k], [u[0][k], u[1][k]]);
            }
        }
        drawn.choose(mask(|k| k % 5 != 4), (lights, by), [surfaces.places(), &normals], &u_choice, &mut u);
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
