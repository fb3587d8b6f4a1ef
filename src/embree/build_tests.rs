use super::*;
use crate::embree::tests::{built, bumpy_ball, random_rays};
use crate::embree::{Device, Isa, Scene};
use crate::format;
use crate::geometry::{Mesh, Ray};
use glam::Vec3;
use std::path::Path;
use std::sync::Arc;

/// How a ray fares on two builds of one mesh.
#[derive(Default)]
struct Likeness {
    same: u32,
    /// Met at one distance but for rounding: on a shared edge.
    tied: u32,
    other: u32,
}

fn likeness(rays: &[Ray], one: &Scene, other: &Scene) -> Likeness {
    let mut found = Likeness::default();
    for ray in rays {
        let hits = [one, other].map(|scene| scene.intersect(ray));
        assert_eq!(hits.map(|hit| hit.is_some()), [one, other].map(|scene| scene.occluded(ray)));
        match hits {
            [None, None] => found.same += 1,
            [Some(a), Some(b)] if a.primitive == b.primitive => found.same += 1,
            [Some(a), Some(b)] if (a.t - b.t).abs() <= 1e-5 * a.t => found.tied += 1,
            _ => found.other += 1,
        }
    }
    found
}

#[test]
fn rays_meet_the_same_whatever_the_quality_of_the_build() {
    let rays = random_rays(20_000);
    for isa in Isa::available() {
        let device = Device::held_to(Some(isa), 1).unwrap();
        for robust in [false, true] {
            let ball = |n, quality| built(&device, bumpy_ball(n), BuildOptions { robust, quality });
            let medium = ball(64, BuildQuality::Medium);
            for quality in [BuildQuality::Low, BuildQuality::High] {
                let Likeness { tied, other, .. } = likeness(&rays, &medium, &ball(64, quality));
                assert!(tied <= 20 && other == 0, "{isa:?}, {quality:?}: {tied} ties, {other} others");
            }
            let Likeness { other, .. } = likeness(&rays, &medium, &ball(61, BuildQuality::Medium));
            assert!(other > 1000, "{other} rays tell another ball apart");
        }
    }
}

/// Without this a quality that never reaches Embree would pass for one that changes no picture.
#[test]
fn each_quality_is_a_structure_of_its_own() {
    let mut mesh = Mesh::default();
    for k in 0..2000 {
        // long, thin and across each other: what the highest quality cuts
        let (sin, cos) = (k as f32).sin_cos();
        let (end, z) = (Vec3::new(cos, sin, 0.0), k as f32 / 2000.0);
        mesh.positions.extend([end, -end, -end * 0.99].map(|p| (p + Vec3::Z * z).to_array()));
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    mesh.positions.reserve(1);
    let mesh = Arc::new(mesh);
    let bytes = BuildQuality::NAMES.map(|(_, quality)| {
        let device = Device::new(1).unwrap();
        let _scene = built(&device, mesh.clone(), BuildOptions { robust: false, quality });
        device.memory()
    });
    assert!(bytes[0] != bytes[1] && bytes[1] != bytes[2] && bytes[0] != bytes[2], "{bytes:?}");
}

#[test]
fn a_scene_file_chooses_it() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let bytes = ["low", "medium"].map(|name| {
        let (file, _) = format::load(&path, &[format!("render.build_quality={name}")]).unwrap();
        file.load_scene(1).unwrap().0.geometry().device().memory()
    });
    assert_ne!(bytes[0], bytes[1]);
    let error = format::load(&path, &["render.build_quality=best".into()]).err().unwrap().to_string();
    assert!(BuildQuality::NAMES.iter().all(|(name, _)| error.contains(name)), "{error}");
}
