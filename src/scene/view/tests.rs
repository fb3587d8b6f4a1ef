//! Models of a few quads, and where the camera stands for them.

use super::FoundCamera;
use super::header::up_of_text;
use crate::embree::BuildOptions;
use crate::geometry::Mesh;
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::scene::Scene;
use crate::scene::description::{
    CameraDescription, MaterialDescription, MeshDescription, Projection, SceneDescription, Unsaid,
};
use crate::scene::model::{MeshSource, Model};
use glam::{Affine3A, DAffine3, DVec3, Mat3, Quat, Vec3, vec3};
use std::sync::Arc;

const GREY: usize = 0;
const LAMP: usize = 1;

/// A model under construction, with y up.
#[derive(Clone, Default)]
struct Builder {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
}

impl Builder {
    /// Four corners, counter-clockwise from where it is seen.
    fn quad(mut self, corners: [Vec3; 4], material: usize) -> Builder {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        self.materials.extend([material as u32; 2]);
        self
    }

    /// The sides of a box, seen from outside, but for those in `open`: 0 to 5 are −x, +x, −y, +y, −z and +z.
    fn cuboid(mut self, low: Vec3, high: Vec3, open: &[usize]) -> Builder {
        for side in (0..6).filter(|side| !open.contains(side)) {
            let (axis, upper) = (side / 2, side % 2 == 1);
            let corner = |u: bool, v: bool| {
                let mut p = if upper { high } else { low };
                let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
                p[a] = if u { high[a] } else { low[a] };
                p[b] = if v { high[b] } else { low[b] };
                p
            };
            let mut corners = [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
            if !upper {
                corners.reverse();
            }
            self = self.quad(corners, GREY);
        }
        self
    }

    /// A lamp under the middle of a ceiling, which shines downwards.
    fn lamp(self, at: Vec3, half: f32) -> Builder {
        let corner = |x: f32, z: f32| at + vec3(x * half, 0.0, z * half);
        self.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], LAMP)
    }

    fn moved(mut self, by: Affine3A) -> Builder {
        self.positions.iter_mut().for_each(|p| *p = by.transform_point3(*p));
        self
    }

    fn description(&self) -> SceneDescription {
        let emission = Rgb::splat(5.0);
        let lamp = MaterialDescription { emission, ..Default::default() };
        let model = Model {
            mesh: Mesh {
                positions: self.positions.iter().map(|p| p.to_array()).collect(),
                triangles: self.triangles.clone(),
                materials: self.materials.clone(),
                ..Default::default()
            },
            material_names: vec!["grey".into(), "lamp".into()],
            materials: [("grey".into(), MaterialDescription::default()), ("lamp".into(), lamp)].into(),
            parts: Vec::new(),
            warnings: Vec::new(),
            origin: DVec3::ZERO,
        };
        let (source, transform) = (MeshSource::Memory(Arc::new(model)), DAffine3::IDENTITY);
        let mesh =
            MeshDescription { source, transform, material: None, material_location: None, group: None, location: None };
        SceneDescription { meshes: vec![mesh], sky_where_dark: true, ..Default::default() }
    }

    fn load(&self) -> (Scene, Vec<String>) {
        Scene::load(&self.description(), 1, BuildOptions::default()).unwrap()
    }

    /// The camera of the model alone.
    fn found(&self) -> FoundCamera {
        self.load().0.found_camera().unwrap().clone()
    }

    /// The camera of which this much is said.
    fn completed(&self, camera: CameraDescription) -> CameraDescription {
        let description = SceneDescription { camera: Some(camera), ..self.description() };
        Scene::load(&description, 1, BuildOptions::default()).unwrap().0.found_camera().unwrap().camera.clone()
    }

    /// Where its points are in the picture: the largest coordinate of each axis, 1 being the edge.
    fn extent(&self, camera: &CameraDescription, aspect: f32) -> [f32; 2] {
        let origin = camera.origin.as_vec3();
        let forward = (camera.target - camera.origin).as_vec3().normalize();
        let right = forward.cross(camera.up).normalize();
        let half = (0.5 * camera.vfov.to_radians()).tan();
        let of = |axis: Vec3, half: f32| {
            let place = |p: &Vec3| (*p - origin).dot(axis) / ((*p - origin).dot(forward) * half);
            self.positions.iter().map(|p| place(p).abs()).fold(0.0, f32::max)
        };
        [of(right, half * aspect), of(right.cross(forward), half)]
    }
}

/// A body with a spout and a lid on nothing.
fn pot() -> Builder {
    let body = Builder::default().cuboid(vec3(-1.0, 0.0, -1.0), vec3(1.0, 1.4, 1.0), &[]);
    body.cuboid(vec3(1.0, 0.6, -0.2), vec3(1.8, 0.9, 0.2), &[]).cuboid(vec3(-0.3, 1.4, -0.3), vec3(0.3, 1.7, 0.3), &[])
}

/// A room of 6 × 3 × 4 with a table and a lamp, `open` on some sides.
fn room(open: &[usize]) -> Builder {
    let (low, high) = (vec3(0.0, 0.0, 0.0), vec3(6.0, 3.0, 4.0));
    let walls = Builder::default().cuboid(low, high, open).cuboid(vec3(1.0, 0.0, 1.0), vec3(2.0, 0.8, 3.0), &[2]);
    walls.lamp(vec3(3.0, 2.9, 2.0), 0.5)
}

fn within(p: Vec3, low: Vec3, high: Vec3) -> bool {
    p.cmpgt(low).all() && p.cmplt(high).all()
}

#[test]
fn an_object_fills_the_picture_from_outside() {
    let FoundCamera { camera, outside, lit } = pot().found();
    assert!(outside && lit);
    let [across, upwards] = pot().extent(&camera, 1280.0 / 720.0);
    assert!((0.9..0.951).contains(&across.max(upwards)) && across.min(upwards) < 0.951, "{across} {upwards}");
    assert_eq!(camera.up, Vec3::Y);
    assert!(camera.origin.y > 1.0, "it is looked at from above: {camera:?}");
    assert_eq!(camera.unsaid, Unsaid::default());
}

#[test]
fn a_room_is_seen_from_inside() {
    let FoundCamera { camera, outside, lit } = room(&[]).found();
    assert!(!outside && lit);
    assert!(within(camera.origin.as_vec3(), vec3(0.3, 0.8, 0.3), vec3(5.7, 2.2, 3.7)), "{camera:?}");
    assert!((camera.target - camera.origin).normalize().y.abs() < 1e-6, "the horizon is in the middle: {camera:?}");
}

#[test]
fn a_room_that_is_open_shows_its_inside() {
    let (low, high) = (vec3(0.0, 0.0, 0.0), vec3(6.0, 3.0, 4.0));
    for (side, towards) in [(5, -Vec3::Z), (4, Vec3::Z)] {
        let camera = room(&[side]).found().camera;
        assert!(
            (camera.target - camera.origin).normalize().as_vec3().dot(towards) > 0.7,
            "open on side {side}: {camera:?}"
        );
        assert!(
            within(camera.target.as_vec3(), low - 0.1, high + 0.1),
            "what is in the middle is in the room: {camera:?}"
        );
    }
}

#[test]
fn a_room_without_a_lamp_is_seen_from_outside_under_a_sky() {
    let dark = Builder::default().cuboid(Vec3::ZERO, vec3(6.0, 3.0, 4.0), &[]);
    let (scene, warnings) = dark.load();
    let found = scene.found_camera().unwrap();
    assert!(found.outside && found.lit);
    assert_eq!(warnings, ["nothing emits light in this scene: a constant sky of radiance 1 is added"]);
}

#[test]
fn a_lamp_that_lights_nothing_one_can_see_gets_a_sky() {
    // within a solid that has no opening, and where no room is
    let hidden = pot().lamp(vec3(0.0, 1.0, 0.0), 0.01);
    let solid = hidden.cuboid(vec3(-0.02, 0.98, -0.02), vec3(0.02, 1.02, 0.02), &[]);
    let (scene, warnings) = solid.load();
    let found = scene.found_camera().unwrap();
    assert!(found.outside && found.lit, "{warnings:?}");
    assert_eq!(warnings, ["no light of this model reaches the camera: a constant sky of radiance 1 is added"]);
    assert_eq!(scene.lights().environment_radiance(Vec3::Y), scene.light_unit().divide(Rgb::ONE));
    // a room with a lamp has none added
    let (lit, warnings) = room(&[]).load();
    assert!(warnings.is_empty() && lit.lights().environment_radiance(Vec3::Y) == Rgb::ZERO, "{warnings:?}");
    // nor has the same solid in a scene that somebody has made
    let described = SceneDescription { sky_where_dark: false, ..solid.description() };
    assert!(Scene::load(&described, 1, BuildOptions::default()).unwrap().1.is_empty());
}

#[test]
fn a_camera_of_the_user_s_gets_a_sky_too() {
    let camera = CameraDescription {
        origin: DVec3::new(3.0, 2.0, 30.0),
        target: DVec3::new(3.0, 1.5, 2.0),
        unsaid: Unsaid::default(),
        ..Default::default()
    };
    let description = SceneDescription { camera: Some(camera), ..room(&[]).description() };
    let (scene, warnings) = Scene::load(&description, 1, BuildOptions::default()).unwrap();
    assert!(scene.found_camera().is_none());
    assert_eq!(warnings.len(), 1, "outside of a closed room it is dark: {warnings:?}");
}

/// A field of heights.
fn terrain() -> Builder {
    let height = |x: usize, z: usize| ((x as f32 * 0.7).sin() + (z as f32 * 0.9).cos()) * 0.5;
    let corner = |x: usize, z: usize| vec3(x as f32, height(x, z), z as f32);
    (0..400).fold(Builder::default(), |b, k| {
        let (x, z) = (k % 20, k / 20);
        b.quad([corner(x, z), corner(x, z + 1), corner(x + 1, z + 1), corner(x + 1, z)], GREY)
    })
}

#[test]
fn a_terrain_is_seen_from_above() {
    let FoundCamera { camera, outside, .. } = terrain().found();
    assert!(outside && camera.origin.y > 3.0, "{camera:?}");
    let [across, upwards] = terrain().extent(&camera, 1280.0 / 720.0);
    assert!((0.9..0.951).contains(&across.max(upwards)), "{across} {upwards}");
}

#[test]
fn what_stands_on_a_wide_ground_fills_the_picture() {
    let ground = |b: Builder, half: f32| b.cuboid(vec3(-half, -0.02 * half, -half), vec3(half, 0.0, half), &[]);
    let camera = ground(pot(), 40.0).found().camera;
    let [across, upwards] = pot().extent(&camera, 1280.0 / 720.0);
    assert!((0.9..0.951).contains(&across.max(upwards)), "{across} {upwards}");
    // walls that face each other are no backdrop, however small what else there is
    let house = Builder::default().cuboid(Vec3::ZERO, vec3(6.0, 4.0, 5.0), &[]);
    let knob = house.cuboid(vec3(3.0, 1.0, 5.0), vec3(3.1, 1.1, 5.1), &[]);
    let [across, upwards] = knob.extent(&knob.found().camera, 1280.0 / 720.0);
    assert!((0.9..0.951).contains(&across.max(upwards)), "{across} {upwards}");
}

#[test]
fn the_size_of_a_model_changes_nothing() {
    for model in [pot(), room(&[]), room(&[5]), terrain()] {
        let camera = model.found().camera;
        for scale in [1.0 / 1024.0, 1024.0 * 1024.0] {
            let scaled = model.clone().moved(Affine3A::from_scale(Vec3::splat(scale))).found().camera;
            assert_eq!(
                (scaled.origin, scaled.target),
                (camera.origin * f64::from(scale), camera.target * f64::from(scale))
            );
            assert_eq!((scaled.up, scaled.vfov), (camera.up, camera.vfov));
        }
        // as good in millimetres, where other digits are rounded
        let scaled = model.clone().moved(Affine3A::from_scale(Vec3::splat(1000.0))).found().camera;
        let off = (scaled.origin - camera.origin * 1000.0).length() / (camera.origin * 1000.0).length();
        assert!(off < 1e-3, "{scaled:?} and {camera:?}");
    }
}

#[test]
fn threads_change_nothing() {
    let find = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| room(&[5]).found().camera)
    };
    assert_eq!(find(1), find(3));
}

#[test]
fn what_is_said_of_the_camera_is_kept() {
    let said = |unsaid: Unsaid, camera: CameraDescription| CameraDescription { unsaid, ..camera };
    for model in [pot(), room(&[])] {
        let wide = said(Unsaid { vfov: false, ..Unsaid::ALL }, CameraDescription { vfov: 90.0, ..Default::default() });
        let found = model.completed(wide);
        assert_eq!(found.vfov, 90.0);
        let closer = model.found().camera;
        assert!(found.vfov > closer.vfov && found.origin.is_finite());

        let (origin, target) = (DVec3::new(3.0, 1.5, 2.5), DVec3::new(1.5, 0.75, 2.0));
        let from = model.completed(said(
            Unsaid { origin: false, ..Unsaid::ALL },
            CameraDescription { origin, ..Default::default() },
        ));
        assert_eq!(from.origin, origin);
        assert!(from.target != origin);
        let at = model.completed(said(
            Unsaid { target: false, ..Unsaid::ALL },
            CameraDescription { target, ..Default::default() },
        ));
        assert_eq!(at.target, target);
        assert!(at.origin != target && at.origin.is_finite());
        let mirrored = model.completed(CameraDescription { mirrored: true, ..CameraDescription::open() });
        assert!(mirrored.mirrored);
        assert_eq!(mirrored.origin, closer.origin);
    }
}

#[test]
fn an_orthographic_camera_has_all_of_an_object_in_its_picture() {
    let parallel = CameraDescription { projection: Projection::Orthographic, ..CameraDescription::open() };
    let CameraDescription { origin, target, up, view_height, .. } = pot().completed(parallel);
    let (origin, target) = (origin.as_vec3(), target.as_vec3());
    let right = (target - origin).normalize().cross(up).normalize();
    let above = right.cross((target - origin).normalize());
    let of = |axis: Vec3, half: f32| {
        pot().positions.iter().map(|p| ((*p - origin).dot(axis) / half).abs()).fold(0.0, f32::max)
    };
    let [across, upwards] = [of(right, 0.5 * view_height * 1280.0 / 720.0), of(above, 0.5 * view_height)];
    assert!((0.9..0.951).contains(&across.max(upwards)), "{across} {upwards}");
    let said = Unsaid { view_height: false, ..Unsaid::ALL };
    let parallel = CameraDescription {
        projection: Projection::Orthographic,
        view_height: 9.0,
        unsaid: said,
        ..Default::default()
    };
    assert_eq!(pot().completed(parallel).view_height, 9.0);
}

#[test]
fn a_place_outside_looks_at_the_model_and_sees_all_of_it() {
    let origin = DVec3::new(0.0, 2.0, 60.0);
    let unsaid = Unsaid { origin: false, ..Unsaid::ALL };
    let camera = pot().completed(CameraDescription { origin, unsaid, ..Default::default() });
    let [across, upwards] = pot().extent(&camera, 1280.0 / 720.0);
    assert!((0.85..0.951).contains(&across.max(upwards)), "{across} {upwards} {camera:?}");
}

#[test]
fn a_model_that_lies_is_seen_as_one_that_stands() {
    // from y up to z up: x stays, y becomes z, z becomes −y
    let turn = Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::Z, vec3(0.0, -1.0, 0.0)));
    let unsaid = Unsaid { up: false, ..Unsaid::ALL };
    let z_is_up = CameraDescription { up: Vec3::Z, unsaid, ..Default::default() };
    let pot = pot().moved(turn);
    let camera = pot.completed(z_is_up.clone());
    let [across, upwards] = pot.extent(&camera, 1280.0 / 720.0);
    assert!((0.9..0.951).contains(&across.max(upwards)), "{across} {upwards}");
    assert!(camera.origin.z > 1.0 && camera.origin.y < 0.0, "from above and from the front: {camera:?}");
    let camera = room(&[]).moved(turn).completed(z_is_up);
    assert!((0.9..2.1).contains(&camera.origin.z), "at the height of eyes: {camera:?}");
    assert!((camera.target.z - camera.origin.z).abs() < 1e-4);
}

#[test]
fn any_direction_can_be_up() {
    for up in [Vec3::X, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z, vec3(1.0, 2.0, 3.0)] {
        let unsaid = Unsaid { up: false, ..Unsaid::ALL };
        let camera = pot().completed(CameraDescription { up, unsaid, ..Default::default() });
        let forward = (camera.target - camera.origin).normalize().as_vec3();
        assert!(camera.up.dot(up.normalize()) > 0.999 && forward.dot(up) < 0.0, "{camera:?}");
    }
}

#[test]
fn odd_models_have_a_camera_too() {
    let line = Builder::default().quad([Vec3::ZERO, Vec3::X, Vec3::X, Vec3::ZERO], GREY);
    let flat = Builder::default().quad([Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0), Vec3::Y], GREY);
    let mut rng = Rng::new(7);
    let soup =
        (0..60).fold(Builder::default(), |b, _| b.quad([(); 4].map(|()| vec3(rng.f32(), rng.f32(), rng.f32())), GREY));
    let turned = Affine3A::from_quat(Quat::from_rotation_z(0.3));
    for model in [line, flat.clone(), flat.moved(turned), soup.clone(), soup.moved(turned)] {
        let camera = model.found().camera;
        assert!(camera.origin.is_finite() && camera.target != camera.origin, "{camera:?}");
    }
}

#[test]
fn files_say_what_is_up() {
    let cases = [
        ("# Z-up\nv 0 0 0", Some(Vec3::Z)),
        ("# Exported by X; units: m, up axis: Z", Some(Vec3::Z)),
        ("# up_axis = -z", Some(Vec3::NEG_Z)),
        ("# +Y is up", Some(Vec3::Y)),
        ("# Up: X (right handed)", Some(Vec3::X)),
        ("\u{feff}# forward: y, up: z\r\n", Some(Vec3::Z)),
        ("# axis: -Z forward, Y up", Some(Vec3::Y)),
        ("# OpenSCAD obj exporter\nv 0 0 0", Some(Vec3::Z)),
        ("# Created by FreeCAD <https://www.freecad.org>", Some(Vec3::Z)),
        ("v 0 0 0\n# z up", None),
        ("# cleaned up by Zoe", None),
        ("# set up, z first", None),
        ("# Blender 4.2 OBJ File", None),
        ("", None),
    ];
    for (text, up) in cases {
        assert_eq!(up_of_text(text), up, "{text}");
    }
}
