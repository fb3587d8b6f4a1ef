use super::*;
use crate::math::rng::Rng;
use glam::DVec3;

/// At (0, 0, 5), which looks at the origin with a film of 200 × 100 pixels.
fn described(change: impl Fn(&mut CameraDescription)) -> CameraDescription {
    let mut c = CameraDescription { origin: DVec3::new(0.0, 0.0, 5.0), vfov: 90.0, ..CameraDescription::default() };
    change(&mut c);
    c
}

fn film(crop: Option<[u32; 4]>) -> FilmSettings {
    FilmSettings { width: 200, height: 100, crop, ..FilmSettings::default() }
}

fn on_film(change: impl Fn(&mut CameraDescription)) -> Camera {
    Camera::new(&described(change), &film(None)).unwrap()
}

fn camera(mirrored: bool) -> Camera {
    on_film(|c| c.mirrored = mirrored)
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

/// What a packet has in its last lane for this pixel; its others are of other pixels.
fn sampled(camera: &Camera, [x, y]: [u32; 2], film: [f32; 2], lens: [f32; 2]) -> Ray {
    let row = |last: f32| std::array::from_fn(|k| if k == LANES - 1 { last } else { k as f32 / 20.0 });
    let pixels = [x, y].map(|last| std::array::from_fn(|k| if k == LANES - 1 { last } else { 3 * k as u32 }));
    let (mut org, mut dir) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
    camera.rays(pixels.each_ref(), &film.map(row), [&mut org, &mut dir]);
    camera.bend(&lens.map(row), [&mut org, &mut dir]);
    Ray { org: org.get(LANES - 1), dir: dir.get(LANES - 1), tfar: f32::INFINITY }
}

#[test]
fn rays_side_by_side_are_those_of_each_alone() {
    let mut rng = Rng::new(8);
    for projection in [Projection::Perspective, Projection::Orthographic, Projection::Panorama] {
        for filter in [Filter::Box, Filter::Tent, Filter::Gaussian] {
            let described = described(|c| (c.projection, c.view_height) = (projection, 3.0));
            let camera = Camera::new(&described, &FilmSettings { filter, ..film(Some([30, 40, 60, 20])) }).unwrap();
            for x in 0..60 {
                let (y, u) = (rng.next_u32() % 20, rng.f32x2());
                let (one, many) = (camera.ray(x, y, u), sampled(&camera, [x, y], u, rng.f32x2()));
                assert_eq!((one.org, one.dir), (many.org, many.dir), "{projection:?}, {filter:?}, {x}, {y}");
            }
        }
    }
}

#[test]
fn an_orthographic_camera_looks_one_way_from_a_plane() {
    let camera = on_film(|c| (c.projection, c.view_height) = (Projection::Orthographic, 3.0));
    for (x, y, u, org) in [(0, 0, 0.0, [-3.0, 1.5]), (100, 50, 0.0, [0.0, 0.0]), (199, 99, 1.0, [3.0, -1.5])] {
        let ray = camera.ray(x, y, [u; 2]);
        assert!(near(ray.org, Vec3::new(org[0], org[1], 5.0)) && near(ray.dir, -Vec3::Z), "{ray:?}");
    }
}

#[test]
fn a_panorama_sees_all_directions_alike() {
    let camera = on_film(|c| c.projection = Projection::Panorama);
    for (x, y, dir) in [(100, 50, -Vec3::Z), (150, 50, Vec3::X), (50, 50, -Vec3::X), (0, 50, Vec3::Z), (7, 0, Vec3::Y)]
    {
        assert!(near(camera.ray(x, y, [0.0; 2]).dir, dir), "{x}, {y}");
    }
    assert!(near(
        on_film(|c| (c.projection, c.mirrored) = (Projection::Panorama, true)).ray(150, 50, [0.0; 2]).dir,
        -Vec3::X
    ));
}

#[test]
fn a_lens_is_sharp_in_its_plane_and_a_disk_elsewhere() {
    let camera = on_film(|c| (c.aperture_radius, c.focus_distance) = (0.5, Some(2.0)));
    let (mut rng, mut sum, n) = (Rng::new(3), 0.0, 4000);
    for _ in 0..n {
        let (film, lens) = (rng.f32x2(), rng.f32x2());
        let (ray, sharp) = (sampled(&camera, [20, 30], film, lens), camera.ray(20, 30, film));
        let at = |ray: &Ray, z: f32| ray.org + ray.dir * ((z - ray.org.z) / ray.dir.z);
        assert!(near(at(&ray, 3.0), at(&sharp, 3.0)), "the plane of focus is 2 before the camera");
        let off = (ray.org - sharp.org).length();
        assert!(off <= 0.5 + 1e-6 && ray.org.z == 5.0);
        sum += f64::from(off * off);
    }
    // E r² of an even disk is R²/2 with variance R⁴/12
    let (mean, error) = (sum / f64::from(n), 0.25 / 12f64.sqrt() / f64::from(n).sqrt());
    assert!((mean - 0.125).abs() < 5.0 * error, "{mean}");
    let far = on_film(|c| c.aperture_radius = 0.5);
    assert!((far.lens.unwrap().focus - 5.0).abs() < 1e-6, "the target is in focus");
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let whole = camera(false);
    let part = Camera::new(&described(|_| ()), &film(Some([30, 40, 20, 10]))).unwrap();
    assert_eq!((part.width, part.height, part.corner()), (20, 10, [30, 40]));
    assert_eq!(part.pixel(3, 2), whole.pixel(33, 42));
    assert_eq!(part.ray(3, 2, [0.3; 2]).dir, whole.ray(33, 42, [0.3; 2]).dir);
}

#[test]
fn fewer_pixels_see_the_same() {
    for projection in [Projection::Perspective, Projection::Orthographic, Projection::Panorama] {
        for crop in [None, Some([30, 40, 60, 20])] {
            let described = described(|c| (c.projection, c.view_height) = (projection, 3.0));
            let fine = Camera::new(&described, &FilmSettings { filter: Filter::Box, ..film(crop) }).unwrap();
            let coarse = fine.coarser(u64::from(fine.width * fine.height) / 4);
            assert_eq!([2 * coarse.width, 2 * coarse.height], [fine.width, fine.height]);
            for (x, y) in [(0, 0), (coarse.width - 1, 0), (7, 3), (0, coarse.height - 1)] {
                // the middle of a coarse pixel is a corner of four fine ones
                let (a, b) = (coarse.ray(x, y, [0.5; 2]), fine.ray(2 * x, 2 * y, [1.0; 2]));
                assert!(near(a.org, b.org) && near(a.dir, b.dir), "{projection:?}, {crop:?}, {x}, {y}");
            }
            assert_eq!(coarse.pixel(coarse.width - 1, coarse.height - 1) + 1, coarse.width * coarse.height);
        }
    }
}

#[test]
fn the_upper_left_pixel_looks_up_and_left() {
    let d = camera(false).ray(0, 0, [0.0, 0.0]).dir;
    // vertical field 90°: the upper edge is at 45°; the film is twice as wide as high
    assert!((d - Vec3::new(-2.0, 1.0, -1.0).normalize()).length() < 1e-6, "{d}");
    assert!(camera(true).ray(0, 0, [0.0, 0.0]).dir.x > 0.0);
}

#[test]
fn filters_have_their_variance() {
    // box: 1/12; tent: 1/6; Gaussian cut at 3σ: σ²·(1 − 6φ(3)/(2Φ(3) − 1)) = 0.2433
    for (filter, expected) in [(Filter::Box, 1.0 / 12.0), (Filter::Tent, 1.0 / 6.0), (Filter::Gaussian, 0.243_3)] {
        let n = 100_000;
        let moment = |power: i32| {
            (0..n).map(|i| (filter.warp((i as f32 + 0.5) / n as f32) as f64).powi(power)).sum::<f64>() / n as f64
        };
        assert!(moment(1).abs() < 1e-3 && (moment(2) - expected).abs() < 1e-3, "{filter:?}: {}", moment(2));
    }
}
