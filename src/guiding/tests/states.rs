//! Which points share a state.

use super::*;
use crate::math::rng::Rng;
use proptest::prelude::*;

fn grid(resolution: u32, normals: bool) -> Grid {
    Grid::new(Vec3::ZERO, Vec3::ONE, resolution, normals)
}

#[test]
fn the_two_sides_of_a_thin_sheet_never_share_a_state() {
    let mut rng = Rng::new(1);
    let grid = grid(16, true);
    for _ in 0..10_000 {
        let (p, n, jitter) = (point(&mut rng), unit(&mut rng), rng.f32x2());
        assert_ne!(grid.key(p, n, jitter), grid.key(p, -n, jitter), "{p}, {n}");
        assert!(grid.frame(grid.key(p, n, jitter)).n.dot(grid.frame(grid.key(p, -n, jitter)).n) < 0.0);
    }
}

#[test]
fn walls_that_meet_in_a_corner_do_not_share_states() {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let keys = |normals: bool| -> std::collections::HashSet<_> {
        axes.iter().map(|n| grid(16, normals).key(Vec3::splat(0.5), *n, [0.5; 2])).collect()
    };
    assert_eq!((keys(true).len(), keys(false).len()), (6, 1));
}

#[test]
fn the_grid_has_as_many_cells_as_it_says() {
    for resolution in [1u32, 8, 32, 1000] {
        let grid = grid(resolution, true);
        let at = |i: u32| grid.key(Vec3::new((i as f32 + 0.5) / resolution as f32, 0.5, 0.5), Vec3::Y, [0.5; 2]);
        let cells: std::collections::HashSet<_> = (0..resolution).map(at).collect();
        assert_eq!(cells.len(), resolution as usize, "along one side");
    }
}

#[test]
fn a_wall_along_the_box_is_one_layer_of_cells() {
    // walls at round coordinates, wrong by rounding either way
    let grid = grid(8, true);
    for wall in [0.0f32, 0.125, 0.25, 0.5, 1.0] {
        let key = |y: f32| grid.key(Vec3::new(0.3, y, 0.7), Vec3::Y, [0.5; 2]);
        assert_eq!(key(wall - 1e-6), key(wall + 1e-6), "{wall}");
    }
}

#[test]
fn jitter_reaches_the_neighbours_along_the_surface_only() {
    let mut rng = Rng::new(2);
    let grid = grid(8, true);
    let (p, n) = (Vec3::new(0.41, 0.33, 0.47), Vec3::Y);
    let keys: std::collections::HashSet<_> = (0..1000).map(|_| grid.key(p, n, rng.f32x2())).collect();
    assert_eq!(keys.len(), 4, "half a cell to either side of a floor reaches four cells");
}

#[test]
fn scenes_without_extent_have_states() {
    let grid = Grid::new(Vec3::ONE, Vec3::ONE, 32, true);
    assert_eq!(grid.key(Vec3::ONE, Vec3::Y, [0.5; 2]), grid.key(Vec3::ONE, Vec3::Y, [0.5; 2]));
    assert!(grid.frame(grid.key(Vec3::ONE, Vec3::Y, [0.5; 2])).n.is_finite());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever a renderer may ask, not-a-number included, there is a state, with a frame.
    #[test]
    fn every_question_has_an_answer(p in any::<[f32; 3]>(), n in any::<[f32; 3]>(), u in 0.0f32..1.0, v in 0.0f32..1.0, resolution in 1u32..65_536) {
        for normals in [true, false] {
            let grid = grid(resolution, normals);
            let frame = grid.frame(grid.key(p.into(), n.into(), [u, v]));
            prop_assert!([frame.s, frame.t, frame.n].iter().all(|axis| axis.is_normalized()));
            prop_assert!(frame.s.dot(frame.t).abs() < 1e-5 && frame.s.cross(frame.t).dot(frame.n) > 0.999);
        }
    }

    /// Far outside, cells do not wrap round to the other side.
    #[test]
    fn far_points_fall_into_the_border(far in 1e6f32..1e30, axis in 0usize..3) {
        let grid = grid(32, true);
        let mut p = Vec3::splat(0.5);
        p[axis] = far;
        let mut farther = p;
        farther[axis] = 10.0 * far;
        prop_assert_eq!(grid.key(p, Vec3::Y, [0.5; 2]), grid.key(farther, Vec3::Y, [0.5; 2]));
        prop_assert_ne!(grid.key(p, Vec3::Y, [0.5; 2]), grid.key(-p, Vec3::Y, [0.5; 2]));
    }
}
