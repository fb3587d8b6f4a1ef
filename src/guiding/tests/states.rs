//! Which points share a state.

use super::*;
use crate::guiding::spatial::{Grid, Partition, TwoLevelGrid};
use crate::math::rng::Rng;
use crate::simd::{LANES, Vec3Lanes};
use proptest::prelude::*;
use std::collections::HashSet;

fn jitter(rng: &mut Rng) -> [f32; 3] {
    let [u, v] = rng.f32x2();
    [u, v, 0.5]
}

fn grid(resolution: u32, normals: bool) -> Grid {
    Grid::new(Vec3::ZERO, Vec3::ONE, resolution, normals)
}

/// Cells cut at random, up to three times.
fn adaptive(rng: &mut Rng, resolution: u32) -> TwoLevelGrid {
    let mut adaptive = TwoLevelGrid::new(Vec3::ZERO, Vec3::ONE, resolution, 3);
    for coarse in 0..adaptive.cells() {
        for _ in 0..rng.next_u32() % 5 {
            adaptive.divide(coarse);
        }
    }
    adaptive
}

/// Both ways of telling states apart.
fn ways(rng: &mut Rng, resolution: u32) -> [Partition; 2] {
    [Partition::Grid(grid(resolution, true)), Partition::TwoLevel(adaptive(rng, resolution))]
}

#[test]
fn the_two_sides_of_a_thin_sheet_never_share_a_state() {
    let mut rng = Rng::new(1);
    for states in ways(&mut Rng::new(2), 16) {
        for _ in 0..10_000 {
            let (p, n, jitter) = (point(&mut rng), unit(&mut rng), jitter(&mut rng));
            assert_ne!(states.locate(p, n, jitter), states.locate(p, -n, jitter), "{p}, {n}");
        }
    }
}

#[test]
fn walls_that_meet_in_a_corner_do_not_share_states() {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let keys = |states: &Partition| -> HashSet<_> {
        axes.iter().map(|n| states.locate(Vec3::splat(0.5), *n, [0.5; 3]).map(|at| at.drawn)).collect()
    };
    assert!(ways(&mut Rng::new(3), 16).iter().all(|states| keys(states).len() == 6));
    assert_eq!(keys(&Partition::Grid(grid(16, false))).len(), 1);
}

#[test]
fn the_grid_has_as_many_cells_as_it_says() {
    for resolution in [1u32, 8, 32, 1000] {
        let grid = grid(resolution, true);
        let at = |i: u32| grid.key(Vec3::new((i as f32 + 0.5) / resolution as f32, 0.5, 0.5), Vec3::Y, [0.5; 3]);
        let cells: HashSet<_> = (0..resolution).map(at).collect();
        assert_eq!(cells.len(), resolution as usize, "along one side");
    }
}

#[test]
fn a_wall_along_the_box_is_one_layer_of_cells() {
    // walls at round coordinates, wrong by rounding either way
    let fresh = TwoLevelGrid::new(Vec3::ZERO, Vec3::ONE, 8, 4);
    for states in [Partition::Grid(grid(8, true)), Partition::TwoLevel(fresh)] {
        for wall in [0.0f32, 0.125, 0.25, 0.5, 1.0] {
            let key = |y: f32| states.locate(Vec3::new(0.3, y, 0.7), Vec3::Y, [0.5; 3]);
            assert_eq!(key(wall - 1e-6), key(wall + 1e-6), "{wall}");
        }
    }
}

#[test]
fn jitter_reaches_the_neighbours_along_the_surface_only() {
    let mut rng = Rng::new(2);
    let grid = grid(8, true);
    let (p, n) = (Vec3::new(0.41, 0.33, 0.47), Vec3::Y);
    let keys: HashSet<_> = (0..1000).map(|_| grid.key(p, n, jitter(&mut rng))).collect();
    assert_eq!(keys.len(), 4, "half a cell to either side of a floor reaches four cells");
    // of an adaptive grid, the cells are those of the point's own size
    for level in 0..3 {
        let mut adaptive = TwoLevelGrid::new(Vec3::ZERO, Vec3::ONE, 8, 4);
        for coarse in 0..adaptive.cells() {
            (0..level).for_each(|_| assert!(adaptive.divide(coarse).is_some()));
        }
        let own = adaptive.key(p, n, [0.5; 3]);
        let beside: HashSet<_> = own.neighbours().flat_map(|key| key.neighbours().chain([key])).collect();
        let keys: HashSet<_> = (0..1000).map(|_| adaptive.key(p, n, jitter(&mut rng))).collect();
        assert_eq!(keys.len(), 4, "level {level}");
        assert!(keys.is_subset(&beside), "level {level}");
    }
}

#[test]
fn scenes_without_extent_have_states() {
    let grid = Grid::new(Vec3::ONE, Vec3::ONE, 32, true);
    assert_eq!(grid.key(Vec3::ONE, Vec3::Y, [0.5; 3]), grid.key(Vec3::ONE, Vec3::Y, [0.5; 3]));
    let adaptive = TwoLevelGrid::new(Vec3::ONE, Vec3::ONE, 32, 4);
    let key = adaptive.key(Vec3::ONE, Vec3::Y, [0.5; 3]);
    assert!(adaptive.holds(key) && adaptive.cell_of(key) < adaptive.cells());
    // a flat scene has few cells across, not as many as along
    let flat = TwoLevelGrid::new(Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), 32, 4);
    assert!(flat.cells() <= 36 * 36 * 4, "{}", flat.cells());
}

/// Vertices on the walls of a room with its corner at the origin.
fn on_walls(rng: &mut Rng, side: f32, count: usize) -> Vec<(Vec3, Vec3)> {
    let on_wall = |k: usize| {
        let mut p = point(rng) * side;
        p[k % 3] = if k.is_multiple_of(2) { 0.0 } else { side };
        (p, if k.is_multiple_of(2) { Vec3::AXES[k % 3] } else { -Vec3::AXES[k % 3] })
    };
    (0..count).map(on_wall).collect()
}

#[test]
fn a_room_in_a_landscape_has_cells_of_a_room() {
    let (mut rng, side, half) = (Rng::new(7), 6.0, 2500.0);
    let room = on_walls(&mut rng, side, 4000);
    // what is seen through its windows
    let outside: Vec<(Vec3, Vec3)> =
        (0..400).map(|_| ((point(&mut rng) - 0.5) * Vec3::new(2.0 * half, 0.0, 2.0 * half), Vec3::Y)).collect();
    let keys = |grid: &TwoLevelGrid, vertices: &[(Vec3, Vec3)]| -> HashSet<RegionId> {
        vertices.iter().map(|(p, n)| grid.key(*p, *n, [0.5; 3])).collect()
    };
    let alone = TwoLevelGrid::new(Vec3::ZERO, Vec3::splat(side), 16, 4);
    let mut grid = TwoLevelGrid::new(Vec3::splat(-half), Vec3::splat(half), 16, 4);
    let before = keys(&grid, &outside);
    assert!(keys(&grid, &room).len() <= 6 * 8, "all of the room is in a cell or two");
    grid.expect_vertices(&[&room[..], &outside[..]].concat());
    let (has, should) = (keys(&grid, &room).len(), keys(&alone, &room).len());
    println!("{has} regions in the room, {should} where it is all of the scene");
    assert!(4 * has > should && has < 4 * should);
    let far = |(p, _): &&(Vec3, Vec3)| p.abs().max_element() > 0.2 * half;
    let far: Vec<(Vec3, Vec3)> = outside.iter().filter(far).copied().collect();
    assert!(far.len() > 300 && keys(&grid, &far).is_subset(&before), "what is seen far outside keeps its large cells");
    // parts of its regions are to be had as ever, and a copy is made of what is stored
    let key = grid.key(room[0].0, room[0].1, [0.5; 3]);
    let mut copy = TwoLevelGrid::new(Vec3::splat(-half), Vec3::splat(half), 16, 4);
    copy.restore(grid.stored(), usize::MAX).unwrap();
    assert_eq!(keys(&copy, &room), keys(&grid, &room));
    let halvings = (0..9).take_while(|_| grid.divide(grid.cell_of(key)).is_some()).count();
    assert!((2..=4).contains(&halvings), "{halvings}");
    // where the room is the scene nothing changes
    let (mut same, plain) = (alone.clone(), keys(&alone, &room));
    same.expect_vertices(&room);
    assert_eq!(keys(&same, &room), plain);
    same.expect_vertices(&[]);
    assert_eq!(keys(&same, &room), plain);
}

#[test]
fn a_cut_state_s_points_are_in_its_parts() {
    let mut rng = Rng::new(4);
    let mut adaptive = adaptive(&mut rng, 4);
    let mut reached = 0;
    for _ in 0..300 {
        let (p, n) = (point(&mut rng), unit(&mut rng));
        let whole = adaptive.key(p, n, [0.5; 3]);
        let parts: Vec<RegionId> = whole.parts().collect();
        assert_eq!(parts.iter().collect::<HashSet<_>>().len(), 8);
        assert!(parts.iter().all(|&part| adaptive.cell_of(part) == adaptive.cell_of(whole)));
        if adaptive.divide(adaptive.cell_of(whole)).is_none() {
            continue;
        }
        assert!(!adaptive.holds(whole) && parts.iter().all(|&part| adaptive.holds(part)));
        let part = parts.iter().position(|&part| part == adaptive.key(p, n, [0.5; 3]));
        reached |= 1 << part.expect("the point is in one of the parts");
        // and of another normal it is in none of them
        assert!(!parts.contains(&adaptive.key(p, -n, [0.5; 3])));
    }
    assert_eq!(reached, 0xff, "every part has points");
}

#[test]
fn neighbours_are_the_states_a_state_s_extent_away() {
    let mut rng = Rng::new(5);
    for level in 0..4 {
        let mut adaptive = TwoLevelGrid::new(Vec3::ZERO, Vec3::ONE, 4, 4);
        for coarse in 0..adaptive.cells() {
            (0..level).for_each(|_| assert!(adaptive.divide(coarse).is_some()));
        }
        let extent = 0.25 / (1 << level) as f32;
        for _ in 0..1000 {
            let (p, n) = (point(&mut rng), unit(&mut rng));
            let neighbours: HashSet<_> = adaptive.key(p, n, [0.5; 3]).neighbours().collect();
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                for step in [-extent, extent] {
                    assert!(neighbours.contains(&adaptive.key(p + axis * step, n, [0.5; 3])));
                }
            }
            assert!(neighbours.len() == 6 && !neighbours.contains(&adaptive.key(p, n, [0.5; 3])));
        }
    }
    assert_eq!(RegionId(0).neighbours().count(), 3, "beyond the border there is nothing");
}

#[test]
fn cutting_changes_only_its_coarse_cell() {
    let mut rng = Rng::new(6);
    let mut adaptive = adaptive(&mut rng, 4);
    let points: Vec<(Vec3, Vec3)> = (0..5000).map(|_| (point(&mut rng), unit(&mut rng))).collect();
    let keys = |adaptive: &TwoLevelGrid| -> Vec<RegionId> {
        points.iter().map(|&(p, n)| adaptive.key(p, n, [0.5; 3])).collect()
    };
    for _ in 0..50 {
        let before = keys(&adaptive);
        let coarse = adaptive.cell_of(before[rng.next_u32() as usize % before.len()]);
        let cut = adaptive.divide(coarse).is_some();
        for (old, new) in before.iter().zip(keys(&adaptive)) {
            assert_eq!(*old != new, cut && adaptive.cell_of(*old) == coarse);
            assert_eq!(adaptive.cell_of(*old), adaptive.cell_of(new));
        }
    }
    // three halvings are the most of these
    let coarse = adaptive.cell_of(keys(&adaptive)[0]);
    while adaptive.divide(coarse).is_some() {}
    let before = keys(&adaptive);
    assert!(adaptive.divide(coarse).is_none() && before == keys(&adaptive));
}

#[test]
fn jitter_across_a_border_names_a_current_state() {
    let mut rng = Rng::new(7);
    let adaptive = adaptive(&mut rng, 4);
    let mut crossed = 0;
    for _ in 0..100_000 {
        let (p, n) = (point(&mut rng), unit(&mut rng));
        let (still, moved) = (adaptive.key(p, n, [0.5; 3]), adaptive.key(p, n, jitter(&mut rng)));
        assert!(adaptive.holds(still) && adaptive.holds(moved), "{p}, {n}");
        crossed += (adaptive.cell_of(still) != adaptive.cell_of(moved)) as u32;
    }
    assert!(crossed > 1000, "only {crossed} look-ups came into another coarse cell");
}

#[test]
fn cells_take_a_byte_each() {
    for resolution in [1u32, 16, 128] {
        let adaptive = TwoLevelGrid::new(-Vec3::ONE, Vec3::ONE, resolution, 4);
        assert_eq!(adaptive.bytes(), adaptive.cells());
        assert!(adaptive.bytes() <= (resolution as usize + 4).pow(3), "{} bytes", adaptive.bytes());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever a renderer may ask, not-a-number included, there is a state, and it is one that a cell is cut into.
    #[test]
    fn every_question_has_an_answer(p in any::<[f32; 3]>(), n in any::<[f32; 3]>(), u in 0.0f32..1.0, v in 0.0f32..1.0, resolution in 1u32..64) {
        for normals in [true, false] {
            grid(1000 * resolution, normals).key(p.into(), n.into(), [u, v, 0.5]);
        }
        let adaptive = adaptive(&mut Rng::new(resolution as u64), resolution.min(6));
        let key = adaptive.key(p.into(), n.into(), [u, v, 0.5]);
        prop_assert!(adaptive.cell_of(key) < adaptive.cells());
        prop_assert!(adaptive.holds(key));
        for neighbour in key.neighbours() {
            prop_assert!(adaptive.cell_of(neighbour) < adaptive.cells());
        }
    }

    /// Far outside, cells do not wrap round to the other side.
    #[test]
    fn far_points_fall_into_the_border(far in 1e6f32..1e30, axis in 0usize..3) {
        for states in ways(&mut Rng::new(8), 6) {
            let key = |p: Vec3| states.locate(p, Vec3::Y, [0.5; 3]);
            let mut p = Vec3::splat(0.5);
            p[axis] = far;
            let mut farther = p;
            farther[axis] = 10.0 * far;
            prop_assert_eq!(key(p), key(farther));
            prop_assert_ne!(key(p), key(-p));
        }
    }
}

#[test]
fn a_packets_keys_are_those_of_its_points() {
    let mut rng = Rng::new(12);
    let grid = Grid::new(Vec3::ZERO, Vec3::new(3.0, 1.0, 2.0), 40, true);
    let mut adaptive = TwoLevelGrid::new(Vec3::ZERO, Vec3::new(3.0, 1.0, 2.0), 40, 4);
    for _ in 0..200_000 {
        adaptive.divide(rng.next_u32() as usize % adaptive.cells());
    }
    for round in 0..300 {
        let (mut p, mut n) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
        for k in 0..LANES {
            // some of them outside
            p.set(k, Vec3::new(rng.f32() * 4.0 - 0.5, rng.f32(), rng.f32() * 2.0));
            n.set(k, if round == 0 { -Vec3::AXES[k % 3] } else { warp::square_to_uniform_sphere(rng.f32x2()) });
        }
        let jitter = jitter(&mut rng);
        let keys = adaptive.keys(&p, &n, jitter);
        assert!((0..LANES).all(|k| keys[k] == adaptive.key(p.get(k), n.get(k), jitter)));
        let keys = grid.keys(&p, &n, jitter);
        assert!((0..LANES).all(|k| keys[k] == grid.key(p.get(k), n.get(k), jitter)));
    }
}
