//! An instance is what a copy of the mesh in its place would be.

use crate::embree::{Coherence, HitBatch, ShadowBatch};
use crate::format;
use crate::geometry::{Hit, Ray, SurfaceInteraction};
use crate::light::{LightSampleContext, LightSampler};
use crate::math::{rng::Rng, warp};
use crate::scene::Scene;
use glam::{Affine3A, Quat, Vec3};
use std::fmt::Write as _;
use std::path::Path;

/// Two materials, normals that are not the faces' own, texture coordinates; one face glows.
const GEM: &str = "mtllib gem.mtl\n\
    v 1 0 0\nv -1 0 0\nv 0 1.3 0\nv 0 -1 0\nv 0 0 1\nv 0.1 0 -1.2\n\
    vn 1 0.1 0\nvn -1 0 0\nvn 0 1 0\nvn 0 -1 0\nvn 0 0 1\nvn 0.1 0 -1\nvt 0 0\nvt 1 0\nvt 0.3 1\n\
    usemtl red\nf 1/1/1 3/2/3 5/3/5\nf 3/1/3 2/2/2 5/3/5\nf 2/1/2 4/2/4 5/3/5\nusemtl glow\nf 4/1/4 1/2/1 5/3/5\n\
    usemtl red\nf 3 1 6\nf 2 3 6\nf 4//4 2//2 6//6\nf 1 4 6\n";
const RING: &str = "v -2 -0.5 -2\nv 2 -0.5 -2\nv 2 -0.5 2\nv -2 -0.5 2\nf 1 4 3 2\n";
const FLOOR: &str = "v -40 -4 -40\nv 40 -4 -40\nv 40 -4 40\nv -40 -4 40\nf 4 3 2 1\n";
/// With a picture, without which a scene has no texture coordinates.
const LIBRARY: &str = "newmtl red\nKd 0.7 0.1 0.1\nnewmtl glow\nmap_Kd black.png\nKe 3 4 5\n";

/// Moved, stretched, turned, mirrored, far away.
fn places() -> Vec<Affine3A> {
    let turn = |angle: f32| Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), angle);
    let place = |scale: [f32; 3], angle: f32, at: [f32; 3]| {
        Affine3A::from_scale_rotation_translation(scale.into(), turn(angle), at.into())
    };
    vec![
        place([1.0; 3], 0.0, [0.0; 3]),
        place([1.0, 2.5, 0.4], 0.7, [6.0, 1.0, 0.0]),
        place([-1.0, 1.0, 1.0], 2.0, [-6.0, 0.5, 1.0]),
        place([-0.5, -1.5, -1.0], 4.0, [0.0, 2.0, 7.0]),
        place([2.0; 3], 1.0, [1.0, 0.0, -300.0]),
    ]
}

/// The key of a scene file that says `m`.
fn matrix(m: Affine3A) -> String {
    let m = m.to_cols_array();
    format!("matrix = {:?}", [0, 1, 2].map(|r| [m[r], m[3 + r], m[6 + r], m[9 + r]]))
}

/// Where the second mesh of the group stands in it.
const WITHIN: &str = "scale = [1, 1, 0.5]\ntranslate = [0, -1, 0.25]\n";

fn load(folder: &Path, text: &str) -> Scene {
    for (name, text) in [("gem.obj", GEM), ("ring.obj", RING), ("floor.obj", FLOOR), ("gem.mtl", LIBRARY)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    image::RgbImage::new(1, 1).save(folder.join("black.png")).unwrap();
    let (description, _) = format::parse(text, &folder.join("scene.toml"), &[]).unwrap();
    let (scene, warnings) = description.load_scene(1).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    scene
}

/// A floor, and in every place a gem on a plate.
fn instanced(folder: &Path) -> Scene {
    let mut text = String::from("[[mesh]]\npath = 'floor.obj'\n[[mesh]]\npath = 'gem.obj'\ngroup = 'gem'\n");
    let _ = writeln!(text, "[[mesh]]\npath = 'ring.obj'\ngroup = 'gem'\n{WITHIN}");
    for place in places() {
        let _ = writeln!(text, "[[instance]]\ngroup = 'gem'\n{}", matrix(place));
    }
    load(folder, &text)
}

/// The same without instances.
fn copied(folder: &Path) -> Scene {
    let mut text = String::from("[[mesh]]\npath = 'floor.obj'\n");
    let within =
        Affine3A::from_scale_rotation_translation(Vec3::new(1.0, 1.0, 0.5), Quat::IDENTITY, Vec3::new(0.0, -1.0, 0.25));
    for place in places() {
        let _ = writeln!(text, "[[mesh]]\npath = 'gem.obj'\n{}", matrix(place));
        let _ = writeln!(text, "[[mesh]]\npath = 'ring.obj'\n{}", matrix(place * within));
    }
    load(folder, &text)
}

/// Rays from around each place towards it.
fn rays(n: usize) -> Vec<Ray> {
    let (mut rng, places) = (Rng::new(17), places());
    (0..n)
        .map(|k| {
            let place = places[k % places.len()];
            let mut point = || warp::square_to_uniform_sphere(rng.f32x2());
            let (org, aim) = (Vec3::from(place.translation) + point() * 8.0, place.transform_point3(point()));
            Ray { org, dir: (aim - org).normalize(), tfar: f32::INFINITY }
        })
        .collect()
}

/// What is seen of a scene along a ray, as far as two scenes can be compared.
fn seen(scene: &Scene, ray: &Ray) -> Option<(Hit, SurfaceInteraction)> {
    let hit = scene.geometry().intersect(ray)?;
    Some((hit, scene.interaction(&hit, -ray.dir)))
}

#[test]
fn hits_on_instances_are_those_on_copies() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (instanced(folder.path()), copied(folder.path()));
    let (mut compared, mut lights, mut at_edges) = (0, 0, 0);
    for ray in rays(6000) {
        let (a, b) = (seen(&one, &ray), seen(&other, &ray));
        let (Some((ha, a)), Some((hb, b))) = (a, b) else {
            at_edges += (a.is_some() != b.is_some()) as u32;
            continue;
        };
        if ha.primitive != hb.primitive || (ha.t - hb.t).abs() > 1e-3 * ha.t {
            at_edges += 1;
            continue;
        }
        let scale = 1.0 + a.p.abs().max_element();
        assert!((a.p - b.p).length() < 1e-5 * scale, "{} against {}", a.p, b.p);
        assert!(a.ng.dot(b.ng) > 0.9999 && a.frame.n.dot(b.frame.n) > 0.999, "{:?} {:?}", a, b);
        assert_eq!((a.front, one.emission(&a)), (b.front, other.emission(&b)));
        let albedo = |s: &Scene, si: &SurfaceInteraction| {
            s.bsdf(s.material(si.material), si.uv, || crate::math::Rgb::ONE).albedo(Vec3::Z)
        };
        assert_eq!(albedo(&one, &a), albedo(&other, &b));
        let (by, from) = (LightSampler::Power, LightSampleContext::unoriented(ray.org));
        let (pa, pb) = (one.emitter_pdf(by, &from, &ha, &a), other.emitter_pdf(by, &from, &hb, &b));
        assert!((pa - pb).abs() <= 2e-3 * pb, "{pa} against {pb}");
        lights += (pa > 0.0) as u32;
        compared += 1;
    }
    assert!(compared > 4000 && lights > 100 && at_edges < 10, "{compared} hits, {lights} lights, {at_edges} at edges");
}

#[test]
fn texture_coordinates_are_those_of_copies() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (instanced(folder.path()), copied(folder.path()));
    let mut compared = 0;
    for ray in rays(6000) {
        let (Some((ha, a)), Some((hb, b))) = (seen(&one, &ray), seen(&other, &ray)) else { continue };
        // the gem's first four faces have texture coordinates; the rest falls back on weights of corners
        let glows = |s: &Scene, si: &SurfaceInteraction| s.emission(si) != crate::math::Rgb::ZERO;
        if glows(&one, &a) && glows(&other, &b) && ha.primitive == hb.primitive {
            assert!((a.uv[0] - b.uv[0]).abs() < 1e-4 && (a.uv[1] - b.uv[1]).abs() < 1e-4, "{:?} {:?}", a.uv, b.uv);
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn every_way_of_asking_finds_the_same_instance() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, rays) = (instanced(folder.path()), rays(1003));
    for coherence in [Coherence::Coherent, Coherence::Incoherent] {
        let (mut hits, mut shadows): (HitBatch, ShadowBatch) =
            (HitBatch::with_capacity(0), ShadowBatch::with_capacity(0));
        rays.iter().for_each(|ray| hits.push(ray));
        rays.iter().for_each(|ray| shadows.push(ray));
        hits.trace(scene.geometry(), coherence);
        shadows.trace(scene.geometry(), coherence);
        for (i, ray) in rays.iter().enumerate() {
            let names = |hit: Hit| (hit.instance, hit.geometry, hit.primitive);
            let one = scene.geometry().intersect(ray);
            assert_eq!(one.map(names), hits.hit(i).map(names), "ray {i}, {coherence:?}");
            assert_eq!(one.is_some(), shadows.occluded(i), "shadow ray {i}, {coherence:?}");
        }
    }
}

#[test]
fn what_is_counted_is_counted_in_every_place() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (instanced(folder.path()), copied(folder.path()));
    assert_eq!(one.triangles(), other.triangles());
    assert_eq!(one.facets().count(), one.triangles());
    let area =
        |scene: &Scene| -> f64 { scene.facets().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length() as f64).sum() };
    assert!((area(&one) / area(&other) - 1.0).abs() < 1e-5);
    // the sum over a closed surface of what its facets face is zero, of either winding; the plates tell
    let faced = |scene: &Scene| -> Vec3 { scene.facets().map(|[a, b, c]| (b - a).cross(c - a)).sum() };
    assert!((faced(&one) - faced(&other)).length() < 1e-3 * faced(&other).length());
    let ((low, high), (inner_low, inner_high)) = (one.bounds(), other.bounds());
    assert!((low - inner_low).max_element() < 1e-3 && (high - inner_high).min_element() > -1e-3);
    assert_ne!(one.content_hash_text(), other.content_hash_text());
}

#[test]
fn rays_that_leave_an_instance_do_not_meet_it_again() {
    let folder = tempfile::tempdir().unwrap();
    let scene = instanced(folder.path());
    let (mut rng, mut left) = (Rng::new(5), 0);
    for ray in rays(4000) {
        let Some((hit, si)) = seen(&scene, &ray) else { continue };
        // gems are convex: what leaves one by its front is gone from it
        if hit.instance == u32::MAX || hit.geometry != 0 || !si.front {
            continue;
        }
        let w = warp::square_to_cosine_hemisphere(rng.f32x2());
        let outward = crate::math::Frame::from_normal(si.ng * si.ng.dot(-ray.dir).signum()).to_world(w);
        let next = Ray { org: si.spawn(outward), dir: outward, tfar: f32::INFINITY };
        let again = scene.geometry().intersect(&next).filter(|h| (h.instance, h.geometry) == (hit.instance, 0));
        assert!(again.is_none(), "{hit:?} again at {:?}", again);
        left += 1;
    }
    assert!(left > 1000, "{left}");
}

#[test]
fn a_thousand_places_cost_little_more_than_one() {
    let folder = tempfile::tempdir().unwrap();
    crate::lab::generate::large::generate("terrain", 10_000, folder.path()).unwrap();
    let memory = |places: usize| {
        let mut text = String::from("[[mesh]]\npath = 'terrain.obj'\ngroup = 'hill'\n");
        for k in 0..places {
            let _ = writeln!(text, "[[instance]]\ngroup = 'hill'\ntranslate = [{}, {}, 0]", k % 32, k / 32);
        }
        text += "[[light]]\ntype = 'constant'\nradiance = 1\n";
        let (description, _) = format::parse(&text, &folder.path().join("scene.toml"), &[]).unwrap();
        let (scene, _) = description.load_scene(1).unwrap();
        assert_eq!(scene.triangles(), places * 10_082);
        (scene.geometry().device().memory(), scene)
    };
    let ((one, _), (thousand, scene)) = (memory(1), memory(1000));
    // 10 082 triangles are some 700 kB in Embree, an instance is some 500 B
    assert!(one > 300_000 && thousand < 2 * one + 600_000, "{one} and {thousand} bytes");
    assert_eq!(scene.instances.groups.iter().flatten().count(), 1);
}

#[test]
fn empty_groups_are_not_seen_and_places_out_of_reach_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    load(folder.path(), "[[mesh]]\npath = 'floor.obj'\n[[light]]\ntype = 'constant'\nradiance = 1\n");
    std::fs::write(folder.path().join("none.obj"), "v 0 0 0\n").unwrap();
    let with = |mesh: &str, place: &str| {
        let text = format!(
            "[[mesh]]\npath = 'floor.obj'\n[[mesh]]\npath = '{mesh}'\ngroup = 'a'\n[[instance]]\ngroup = 'a'\n{place}\n\
             [[instance]]\ngroup = 'a'\n[[light]]\ntype = 'constant'\nradiance = 1\n"
        );
        let (description, _) = format::parse(&text, &folder.path().join("scene.toml"), &[]).unwrap();
        description.load_scene(1).map(|(scene, _)| scene)
    };
    assert_eq!(with("none.obj", "").unwrap().triangles(), 2);
    assert_eq!(with("ring.obj", "translate = [1e11, 0, 0]").unwrap().triangles(), 6);
    let message = with("ring.obj", "scale = 1e12").err().expect("2·10¹² is too far").to_string();
    assert!(message.contains("`a`"), "{message}");
}
