//! Triangulation.

use crate::scene::triangulate::{LARGEST_CONCAVE, triangulate};
use glam::{DVec2, DVec3, Vec3};
use proptest::prelude::*;
use std::f64::consts::TAU;

fn cut(points: &[[f32; 3]]) -> Vec<[usize; 3]> {
    let mut out = Vec::new();
    assert!(triangulate(points, &mut out));
    assert_eq!(out.len(), points.len() - 2);
    out
}

/// Twice the area vectors of the triangles.
fn areas(points: &[[f32; 3]], triangles: &[[usize; 3]]) -> Vec<DVec3> {
    let corner = |i: usize| Vec3::from(points[i]).as_dvec3();
    let area = |&[a, b, c]: &[usize; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a));
    triangles.iter().map(area).collect()
}

/// Twice the area by which the triangles exceed the polygon, relative to it: 0 if they tile it. Triangles wound the
/// other way, or outside of it, make it larger.
fn excess(points: &[[f32; 3]], triangles: &[[usize; 3]]) -> f64 {
    let areas = areas(points, triangles);
    let total: DVec3 = areas.iter().sum();
    areas.iter().map(|area| area.length()).sum::<f64>() / total.length() - 1.0
}

fn fan(n: usize) -> Vec<[usize; 3]> {
    (1..n - 1).map(|i| [0, i, i + 1]).collect()
}

fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| [p[0], p[1], 2.0]).collect()
}

#[test]
fn convex_polygons_are_fans() {
    let ring: Vec<[f32; 3]> =
        (0..9).map(|i| (i as f32 / 9.0).to_radians() * 360.0).map(|t| [t.cos(), 3.0, t.sin()]).collect();
    for n in 3..=9 {
        assert_eq!(cut(&ring[..n]), fan(n));
    }
}

#[test]
fn a_concave_quadrilateral_is_cut_at_its_reflex_corner() {
    let dart = flat(&[[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]]);
    for first in 0..4 {
        let mut turned = dart.clone();
        turned.rotate_left(first);
        assert!(excess(&turned, &cut(&turned)) < 1e-9, "from {first}");
    }
    // A fan from corner 1 or 3 leaves the dart.
    let mut turned = dart;
    turned.rotate_left(1);
    assert!(excess(&turned, &fan(4)) > 0.1);
}

#[test]
fn concave_polygons_are_tiled() {
    let comb: Vec<[f32; 2]> = (0..40).map(|i| [i as f32 * 0.5, if i % 2 == 0 { 0.0 } else { 5.0 }]).collect();
    let comb: Vec<[f32; 2]> = [[19.5, 9.0], [0.0, 9.0]].into_iter().chain(comb).collect();
    let step = [[2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
    // A square hole, reached along a bridge.
    let hole = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
    ];
    for polygon in [&comb[..], &step[..], &hole[..]] {
        let points = flat(polygon);
        assert!(excess(&points, &cut(&points)).abs() < 1e-9, "{polygon:?}");
        assert!(excess(&points, &fan(points.len())) > 0.1, "a fan would have done for {polygon:?}");
    }
}

#[test]
fn corners_in_line_are_no_obstacle() {
    let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0], [0.0, 1.0]];
    let points = flat(&square);
    assert!(excess(&points, &cut(&points)).abs() < 1e-9);
}

#[test]
fn degenerate_polygons_are_cut_somehow() {
    let line: Vec<[f32; 3]> = (0..6).map(|i| [i as f32, 0.0, 0.0]).collect();
    let bow = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [2.0, 5.0]]);
    for points in [vec![[1.0; 3]; 7], line, bow, vec![[f32::NAN; 3]; 5], vec![[f32::MAX; 3]; 4]] {
        cut(&points);
    }
}

#[test]
fn huge_concave_polygons_are_refused() {
    let saw: Vec<[f32; 3]> = (0..=LARGEST_CONCAVE as u32).map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
    assert!(!triangulate(&saw, &mut Vec::new()));
    assert!(triangulate(&saw[1..], &mut Vec::new()));
}

/// A polygon with what draws no area added to it: corners twice, corners in line, spikes and spikes on spikes.
#[derive(Clone, Debug)]
enum Detour {
    Double,
    Middle,
    /// To a point and back, by relative coordinates.
    Spike([f64; 2]),
    /// To a point, from there to a second one, and back by the first.
    Branch([f64; 2], [f64; 2]),
    /// Over the next corner and back to it: by its distance times this.
    Overshoot(f64),
    /// Back and forth on the way to the next corner.
    Zigzag,
}

fn detours() -> impl Strategy<Value = Vec<(prop::sample::Index, Detour)>> {
    let point = || prop::array::uniform2(-3.0f64..3.0);
    let detour = prop_oneof![
        Just(Detour::Double),
        Just(Detour::Middle),
        point().prop_map(Detour::Spike),
        (point(), point()).prop_map(|(a, b)| Detour::Branch(a, b)),
        (0.1f64..2.0).prop_map(Detour::Overshoot),
        Just(Detour::Zigzag),
    ];
    prop::collection::vec((any::<prop::sample::Index>(), detour), 0..6)
}

/// The corners of `outline` with detours, one at each of different corners.
fn with_detours(outline: &[DVec2], detours: &[(prop::sample::Index, Detour)]) -> Vec<DVec2> {
    let n = outline.len();
    let mut points = Vec::new();
    for (i, &p) in outline.iter().enumerate() {
        let next = outline[(i + 1) % n];
        points.push(p);
        let Some((_, detour)) = detours.iter().find(|(at, _)| at.index(n) == i) else { continue };
        match *detour {
            Detour::Double => points.push(p),
            Detour::Middle => points.push((p + next) * 0.5),
            Detour::Spike(tip) => points.extend([p + DVec2::from(tip), p]),
            Detour::Branch(first, second) => {
                let first = p + DVec2::from(first);
                points.extend([first, first + DVec2::from(second), first, p]);
            }
            Detour::Overshoot(far) => points.push(next + (next - p) * far),
            Detour::Zigzag => points.extend([0.75, 0.25].map(|t| p.lerp(next, t))),
        }
    }
    points
}

/// Twice the area within a simple polygon that runs counter-clockwise.
fn shoelace(points: &[DVec2]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum()
}

/// In the plane through `centre` whose normal is `axis`, in single precision.
fn placed(points: &[DVec2], axis: [f64; 3], centre: [f64; 3]) -> Vec<[f32; 3]> {
    let (u, v) = DVec3::from(axis).try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    points.iter().map(|p| (DVec3::from(centre) + p.x * u + p.y * v).as_vec3().to_array()).collect()
}

/// Twice the area of the triangles, which is the polygon's only if they neither overlap nor leave anything out.
fn covered(points: &[[f32; 3]]) -> f64 {
    areas(points, &cut(points)).iter().map(|area| area.length()).sum()
}

#[test]
fn spikes_and_doubled_corners_draw_nothing() {
    let square = [[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]];
    let (corner, tip) = ([0.5, -0.5], [0.5, -0.9]);
    // before the third corner: a spike beyond it, the edge's end beyond it, spikes into the square and along its diagonal, the corner
    // three times, and back and forth beyond it
    let detours: [&[[f32; 2]]; 6] =
        [&[corner, tip], &[tip], &[corner, [0.1, 0.2]], &[corner, [2.0, -2.0]], &[corner; 2], &[tip, [0.5, -0.2], tip]];
    for detour in detours {
        let all = [&square[..2], detour, &square[2..]].concat();
        for first in 0..all.len() {
            let mut turned = all.clone();
            turned.rotate_left(first);
            let area = covered(&flat(&turned));
            assert!((area - 2.0).abs() < 1e-6, "{detour:?} from {first}: {area}");
        }
    }
}

#[test]
fn quadrilaterals_may_have_spikes() {
    let kite = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [1.0, 1.0]];
    let nothing = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
    for (corners, twice_area) in [(kite, 1.0), (nothing, 0.0)] {
        for first in 0..4 {
            let mut turned = corners;
            turned.rotate_left(first);
            assert!((covered(&flat(&turned)) - twice_area).abs() < 1e-6, "{corners:?} from {first}");
        }
    }
}

#[test]
fn holes_may_touch_the_outline() {
    // A hole whose corner is at the outline's own corner: there the outline goes through one point twice, without a bridge.
    let hole = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
    for first in 0..hole.len() {
        let mut turned = hole;
        turned.rotate_left(first);
        let area = covered(&flat(&turned));
        assert!((area - 28.0).abs() < 1e-6, "from {first}: {area}");
    }
}

proptest! {
    #[test]
    fn detours_draw_nothing(
        radii in prop::collection::vec(0.2f64..5.0, 3..40),
        detours in detours(),
        axis in prop::array::uniform3(-1.0f64..1.0),
        centre in prop::array::uniform3(-20.0f64..20.0),
        first: prop::sample::Index,
    ) {
        let n = radii.len() as f64;
        let outline: Vec<DVec2> =
            radii.iter().enumerate().map(|(i, r)| DVec2::from_angle(i as f64 / n * TAU) * *r).collect();
        let mut points = with_detours(&outline, &detours);
        let turn = first.index(points.len());
        points.rotate_left(turn);
        let (covered, expected) = (covered(&placed(&points, axis, centre)), shoelace(&outline));
        // coordinates to 40 are rounded by 2e-6, on edges of 160 together, and what is narrower than a ten-thousandth of its length
        // of 10 may be filled
        prop_assert!((covered - expected).abs() < 1.2e-2, "{} for {}", covered, expected);
    }

    /// A spike may come back beside where it went out, by the last digits of a file, and cross itself there.
    #[test]
    fn spikes_may_miss_their_foot(
        radii in prop::collection::vec(0.2f64..5.0, 3..40),
        spikes in prop::collection::vec((any::<prop::sample::Index>(), prop::array::uniform3(-1.0f64..1.0)), 1..4),
        axis in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let n = radii.len();
        let outline: Vec<DVec2> =
            radii.iter().enumerate().map(|(i, r)| DVec2::from_angle(i as f64 / n as f64 * TAU) * *r).collect();
        let mut points = Vec::new();
        for (i, &p) in outline.iter().enumerate() {
            points.push(p);
            if let Some((_, [length, along, across])) = spikes.iter().find(|(at, _)| at.index(n) == i) {
                let foot = p + (p * *along + p.perp() * *across) * 1e-5;
                points.extend([p * (2.5 + length), foot]);
            }
        }
        let (covered, expected) = (covered(&placed(&points, axis, [0.0; 3])), shoelace(&outline));
        // what crosses itself has no area of its own: what is asked for is that nothing else is drawn that one would see
        prop_assert!((covered - expected).abs() < 0.01 * expected, "{} for {}", covered, expected);
    }

    /// Around a point that sees all corners, the polygon is simple; seen from anywhere in space.
    #[test]
    fn star_shaped_polygons_are_tiled(
        radii in prop::collection::vec(0.1f64..5.0, 5..60),
        axis in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let n = radii.len();
        let axis = DVec3::from(axis).try_normalize().unwrap_or(DVec3::Z);
        let (u, v) = axis.any_orthonormal_pair();
        let points: Vec<[f32; 3]> = radii
            .iter()
            .enumerate()
            .map(|(i, r)| (r, i as f64 / n as f64 * TAU))
            .map(|(r, t)| (r * (t.cos() * u + t.sin() * v)).as_vec3().to_array())
            .collect();
        let triangles = cut(&points);
        prop_assert!(excess(&points, &triangles) < 1e-5);
        prop_assert!(areas(&points, &triangles).iter().all(|area| area.dot(axis) > -1e-5));
    }

    #[test]
    fn any_corners_give_all_triangles(points in prop::collection::vec(prop::array::uniform3(-2i8..3), 3..40)) {
        let points: Vec<[f32; 3]> = points.iter().map(|p| p.map(f32::from)).collect();
        for corner in cut(&points).iter().flatten() {
            prop_assert!(*corner < points.len());
        }
    }
}
