use super::{BOTH, Estimate, draw, pdf_environment, pdf_triangle, sphere_integral};
use crate::Error;
use crate::light::environment::Environment;
use crate::light::{ConstantLight, DirectionalLight, EmissiveTriangle, LightSampleContext, Lights, PointLight};
use crate::math::Rgb;
use crate::math::rng::Rng;
use glam::{Affine3A, DVec3, Vec3};
use std::f64::consts::PI;

const GREY: Rgb = Rgb::splat(2.0);

fn triangle(triangle: u32, corners: [Vec3; 3]) -> EmissiveTriangle {
    EmissiveTriangle {
        mesh: 0,
        triangle,
        corners,
        radiance: GREY,
        two_sided: false,
        group: 0,
        pattern: None,
        slack: 0.0,
    }
}

fn quad(c: [Vec3; 4]) -> Vec<EmissiveTriangle> {
    vec![triangle(0, [c[0], c[1], c[2]]), triangle(1, [c[0], c[2], c[3]])]
}

/// The unit square 0 ≤ x, y ≤ 1 at the height 1, shining down.
pub fn ceiling() -> Vec<EmissiveTriangle> {
    let at = |x, y| Vec3::new(x, y, 1.0);
    quad([at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(1.0, 0.0)])
}

/// The square 0 ≤ y, z ≤ 1 at x = 1, shining towards −x.
pub fn wall() -> Vec<EmissiveTriangle> {
    let at = |y, z| Vec3::new(1.0, y, z);
    quad([at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(1.0, 0.0)])
}

fn area_lights(triangles: &[EmissiveTriangle]) -> Lights {
    Lights::build(triangles, vec![], 1.0).unwrap()
}

/// Irradiance (red) at the origin on a surface that faces `n`, unoccluded: it is `truth`, and not another by `control`,
/// however lights are chosen.
fn assert_irradiance(lights: &Lights, n: Vec3, samples: usize, truth: f64, control: f64) {
    let mut rng = Rng::new(21);
    for (by, n_known) in BOTH.into_iter().flat_map(|by| [(by, Vec3::ZERO), (by, n)]) {
        let ctx = LightSampleContext { p: Vec3::ZERO, n: n_known };
        let estimate = Estimate::of(samples, || {
            let sample = lights.sample(by, &ctx, rng.f64(), rng.f32x2());
            sample.map_or(0.0, |s| (s.radiance.x * n.dot(s.wi).max(0.0) / s.pdf) as f64)
        });
        estimate.assert_is(truth, control);
    }
}

/// Form factor from a point to a rectangle a × b in the parallel plane at the distance c, one corner above the point
/// (Howell's catalogue of configuration factors, B-3).
fn parallel_form_factor(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let half = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
    (half(x, y) + half(y, x)) / (2.0 * PI)
}

/// The same for a rectangle at right angles, b wide and a high at the distance c (B-4).
fn perpendicular_form_factor(a: f64, b: f64, c: f64) -> f64 {
    ((b / c).atan() - c / a.hypot(c) * (b / a.hypot(c)).atan()) / (2.0 * PI)
}

#[test]
fn rectangles_light_by_their_form_factors() {
    let truth = 2.0 * PI * parallel_form_factor(1.0, 1.0, 1.0);
    assert_irradiance(&area_lights(&ceiling()), Vec3::Z, 200_000, truth, 0.02);
    let truth = 2.0 * PI * perpendicular_form_factor(1.0, 1.0, 1.0);
    assert_irradiance(&area_lights(&wall()), Vec3::Z, 200_000, truth, 0.02);
}

#[test]
fn inverse_density_averages_to_the_solid_angle() {
    // a unit square with one corner above the point, at the distance 1
    let truth = (1.0 / 3f64.sqrt()).atan();
    let lights = area_lights(&ceiling());
    let mut rng = Rng::new(2);
    let estimate =
        Estimate::of(200_000, || 1.0 / draw(&lights, Vec3::ZERO, rng.f64(), rng.f32x2()).unwrap().pdf as f64);
    estimate.assert_is(truth, 0.02);
}

#[test]
fn ten_thousand_triangles_make_a_disk() {
    let n = 10_000;
    let rim = |i: u32| {
        let (sin, cos) = (2.0 * PI * i as f64 / n as f64).sin_cos();
        DVec3::new(cos, -sin, 1.0).as_vec3()
    };
    let fan: Vec<_> = (0..n).map(|i| triangle(i, [Vec3::Z, rim(i), rim(i + 1)])).collect();
    // F = r²/(r² + h²)
    assert_irradiance(&area_lights(&fan), Vec3::Z, 200_000, 2.0 * PI * 0.5, 0.02);
}

#[test]
fn only_the_near_side_of_a_sphere_lights() {
    let (rings, sectors) = (100, 200);
    let at = |i: u32, j: u32| {
        let (sin, cos) = (PI * i as f64 / rings as f64).sin_cos();
        let (s, c) = (2.0 * PI * j as f64 / sectors as f64).sin_cos();
        DVec3::new(sin * c, sin * s, cos + 3.0).as_vec3()
    };
    let mut triangles = Vec::new();
    for (i, j) in (0..rings).flat_map(|i| (0..sectors).map(move |j| (i, j))) {
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        let name = 2 * triangles.len() as u32;
        triangles.push(triangle(name, [corners[0], corners[1], corners[2]]));
        triangles.push(triangle(name + 1, [corners[0], corners[2], corners[3]]));
    }
    // F = (r/d)²
    let lights = area_lights(&triangles);
    assert_irradiance(&lights, Vec3::Z, 200_000, 2.0 * PI / 9.0, 0.04);
}

fn all_kinds() -> Lights {
    let pixels = (0..50).map(|i| Rgb::splat(if i == 14 { 40.0 } else { 0.1 })).collect();
    let picture = Environment::new(10, 5, pixels, Rgb::ONE, Affine3A::IDENTITY).unwrap();
    let others = vec![
        ConstantLight { radiance: Rgb::splat(0.3) }.into(),
        PointLight { position: Vec3::new(0.0, 3.0, 4.0), intensity: Rgb::splat(50.0) }.into(),
        Box::new(picture).into(),
        DirectionalLight { direction: Vec3::new(0.0, 3.0, -4.0), irradiance: Rgb::splat(1.5) }.into(),
        ConstantLight { radiance: Rgb::splat(0.2) }.into(),
    ];
    Lights::build(&ceiling(), others, 1.5).unwrap()
}

#[test]
fn all_kinds_of_light_add_up() {
    let lights = all_kinds();
    let far = sphere_integral(1500, |w| lights.environment_radiance(w).x as f64 * w.z.max(0.0) as f64);
    let area = 2.0 * PI * parallel_form_factor(1.0, 1.0, 1.0);
    let point = 50.0 / 25.0 * 0.8;
    let directional = 1.5 * 0.8;
    let truth = area + far + point + directional;
    assert_irradiance(&lights, Vec3::Z, 1_000_000, truth, 0.02);
}

#[test]
fn surroundings_have_one_density() {
    let lights = all_kinds();
    let share = sphere_integral(700, |w| pdf_environment(&lights, w) as f64);
    let mut rng = Rng::new(9);
    let (mut far, mut equal, n) = (0.0, 0, 200_000);
    for _ in 0..n {
        let sample = draw(&lights, Vec3::ZERO, rng.f64(), rng.f32x2()).unwrap();
        if sample.target.is_none() && !sample.delta {
            far += 1.0;
            equal += ((pdf_environment(&lights, sample.wi) / sample.pdf - 1.0).abs() < 1e-4) as u32;
            let radiance = lights.environment_radiance(sample.wi);
            assert!((radiance - sample.radiance).length() < 1e-2);
        }
    }
    // directions to the surroundings are as frequent as their density says
    let z = (far / n as f64 - share) / (share * (1.0 - share) / n as f64).sqrt();
    assert!(z.abs() < 5.0 && share > 0.1 && share < 0.9, "{z} {share}");
    assert!(equal as f64 >= far - 20.0, "{equal} of {far}");
}

#[test]
fn points_and_suns_are_delta_lights() {
    let point = PointLight { position: Vec3::new(0.0, 3.0, 4.0), intensity: Rgb::splat(50.0) }.into();
    let lights = Lights::build(&[], vec![point], 1.0).unwrap();
    let sample = draw(&lights, Vec3::ZERO, 0.3, [0.1, 0.2]).unwrap();
    assert_eq!(sample.wi, Vec3::new(0.0, 0.6, 0.8));
    assert_eq!(sample.target.unwrap().point, Vec3::new(0.0, 3.0, 4.0));
    assert_eq!((sample.radiance, sample.pdf, sample.delta), (Rgb::splat(2.0), 1.0, true));
    assert!(draw(&lights, Vec3::new(0.0, 3.0, 4.0), 0.3, [0.1, 0.2]).is_none());
    let sun = DirectionalLight { direction: Vec3::new(0.0, 0.0, -9.0), irradiance: Rgb::ONE }.into();
    let lights = Lights::build(&[], vec![sun], 1.0).unwrap();
    let sample = draw(&lights, Vec3::ONE, 0.3, [0.1, 0.2]).unwrap();
    assert_eq!((sample.wi, sample.target), (Vec3::Z, None));
    assert_eq!((sample.radiance, sample.pdf, sample.delta), (Rgb::ONE, 1.0, true));
    assert_eq!(pdf_environment(&lights, Vec3::Z), 0.0);
    assert_eq!(lights.environment_radiance(Vec3::Z), Rgb::ZERO);
}

#[test]
fn density_of_a_hit_is_that_of_the_sample() {
    let lights = all_kinds();
    let mut rng = Rng::new(4);
    let mut seen = 0;
    for _ in 0..50_000 {
        let p = Vec3::new(rng.f32(), rng.f32(), -rng.f32());
        let Some(s) = draw(&lights, p, rng.f64(), rng.f32x2()) else { continue };
        let Some(surface) = s.target.filter(|_| !s.delta) else { continue };
        // which triangle: the diagonal divides them; a ray finds the point by direction and distance
        let y = surface.point;
        if (y.x - y.y).abs() < 1e-3 {
            continue;
        }
        let light = lights.triangle_light(0, (y.x > y.y) as u32).unwrap();
        let pdf = pdf_triangle(&lights, light, p, y, [0.2, 0.3]);
        assert!((pdf / s.pdf - 1.0).abs() < 1e-4, "{pdf} {}", s.pdf);
        assert_eq!(s.radiance, GREY);
        assert!((surface.point - y).length() < 1e-5 && surface.normal == Vec3::NEG_Z);
        seen += 1;
    }
    assert!(seen > 200);
}

#[test]
fn the_back_shines_only_when_two_sided() {
    let mut triangles = ceiling();
    let above = Vec3::new(0.5, 0.5, 2.0);
    let lights = area_lights(&triangles);
    assert!(draw(&lights, above, 0.5, [0.5, 0.5]).is_none());
    assert_eq!(pdf_triangle(&lights, 0, above, Vec3::new(0.2, 0.6, 1.0), [0.2, 0.3]), 0.0);
    triangles.iter_mut().for_each(|t| t.two_sided = true);
    let lights = area_lights(&triangles);
    let sample = draw(&lights, above, 0.5, [0.5, 0.5]).unwrap();
    assert_eq!(sample.radiance, GREY);
    // both triangles weigh ½, each is ½ m²: the density by area is 1
    let expected = (sample.target.unwrap().point - above).length_squared() / -sample.wi.z;
    assert!((sample.pdf / expected - 1.0).abs() < 1e-5);
}

#[test]
fn two_sides_and_kinds_of_light_compare_by_power() {
    let mut triangles = ceiling();
    triangles[1].two_sided = true;
    let others = vec![
        // 4π·I = 3π and πR²·E = 3π, where the triangles have π and 2π
        PointLight { position: Vec3::ZERO, intensity: Rgb::splat(0.75) }.into(),
        DirectionalLight { direction: Vec3::X, irradiance: Rgb::splat(0.75) }.into(),
        // 4π²R²·L = 9π
        ConstantLight { radiance: Rgb::splat((9.0 / (16.0 * PI)) as f32) }.into(),
    ];
    let lights = Lights::build(&triangles, others, 2.0).unwrap();
    let far = pdf_environment(&lights, Vec3::X) as f64 * 4.0 * PI;
    assert!((far - 0.5).abs() < 1e-5, "{far}");
    let p = Vec3::new(0.3, 0.6, 0.0);
    let density = |light, x, y| pdf_triangle(&lights, light, p, Vec3::new(x, y, 1.0), [0.2, 0.3]);
    // straight up, pmf/A with A = ½
    assert!((density(0, 0.3, 0.6) * 9.0 - 1.0).abs() < 1e-5);
    assert!((density(1, 0.3, 0.6) * 4.5 - 1.0).abs() < 1e-5);
}

#[test]
fn scaling_all_emission_changes_no_density() {
    let build = |scale: f32| {
        let mut triangles = ceiling();
        triangles.iter_mut().for_each(|t| t.radiance *= scale);
        triangles[0].radiance.y *= 3.0;
        let point = PointLight { position: Vec3::ZERO, intensity: Rgb::ONE * scale }.into();
        let sky = ConstantLight { radiance: Rgb::splat(0.1) * scale }.into();
        Lights::build(&triangles, vec![point, sky], 1.0).unwrap()
    };
    let plain = build(1.0);
    for scale in [1e-6, 1e6, 1e-30, 1e30] {
        let scaled = build(scale);
        let mut rng = Rng::new(8);
        for _ in 0..1000 {
            let (p, choice, u) = (Vec3::new(0.5, 0.1, -1.0), rng.f64(), rng.f32x2());
            let pdfs = [&plain, &scaled].map(|l| draw(l, p, choice, u).unwrap().pdf);
            assert!((pdfs[0] / pdfs[1] - 1.0).abs() < 1e-5, "{scale}: {pdfs:?}");
        }
    }
}

/// Small, far, flat, strong and faint triangles: whatever comes out is finite and positive.
#[test]
fn extreme_triangles_give_usable_samples_or_none() {
    let mut rng = Rng::new(13);
    let (mut some, mut none) = (0, 0);
    for i in 0..20_000 {
        let size = 10f32.powi(i % 25 - 18);
        let mut point = |scale: f32| (Vec3::new(rng.f32(), rng.f32(), rng.f32()) - Vec3::splat(0.5)) * scale;
        let centre = point([0.0, 1.0, 1e6][(i % 3) as usize]);
        let corners = [0; 3].map(|_| centre + point(size));
        let p = if i % 7 == 0 { corners[0] } else { centre + point(10f32.powi(i % 11 - 8)) };
        let mut t = triangle(0, corners);
        t.radiance *= 10f32.powi(i % 13 - 6);
        let lights = area_lights(&[t.clone()]);
        match draw(&lights, p, rng.f64(), rng.f32x2()) {
            None => none += 1,
            Some(s) => {
                some += 1;
                assert!(s.pdf > 0.0 && s.pdf.is_finite() && s.target.is_some_and(|t| t.point != p));
                assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.radiance == t.radiance);
            }
        }
    }
    assert!(some > 3000 && none > 3000, "{some} {none}");
}

#[test]
fn a_point_in_the_plane_gets_nothing_and_a_grazing_one_little() {
    let lights = area_lights(&ceiling());
    let corner = Vec3::new(0.0, 0.0, 1.0);
    for p in [Vec3::new(3.0, 0.5, 1.0), corner] {
        assert!(draw(&lights, p, 0.5, [0.5, 0.5]).is_none());
        assert_eq!(pdf_triangle(&lights, 0, p, corner, [0.0; 2]), 0.0);
    }
    let sample = draw(&lights, Vec3::new(3.0, 0.5, 0.999_999), 0.5, [0.5, 0.5]).unwrap();
    assert!(sample.radiance.x / sample.pdf < 1e-6);
}

#[test]
fn what_emits_nothing_is_no_light() {
    let mut triangles = ceiling();
    triangles[0].radiance = Rgb::ZERO;
    triangles.push(triangle(7, [Vec3::ZERO, Vec3::ONE, Vec3::splat(3.0)]));
    let lights = area_lights(&triangles);
    assert_eq!([0, 1, 7].map(|t| lights.triangle_light(0, t)), [None, Some(0), None]);
    assert_eq!(lights.triangle_light(1, 1), None);
    assert!(!lights.are_black() && area_lights(&[]).are_black());
    let dark = ConstantLight { radiance: Rgb::ZERO }.into();
    let lights = Lights::build(&[], vec![dark], 1.0).unwrap();
    assert!(lights.are_black() && draw(&lights, Vec3::ZERO, 0.5, [0.5, 0.5]).is_none());
    assert_eq!(pdf_environment(&lights, Vec3::X), 0.0);
}

#[test]
fn unusable_numbers_are_errors() {
    let build = |edit: fn(&mut EmissiveTriangle)| {
        let mut triangles = ceiling();
        edit(&mut triangles[1]);
        Lights::build(&triangles, vec![], 1.0)
    };
    assert!(build(|_| ()).is_ok());
    let edits: [fn(&mut EmissiveTriangle); 5] = [
        |t| t.radiance.y = f32::NAN,
        |t| t.radiance.y = -1.0,
        |t| t.corners[2].x = f32::INFINITY,
        |t| t.corners = [Vec3::splat(3e38), Vec3::splat(-3e38), Vec3::X],
        |t| t.triangle = 0,
    ];
    for edit in edits {
        let error = build(edit).unwrap_err();
        assert!(matches!(&error, Error::Scene(m) if m.contains("of mesh 0")), "{error}");
    }
    let bad = [
        ConstantLight { radiance: Rgb::splat(f32::NAN) }.into(),
        PointLight { position: Vec3::NAN, intensity: Rgb::ONE }.into(),
        PointLight { position: Vec3::ZERO, intensity: Rgb::splat(-1.0) }.into(),
        DirectionalLight { direction: Vec3::ZERO, irradiance: Rgb::ONE }.into(),
    ];
    for light in bad {
        assert!(Lights::build(&[], vec![light], 1.0).is_err());
    }
    assert!(Lights::build(&[], vec![], f32::NAN).is_err());
}
