//! What rays meet. They are random but seeded; no test is statistical.

use super::rays::{Face, World, random_direction, random_point};
use super::{door, make, settings, world};
use crate::math::rng::Rng;
use glam::DVec3;

fn camera_vector(settings: &toml::Table, key: &str) -> DVec3 {
    let values = settings["camera"][key].as_array().unwrap();
    let number = |v: &toml::Value| v.as_float().unwrap_or_else(|| v.as_integer().unwrap() as f64);
    DVec3::from_slice(&values.iter().map(number).collect::<Vec<f64>>())
}

/// Camera rays through the centres of a `width` x `height` grid over the film: origin and unit directions.
fn camera_rays(name: &str, width: u32, height: u32) -> (DVec3, Vec<DVec3>) {
    let settings = settings(name);
    let [origin, target, up] = ["origin", "target", "up"].map(|key| camera_vector(&settings, key));
    let film = |key: &str| settings["film"][key].as_integer().unwrap() as f64;
    let half_height = (settings["camera"]["vfov"].as_float().unwrap().to_radians() / 2.0).tan();
    let half_width = half_height * film("width") / film("height");
    let ahead = (target - origin).normalize();
    let right = ahead.cross(up).normalize();
    let above = right.cross(ahead);
    let centred = |i: u32, n: u32| (2 * i + 1) as f64 / n as f64 - 1.0;
    let ray = |i: u32| {
        let (x, y) = (centred(i % width, width), centred(i / width, height));
        (ahead + right * (x * half_width) - above * (y * half_height)).normalize()
    };
    (origin, (0..width * height).map(ray).collect())
}

/// Of `count` random rays from points in a box, how many leave the world or meet a back side.
fn escapes(world: &World, [low, high]: [DVec3; 2], count: u32) -> u32 {
    let mut rng = Rng::new(1);
    let escaped = (0..count).filter(|_| {
        let origin = random_point(&mut rng, low, high);
        let direction = random_direction(&mut rng);
        let hit = world.trace(origin, direction);
        hit.is_none_or(|hit| hit.face.cross().dot(direction) >= 0.0)
    });
    escaped.count() as u32
}

#[test]
fn no_ray_leaves_a_closed_room() {
    let boxes = |half: f64| [DVec3::new(-half, 0.3, -half), DVec3::new(half, 2.4, half)];
    for (name, shell, half) in [("door", "building", 1.5), ("wall", "room", 2.5)] {
        let shell = world(name).filtered(|face| face.object == shell);
        // The middle of either scene holds solid wall: only points that look at a front count as inside.
        let inside = |p: DVec3| shell.trace(p, DVec3::Y).is_some_and(|hit| hit.face.cross().y < 0.0);
        let mut rng = Rng::new(2);
        let [low, high] = boxes(half);
        for _ in 0..200 {
            let p = random_point(&mut rng, low, high);
            if inside(p) {
                assert_eq!(escapes(&shell, [p, p], 50), 0, "{name}, from {p}");
            }
        }
        let ceiling_gone = shell.filtered(|face| face.cross().y > -1e-9);
        assert!(escapes(&ceiling_gone, [low, high], 200) > 20, "the check can fail");
    }
}

#[test]
fn the_furnace_is_closed_about_its_camera() {
    let world = world("furnace");
    let eye = camera_vector(&settings("furnace"), "origin");
    assert_eq!(escapes(&world, [eye, eye], 5_000), 0);
    let mtl = make("furnace").unwrap().model.mtl("furnace");
    assert!(mtl.ends_with("newmtl glow\nKd 0.5 0.5 0.5\nKe 1 1 1\n"), "{mtl}");
}

#[test]
fn every_pixel_of_a_closed_scene_sees_a_front() {
    for name in ["door", "wall", "furnace"] {
        let world = world(name);
        let (eye, directions) = camera_rays(name, 32, 18);
        for direction in directions {
            let hit = world.trace(eye, direction).expect("no camera ray escapes");
            assert!(hit.face.cross().dot(direction) < 0.0, "{name}, {}", hit.face.object);
        }
    }
}

/// Whether a point sees any of five spots on each triangle of the lamp's front.
fn sees_lamp(world: &World, p: DVec3) -> bool {
    let lamp: Vec<&Face> = world.faces.iter().filter(|f| f.material == "lamp").collect();
    let spots = lamp.iter().flat_map(|face| {
        let [a, b, c] = face.corners;
        [(0.1, 0.1), (0.8, 0.1), (0.1, 0.8), (0.45, 0.45), (0.3, 0.3)]
            .map(|(u, v)| (a + (b - a) * u + (c - a) * v, face.cross()))
    });
    spots.into_iter().any(|(spot, normal)| normal.dot(p - spot) > 0.0 && world.sees(p, spot))
}

/// The points that the camera sees, a hair off the surface, with what they lie on.
fn seen<'a>(world: &'a World, name: &str, width: u32, height: u32) -> Vec<(DVec3, &'a Face)> {
    let (eye, directions) = camera_rays(name, width, height);
    let point = |d: DVec3| {
        let hit = world.trace(eye, d)?;
        Some((eye + d * hit.distance + hit.face.cross().normalize() * 1e-5, hit.face))
    };
    directions.into_iter().filter_map(point).collect()
}

#[test]
fn nothing_in_the_near_room_of_door_sees_the_lamp() {
    let world = world("door");
    let to_building = door::to_world().inverse();
    let points = seen(&world, "door", 64, 36);
    let near_room = |p: &DVec3| to_building.transform_point3(*p).z > -0.14;
    let lit = |p: DVec3| sees_lamp(&world, p);
    let (near, far): (Vec<DVec3>, Vec<DVec3>) = points.iter().map(|seen| seen.0).partition(near_room);
    assert!(near.len() > 2_200 && !near.into_iter().any(lit));
    // What shows through the gap is the lit room.
    assert!(far.into_iter().any(lit));
    assert!(points.iter().all(|seen| seen.1.material != "lamp"), "the lamp itself is out of view");
}

#[test]
fn light_reaches_the_table_through_a_narrow_gap() {
    let world = world("door");
    let (to_world, mut rng) = (door::to_world(), Rng::new(3));
    let over_table = to_world.transform_point3(DVec3::new(-0.5, 1.3, 2.4));
    let through = (0..4_000).filter(|_| {
        let direction = random_direction(&mut rng);
        let hit = world.trace(over_table, direction).unwrap();
        let end = over_table + direction * hit.distance;
        to_world.inverse().transform_point3(end).z < -0.1
    });
    let through = through.count();
    assert!((2..80).contains(&through), "{through} of 4000 directions lead to the light's room");
}

#[test]
fn the_dark_half_of_wall_is_dark_and_the_other_is_not() {
    let world = world("wall");
    let points = seen(&world, "wall", 48, 36);
    let lit = |keep: &dyn Fn(DVec3, &Face) -> bool| {
        let kept: Vec<_> = points.iter().filter(|seen| keep(seen.0, seen.1)).collect();
        let lit = kept.iter().filter(|seen| sees_lamp(&world, seen.0)).count();
        (lit, kept.len())
    };
    let things = lit(&|_, face| ["head", "cone"].contains(&face.object.as_str()));
    assert!(things.0 == 0 && things.1 > 60, "{things:?}");
    let dark = lit(&|p, _| p.x > 0.1 && p.z < 0.8);
    assert!(dark.0 == 0 && dark.1 > 500, "{dark:?}");
    let bright = lit(&|p, _| p.x < -0.1 && p.z < 0.8);
    assert!(bright.0 * 10 > bright.1 * 9 && bright.1 > 300, "{bright:?}");
}
