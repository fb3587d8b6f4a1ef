//! The light hierarchy: its probabilities are those of its draws, and no light that reaches a point is left out.

use super::Estimate;
use super::patterns::Spot;
use crate::light::environment::Environment;
use crate::light::sun::SunDisc;
use crate::light::{
    ConstantLight, DirectionalLight, EmissiveTriangle, EmitterPattern, LightSampleContext, LightSampler, Lights,
    PointLight,
};
use crate::math::rng::Rng;
use crate::math::{Rgb, warp};
use crate::simd::{LANES, Mask, Vec3Lanes};
use crate::stats::chi2::chi2_discrete;
use glam::{Affine3A, DVec3, Vec3};
use std::sync::Arc;

fn point(rng: &mut Rng, scale: f32) -> Vec3 {
    (Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5) * scale
}

/// Of all sizes, in clusters, of all brightnesses; some shine from both sides, some by a pattern, and some are halves of
/// parallelograms.
pub(super) fn random_triangles(rng: &mut Rng, count: u32) -> Vec<EmissiveTriangle> {
    let (mut cluster, mut all) = (Vec3::ZERO, Vec::<EmissiveTriangle>::new());
    for triangle in 0..count {
        if triangle.is_multiple_of(7) {
            cluster = point(rng, 10.0);
        }
        let (place, size) = (cluster + point(rng, 1.0), 10f32.powf(-3.0 * rng.f32()));
        let mut new = EmissiveTriangle {
            mesh: 0,
            triangle,
            corners: [0; 3].map(|_| place + point(rng, size)),
            radiance: Rgb::splat(10f32.powf(4.0 * rng.f32() - 2.0)),
            two_sided: triangle % 5 == 1,
            group: 0,
            pattern: triangle.is_multiple_of(11).then(|| Arc::new(Spot) as Arc<dyn EmitterPattern>),
            slack: 0.0,
        };
        if let Some(before) = all.last().filter(|_| triangle % 3 == 2) {
            let [a, b, c] = before.corners;
            new.corners = [a, c, a + (c - b)];
            (new.radiance, new.two_sided) = (before.radiance, before.two_sided);
        }
        all.push(new);
    }
    all
}

/// Triangles, and some of all other kinds.
pub(super) fn random_lights(rng: &mut Rng, count: u32) -> Lights {
    let triangles = random_triangles(rng, count);
    let pixels = (0..50).map(|i| Rgb::splat(if i == 14 { 40.0 } else { 0.1 })).collect();
    let mut others = vec![
        ConstantLight { radiance: Rgb::splat(0.1) }.into(),
        Box::new(Environment::new(10, 5, pixels, Rgb::ONE, Affine3A::IDENTITY).unwrap()).into(),
        DirectionalLight { direction: point(rng, 1.0), irradiance: Rgb::splat(2.0) }.into(),
        SunDisc::new(DVec3::new(0.6, 0.8, 0.0), Rgb::splat(3.0), 20.0).into(),
    ];
    others.extend((0..3).map(|_| PointLight { position: point(rng, 10.0), intensity: Rgb::splat(0.3) }.into()));
    Lights::build(&triangles, others, 10.0).unwrap()
}

/// A place near the lights or not, with a normal or without.
fn place(rng: &mut Rng) -> LightSampleContext {
    let around = if rng.f32() < 0.5 { 12.0 } else { 100.0 };
    LightSampleContext {
        p: point(rng, around),
        n: if rng.f32() < 0.3 { Vec3::ZERO } else { warp::square_to_uniform_sphere(rng.f32x2()) },
    }
}

const SIZES: [u32; 6] = [0, 1, 9, 40, 300, 3000];

/// Probabilities of all lights.
fn pmfs(lights: &Lights, ctx: &LightSampleContext, count: u32) -> Vec<f64> {
    // seven lights are no triangles
    (0..count + 7).map(|light| f64::from(lights.tree.root(ctx).pmf(light))).collect()
}

#[test]
fn lights_are_drawn_by_the_probability_that_is_told() {
    let mut rng = Rng::new(41);
    for count in SIZES {
        let lights = random_lights(&mut rng, count);
        for _ in 0..4 {
            let ctx = place(&mut rng);
            let mut pmf = pmfs(&lights, &ctx, count);
            let mut counts = vec![0u64; pmf.len() + 1];
            for _ in 0..100_000 {
                match lights.tree.choose(&ctx, rng.f64()) {
                    Some(choice) => {
                        let told = lights.tree.root(&ctx).pmf(choice.light);
                        assert!((choice.pmf / told - 1.0).abs() < 1e-6, "{} is told as {told}", choice.pmf);
                        assert!((0.0..1.0).contains(&choice.rest));
                        counts[choice.light as usize] += 1;
                    }
                    None => *counts.last_mut().unwrap() += 1,
                }
            }
            pmf.push((1.0 - pmf.iter().sum::<f64>()).max(0.0));
            let report = chi2_discrete(&counts, &pmf);
            assert!(report.passes(1e-6), "{count} lights: {report}");
            // a negative control: a tenth of the probability of the likeliest goes to the next
            let likeliest = (0..pmf.len()).max_by(|&a, &b| pmf[a].total_cmp(&pmf[b])).unwrap();
            let (moved, next) = (0.1 * pmf[likeliest], (likeliest + 1) % pmf.len());
            pmf[likeliest] -= moved;
            pmf[next] += moved;
            assert!(!chi2_discrete(&counts, &pmf).passes(1e-6), "{count} lights: what is wrong passes");
        }
    }
}

#[test]
fn what_is_left_of_the_number_is_uniform() {
    let mut rng = Rng::new(42);
    let lights = random_lights(&mut rng, 300);
    let mut counts = [0u64; 20];
    for _ in 0..200_000 {
        let Some(choice) = lights.tree.choose(&place(&mut rng), rng.f64()) else { continue };
        counts[(choice.rest * 20.0) as usize] += 1;
    }
    let report = chi2_discrete(&counts, &[0.05; 20]);
    assert!(report.passes(1e-6), "{report}");
}

/// Without normals nothing that shines in all directions can be ruled out, and with them little: what is missing from 1 is
/// the probability that draws lead to lights of which none reaches the point.
#[test]
fn probabilities_add_up_to_one() {
    let mut rng = Rng::new(43);
    for count in [1, 5, 40, 3000] {
        let others = |rng: &mut Rng| {
            let all = (0..count).map(|_| PointLight { position: point(rng, 5.0), intensity: Rgb::ONE * rng.f32() });
            all.map(Into::into).collect::<Vec<_>>()
        };
        let lights = Lights::build(&[], others(&mut rng), 1.0).unwrap();
        for _ in 0..20 {
            let ctx = LightSampleContext::unoriented(point(&mut rng, 10.0));
            let sum: f64 = (0..count).map(|light| f64::from(lights.tree.root(&ctx).pmf(light))).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        }
    }
    let (mut least, mut most) = (1.0f64, 0.0f64);
    for count in SIZES {
        let lights = random_lights(&mut rng, count);
        for _ in 0..20 {
            let ctx = place(&mut rng);
            let sum = pmfs(&lights, &ctx, count).iter().sum::<f64>();
            (least, most) = (least.min(sum), most.max(sum));
        }
    }
    assert!(least > 0.5 && most < 1.0 + 1e-5, "between {least} and {most}");
}

/// Behind lights that all face away nothing is drawn, one by one or side by side.
#[test]
fn places_that_no_light_reaches_are_known() {
    let mut rng = Rng::new(45);
    let corner = |rng: &mut Rng| Vec3::new(rng.f32(), rng.f32(), 0.01 * rng.f32());
    let triangles: Vec<EmissiveTriangle> = (0..40)
        .map(|triangle| {
            let [a, b, c] = [0; 3].map(|_| corner(&mut rng));
            let corners = if (b - a).cross(c - a).z > 0.0 { [a, b, c] } else { [a, c, b] };
            EmissiveTriangle {
                corners,
                two_sided: false,
                pattern: None,
                triangle,
                ..random_triangles(&mut rng, 1)[0].clone()
            }
        })
        .filter(|t| (t.corners[1] - t.corners[0]).cross(t.corners[2] - t.corners[0]).normalize().z > 0.99)
        .collect();
    let lights = Lights::build(&triangles, vec![], 10.0).unwrap();
    let (mut p, mut n) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
    for k in 0..LANES {
        p.set(k, Vec3::new(rng.f32(), rng.f32(), if k % 2 == 0 { -3.0 } else { 3.0 }));
        n.set(k, Vec3::new(0.0, 0.0, if k % 4 < 2 { 1.0 } else { -1.0 }));
    }
    let chosen = lights.tree.choose_lanes(!Mask::NONE, &p, &n, &[0.5; LANES]);
    for k in 0..LANES {
        // above the lights, and facing them
        let reached = k % 2 == 1 && k % 4 >= 2;
        let ctx = LightSampleContext { p: p.get(k), n: n.get(k) };
        assert_eq!(chosen.pmf[k] > 0.0, reached, "{k}");
        assert_eq!(lights.tree.choose(&ctx, 0.5).is_some(), reached, "{k}");
        assert_eq!(lights.tree.root(&ctx).pmf(0) > 0.0, reached, "{k}");
    }
}

/// However a triangle lies to a point, near, far, grazing, tiny: if it sends light to the point, it may be drawn.
#[test]
fn no_light_that_reaches_a_point_is_left_out() {
    let mut rng = Rng::new(44);
    let (mut reaching, mut grazing) = (0, 0);
    for round in 0..3000 {
        let count = SIZES[1 + round % 4];
        let mut triangles = random_triangles(&mut rng, count.min(40));
        let far = 10f32.powi(round as i32 % 5 - 2);
        let scale = 10f32.powi(round as i32 % 9 - 4);
        for t in &mut triangles {
            // in some rounds all lights face one way, or nearly, and most places are lit by none
            let flat = [1.0, 0.1, 0.001][round % 3];
            t.corners = t.corners.map(|c| c * Vec3::new(1.0, 1.0, flat) * scale);
            if round % 3 > 0 && (t.corners[1] - t.corners[0]).cross(t.corners[2] - t.corners[0]).z < 0.0 {
                t.corners.swap(1, 2);
            }
            t.two_sided &= round % 2 == 0;
            t.pattern = None;
        }
        let Ok(lights) = Lights::build(&triangles, vec![], 10.0 * scale) else { continue };
        for _ in 0..10 {
            let t = &triangles[rng.next_u32() as usize % triangles.len()];
            let [b, c] = warp::square_to_triangle(rng.f32x2());
            let edges = [t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]];
            let y = t.corners[0] + edges[0] * b + edges[1] * c;
            let normal = edges[0].cross(edges[1]).normalize();
            // a point that sees the triangle at any angle, grazing ones too
            let along = edges[0].normalize() * (rng.f32() - 0.5) + edges[1].normalize() * (rng.f32() - 0.5);
            let height = 10f32.powf(-7.0 * rng.f32()) * (if rng.f32() < 0.2 { -1.0 } else { 1.0 });
            let p = y + (along.normalize() + normal * height) * (far * scale * rng.f32());
            let wi = (y - p).normalize();
            // a normal to which the light is all but hidden, or any
            let any = warp::square_to_uniform_sphere(rng.f32x2());
            let aside = any - wi * any.dot(wi);
            let n = if rng.f32() < 0.5 { (aside.normalize() + wi * 1e-6 * rng.f32()).normalize() } else { any };
            let cos = -wi.dot(normal);
            let sends = wi.dot(n) > 0.0 && (cos > 0.0 || t.two_sided && cos != 0.0);
            if !sends || !wi.is_finite() || !n.is_finite() {
                continue;
            }
            let light = lights.triangle_light(0, t.triangle).unwrap();
            let ctx = LightSampleContext { p, n };
            assert!(lights.tree.root(&ctx).pmf(light) > 0.0, "round {round}: {p} {n} {t:?}", t = t.corners);
            reaching += 1;
            grazing += u32::from(cos.abs() < 1e-4 || wi.dot(n) < 1e-4);
        }
    }
    assert!(reaching > 10_000 && grazing > 4000, "{reaching} {grazing}");
}

/// Irradiance on a surface at the origin that faces up, by Lambert's formula (1760) for a polygon above the horizon, of
/// radiance 1.
fn irradiance(corners: [Vec3; 3]) -> f64 {
    let d = corners.map(|c| c.as_dvec3().normalize());
    let edge = |a: DVec3, b: DVec3| a.cross(b).normalize_or_zero().z * a.angle_between(b);
    0.5 * (edge(d[0], d[1]) + edge(d[1], d[2]) + edge(d[2], d[0]))
}

#[test]
fn many_lights_together_give_what_they_give_one_by_one() {
    let mut rng = Rng::new(45);
    let (mut triangles, mut truth) = (random_triangles(&mut rng, 2000), 0.0);
    for t in &mut triangles {
        t.pattern = None;
        t.corners = t.corners.map(|c| c + Vec3::Z * 6.5);
        let [a, b, c] = t.corners;
        let seen = irradiance([a, c, b]) * f64::from(t.radiance.x);
        truth += if t.two_sided { seen.abs() } else { seen.max(0.0) };
    }
    let lights = Lights::build(&triangles, vec![], 10.0).unwrap();
    for n in [Vec3::Z, Vec3::ZERO] {
        let ctx = LightSampleContext { p: Vec3::ZERO, n };
        let estimate = Estimate::of(400_000, || {
            let sample = lights.sample(LightSampler::Tree, &ctx, rng.f64(), rng.f32x2());
            sample.map_or(0.0, |s| f64::from(s.radiance.x * s.wi.z.max(0.0) / s.pdf))
        });
        estimate.assert_is(truth, 0.02);
    }
}

/// A ceiling of small lamps that are all alike, near a floor.
#[test]
fn near_lights_are_drawn_more_often_than_far_ones() {
    let lamp = |triangle: u32| {
        let place = Vec3::new((triangle % 50) as f32 - 25.0, (triangle / 50) as f32 - 25.0, 1.0);
        let corners = [place, place + Vec3::Y * 0.05, place + Vec3::X * 0.05];
        EmissiveTriangle {
            mesh: 0,
            triangle,
            corners,
            radiance: Rgb::ONE,
            two_sided: false,
            group: 0,
            pattern: None,
            slack: 0.0,
        }
    };
    let lights = Lights::build(&(0..2500).map(lamp).collect::<Vec<_>>(), vec![], 40.0).unwrap();
    let (ctx, mut rng) = (LightSampleContext { p: Vec3::new(3.2, 0.4, 0.0), n: Vec3::Z }, Rng::new(50));
    let [tree, power] = [LightSampler::Tree, LightSampler::Power].map(|by| {
        Estimate::of(200_000, || {
            let sample = lights.sample(by, &ctx, rng.f64(), rng.f32x2());
            sample.map_or(0.0, |s| f64::from(s.radiance.x * s.wi.z.max(0.0) / s.pdf))
        })
    });
    assert!((tree.mean - power.mean).abs() < 5.0 * tree.error.hypot(power.error), "{} {}", tree.mean, power.mean);
    let gain = (power.error / tree.error).powi(2);
    assert!(gain > 50.0, "choices by power have only {gain} times the variance of the tree's");
}

/// As a lamp of one rectangle is: the choice costs nothing, and points are uniform over both halves.
#[test]
fn halves_of_a_rectangle_are_chosen_by_their_area() {
    let at = |x: f32, y: f32| Vec3::new(x, y, 1.0);
    let half = |triangle: u32, corners: [Vec3; 3]| EmissiveTriangle {
        mesh: 0,
        triangle,
        corners,
        radiance: Rgb::ONE,
        two_sided: false,
        group: 0,
        pattern: None,
        slack: 0.0,
    };
    // a trapezium whose halves are 1 : 3
    let [a, b, c, d] = [at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(3.0, 0.0)];
    let lights = Lights::build(&[half(0, [a, b, c]), half(1, [a, c, d])], vec![], 1.0).unwrap();
    assert!(!lights.look_at_points(LightSampler::Tree));
    let (ctx, mut rng) = (place(&mut Rng::new(51)), Rng::new(52));
    assert_eq!([0, 1].map(|light| lights.tree.root(&ctx).pmf(light)), [0.25, 0.75]);
    let mut counts = [0u64; 2];
    for _ in 0..100_000 {
        counts[lights.tree.choose(&ctx, rng.f64()).unwrap().light as usize] += 1;
    }
    assert!(chi2_discrete(&counts, &[0.25, 0.75]).passes(1e-6));
    // bent, or of another brightness, they are two lights
    let mut bent = [half(0, [a, b, c]), half(1, [a, c, d + Vec3::Z * 0.01])];
    assert!(Lights::build(&bent, vec![], 1.0).unwrap().look_at_points(LightSampler::Tree));
    bent[1] = EmissiveTriangle { radiance: Rgb::splat(2.0), ..half(1, [a, c, d]) };
    assert!(Lights::build(&bent, vec![], 1.0).unwrap().look_at_points(LightSampler::Tree));
}

#[test]
fn densities_of_hits_are_those_of_samples() {
    let mut rng = Rng::new(46);
    let (mut near, mut far) = (0, 0);
    for count in SIZES {
        let lights = random_lights(&mut rng, count);
        for _ in 0..3000 {
            let (ctx, u_choice) = (place(&mut rng), rng.f64());
            let Some(choice) = lights.tree.choose(&ctx, u_choice) else { continue };
            let Some(s) = lights.sample(LightSampler::Tree, &ctx, u_choice, rng.f32x2()) else { continue };
            let told = match s.target {
                _ if s.delta => continue,
                None => lights.pdf_environment(LightSampler::Tree, &ctx, s.wi),
                // patterns have tests of their own
                Some(_) if choice.light.is_multiple_of(11) => continue,
                Some(y) => lights.pdf_triangle(LightSampler::Tree, &ctx, choice.light, y.point, [0.3, 0.3]),
            };
            assert!((told / s.pdf - 1.0).abs() < 1e-4, "{told} for {}", s.pdf);
            (near, far) = (near + u32::from(s.target.is_some()), far + u32::from(s.target.is_none()));
        }
    }
    assert!(near > 500 && far > 1000, "{near} {far}");
}

#[test]
fn a_unit_of_length_or_light_changes_no_probability() {
    let build = |length: f32, light: f32| {
        let mut triangles = random_triangles(&mut Rng::new(47), 300);
        for t in &mut triangles {
            t.corners = t.corners.map(|c| c * length);
            t.radiance *= light;
        }
        let point = PointLight { position: Vec3::splat(2.0) * length, intensity: Rgb::splat(light * length * length) };
        let sky = ConstantLight { radiance: Rgb::splat(0.01 * light) };
        Lights::build(&triangles, vec![point.into(), sky.into()], 10.0 * length).unwrap()
    };
    let plain = build(1.0, 1.0);
    for (length, light) in [(2f32.powi(20), 1.0), (2f32.powi(-20), 1.0), (1.0, 2f32.powi(30)), (2f32.powi(7), 0.125)] {
        let (scaled, mut rng) = (build(length, light), Rng::new(48));
        for _ in 0..2000 {
            let (ctx, u) = (place(&mut rng), rng.f64());
            let other = LightSampleContext { p: ctx.p * length, n: ctx.n };
            assert_eq!(plain.tree.choose(&ctx, u), scaled.tree.choose(&other, u));
        }
    }
}

/// A number of 24 bits, or a sum of so many, would draw the faint one at another rate or never.
#[test]
fn faint_lights_are_drawn_at_their_rate() {
    let light = |x: f32, intensity: f32| {
        PointLight { position: Vec3::new(x, 0.0, 5.0), intensity: Rgb::splat(intensity) }.into()
    };
    let lights = Lights::build(&[], vec![light(1.0, 1.0), light(-1.0, 1e-9), light(1.0, 1.0)], 1.0).unwrap();
    let ctx = LightSampleContext::unoriented(Vec3::ZERO);
    let pmf = f64::from(lights.tree.root(&ctx).pmf(1));
    assert!((pmf / 0.5e-9 - 1.0).abs() < 1e-3, "{pmf}");
    let chosen = |u: f64| lights.tree.choose(&ctx, u).unwrap().light;
    let (mut lo, mut hi) = (0.0, 1.0);
    while hi - lo > 1e-15 {
        let middle = 0.5 * (lo + hi);
        if chosen(middle) == chosen(0.0) { lo = middle } else { hi = middle }
    }
    assert_eq!(chosen(hi + 1e-14), 1);
    assert_eq!((chosen(hi + 0.9 * pmf), chosen(hi + 1.1 * pmf) != 1), (1, true));
}

#[test]
fn a_great_many_lights_take_bounded_memory() {
    let mut rng = Rng::new(49);
    let count = 200_000;
    // half of them in a heap at one place, where no cut helps
    let triangles: Vec<_> = (0..count)
        .map(|triangle| {
            let place = if triangle % 2 == 0 { Vec3::splat(0.1) } else { point(&mut rng, 10.0) };
            let corners = [place, place + Vec3::X * 1e-3, place + Vec3::Y * 1e-3];
            EmissiveTriangle {
                mesh: 0,
                triangle,
                corners,
                radiance: Rgb::ONE,
                two_sided: false,
                group: 0,
                pattern: None,
                slack: 0.0,
            }
        })
        .collect();
    let lights = Lights::build(&triangles, vec![], 10.0).unwrap();
    let each = lights.tree.bytes() as f64 / f64::from(count);
    assert!(each < 150.0, "{each} bytes a light");
    let ctx = LightSampleContext::unoriented(Vec3::new(0.1, 0.1, 2.0));
    assert!(lights.tree.choose(&ctx, 0.3).is_some_and(|choice| choice.pmf > 0.0));
}
