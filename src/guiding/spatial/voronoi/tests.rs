//! Voronoi states against brute force, and where sites go. χ² tests raise a false alarm with probability 10⁻⁶ each.

use super::*;
use crate::math::rng::Rng;
use crate::math::warp::square_to_uniform_sphere;
use crate::simd::mask;
use crate::stats::chi2_discrete;
use proptest::prelude::*;

const LEVEL: f64 = 1e-6;
const STILL: [f32; 2] = [0.5; 2];

/// The definition: sites whose normal agrees first, then the nearest, then the first.
fn brute_force(voronoi: &Voronoi, p: Vec3, n: Vec3) -> u32 {
    let rank = |(i, site): (usize, Site)| (n.dot(site.n) <= 0.5, (p - site.p).length_squared(), i as u32);
    let ranks = voronoi.sites().enumerate().map(rank);
    ranks.min_by(|a, b| a.partial_cmp(b).expect("a number")).expect("a site").2
}

/// A room of side 1: six walls that face inwards, and a box that stands in it askew and faces outwards.
fn room() -> Vec<Facet> {
    let turn = glam::Quat::from_rotation_y(0.4);
    let mut facets = cube(|p| p, true);
    facets.extend(cube(|p| turn * (p * 0.3 + Vec3::new(0.4, 0.0, 0.2)), false));
    facets
}

fn cube(place: impl Fn(Vec3) -> Vec3, inwards: bool) -> Vec<Facet> {
    let square = |axis: usize, high: f32| {
        let corner = |u: f32, v: f32| {
            let mut p = Vec3::splat(high);
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = if (high > 0.5) == inwards { (v, u) } else { (u, v) };
            place(p)
        };
        let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        [[a, b, c], [a, c, d]].map(|corners| Facet { corners, two_sided: false })
    };
    let squares = (0..3).flat_map(|axis| [square(axis, 0.0), square(axis, 1.0)]);
    squares.flatten().collect()
}

fn unit(rng: &mut Rng) -> Vec3 {
    square_to_uniform_sphere(rng.f32x2())
}

fn point(rng: &mut Rng, low: f32, high: f32) -> Vec3 {
    low + (high - low) * Vec3::new(rng.f32(), rng.f32(), rng.f32())
}

/// Points of the facets, as look-ups would ask for them.
fn points(facets: &[Facet], n: usize, seed: u64) -> Vec<(Vec3, Vec3)> {
    sites_by_area(facets.iter().copied(), n, seed).into_iter().map(|site| (site.p, site.n)).collect()
}

fn voronoi(facets: &[Facet], n: usize) -> Voronoi {
    let sites = sites_by_area(facets.iter().copied(), n, 1);
    assert_eq!(sites.len(), n);
    Voronoi::new(sites, &points(facets, 8 * n, 2)).expect("there are sites")
}

fn quad(a: Vec3, u: Vec3, v: Vec3, two_sided: bool) -> [Facet; 2] {
    [[a, a + u, a + u + v], [a, a + u + v, a + v]].map(|corners| Facet { corners, two_sided })
}

#[test]
fn on_surfaces_and_off_them_the_answer_is_that_of_brute_force() {
    let mut rng = Rng::new(3);
    let voronoi = voronoi(&room(), 3000);
    let agrees = |p: Vec3, n: Vec3| {
        let state = voronoi.state(p, n, STILL);
        assert_eq!(state, brute_force(&voronoi, p, n), "{p} {n}");
        assert_eq!(state, voronoi.state_by_tree(p, n, STILL));
    };
    for (p, n) in points(&room(), 20_000, 4) {
        agrees(p, n);
        agrees(p, (n + 0.8 * unit(&mut rng)).normalize());
    }
    for scale in [1.0, 1.5, 100.0, 1e6, 1e25] {
        (0..200).for_each(|_| agrees(point(&mut rng, -scale, scale), unit(&mut rng)));
    }
}

#[test]
fn a_packet_has_the_states_of_its_points() {
    let mut rng = Rng::new(8);
    let voronoi = voronoi(&room(), 3000);
    let mut queries = points(&room(), 20_000, 4);
    for scale in [1.0, 1.5, 100.0, 1e6, 1e25, f32::NAN] {
        queries.extend((0..200).map(|_| (point(&mut rng, -scale, scale), unit(&mut rng))));
    }
    queries.push((Vec3::splat(0.1), Vec3::NAN));
    for queries in queries.chunks(LANES - 1) {
        let (mut p, mut n, jitter) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO, rng.f32x2());
        queries.iter().enumerate().for_each(|(k, query)| (p.set(k, query.0), n.set(k, query.1)).0);
        let states = voronoi.states(mask(|k| k < queries.len()), &p, &n, jitter);
        for (k, (p, n)) in queries.iter().enumerate() {
            assert_eq!(states[k], voronoi.state(*p, *n, jitter), "{p} {n}");
        }
    }
}

#[test]
fn most_look_ups_of_a_room_are_prepared_for() {
    for n in [1000, 10_000] {
        let voronoi = voronoi(&room(), n);
        let share = voronoi.prepared(&points(&room(), 50_000, 9));
        assert!(share > 0.97, "{n} sites: {share}");
        assert!(voronoi.prepared(&[(Vec3::splat(9.0), Vec3::Y)]) == 0.0, "far outside");
    }
}

#[test]
fn the_two_sides_of_a_thin_sheet_never_share_a_state() {
    let mut rng = Rng::new(5);
    let sheet = quad(Vec3::ZERO, Vec3::new(0.3, 0.9, 0.1), Vec3::new(-0.5, 0.2, 0.9), true);
    let voronoi = voronoi(&sheet, 400);
    for (p, n) in points(&sheet, 10_000, 6) {
        let jitter = rng.f32x2();
        let [front, back] = [n, -n].map(|n| voronoi.state(p, n, jitter));
        assert!(voronoi.frame(front).n.dot(n) > 0.99 && voronoi.frame(back).n.dot(n) < -0.99);
    }
    // one site on the other side is enough, wherever it is
    let far = Site { p: Vec3::splat(50.0), n: -Vec3::Z };
    let near = (0..50).map(|_| Site { p: point(&mut rng, 0.0, 1.0), n: Vec3::Z });
    let voronoi = Voronoi::new(near.chain([far]).collect(), &[]).unwrap();
    assert_eq!(voronoi.site(voronoi.state(Vec3::splat(0.5), -Vec3::Z, STILL)), far);
}

#[test]
fn walls_that_meet_in_a_corner_do_not_share_states() {
    let voronoi = voronoi(&cube(|p| p, true), 600);
    for corner in [Vec3::ZERO, Vec3::ONE, Vec3::new(0.0, 1.0, 0.0)] {
        for axis in Vec3::AXES {
            let n = axis * (1.0 - 2.0 * corner.dot(axis));
            assert!(voronoi.frame(voronoi.state(corner, n, STILL)).n.dot(n) > 0.999, "{corner} {n}");
        }
    }
}

#[test]
fn where_no_normal_agrees_the_nearest_site_answers() {
    let mut rng = Rng::new(7);
    let mut site = || Site { p: point(&mut rng, 0.0, 1.0) * Vec3::new(1.0, 0.0, 1.0), n: Vec3::Y };
    let sites = (0..200).map(|_| site()).collect();
    let samples: Vec<_> = (0..500).map(|_| (point(&mut rng, 0.0, 1.0) * Vec3::new(1.0, 0.01, 1.0), -Vec3::Y)).collect();
    let voronoi = Voronoi::new(sites, &samples).unwrap();
    assert!(voronoi.prepared(&samples) > 0.5, "lists are tested, not the tree alone");
    for (p, n) in samples {
        let nearest = voronoi.sites().map(|site| (p - site.p).length_squared()).fold(f32::INFINITY, f32::min);
        assert_eq!((p - voronoi.site(voronoi.state(p, n, STILL)).p).length_squared(), nearest);
    }
}

#[test]
fn jitter_moves_along_the_surface_to_the_neighbours() {
    let mut rng = Rng::new(8);
    let n = Vec3::new(0.6, 0.64, 0.48);
    let frame = Frame::from_normal(n);
    // a square lattice of spacing 0.1 in a plane turned off the axes
    let lattice = |i: i32| n * 3.0 + frame.s * (0.1 * (i % 40) as f32) + frame.t * (0.1 * (i / 40) as f32);
    let voronoi = Voronoi::new((0..1600).map(|i| Site { p: lattice(i), n }).collect(), &[]).unwrap();
    let p = lattice(20 * 40 + 20) + (frame.s + frame.t) * 0.03;
    let (mut met, mut farthest) = (std::collections::HashSet::new(), 0.0f32);
    for _ in 0..1000 {
        let jitter = rng.f32x2();
        let moved = voronoi.cells.moved(p, n, jitter).0 - p;
        assert!(moved.dot(n).abs() < 1e-6, "off the plane");
        farthest = farthest.max(moved.dot(frame.s).abs());
        met.insert(voronoi.state(p, n, jitter));
    }
    assert!((0.045..0.055).contains(&farthest), "half a spacing is 0.05, not {farthest}");
    assert_eq!(met.len(), 4, "half a spacing to either side reaches four squares");
    assert_eq!(voronoi.cells.moved(p, n, STILL).0, p);
}

#[test]
fn duplicates_and_single_sites_answer() {
    let site = Site { p: Vec3::splat(0.5), n: Vec3::Z };
    for count in [1, 2, 7, 100] {
        let voronoi = Voronoi::new(vec![site; count], &[(Vec3::ONE, Vec3::X)]).unwrap();
        assert_eq!(voronoi.len(), count);
        for (p, n) in [(site.p, Vec3::Z), (Vec3::ZERO, -Vec3::Z), (Vec3::splat(1e30), Vec3::X)] {
            assert_eq!(voronoi.state(p, n, [0.1, 0.9]), 0, "the first of equals");
        }
    }
}

#[test]
fn what_is_no_site_is_left_out() {
    let no = |p: Vec3, n: Vec3| Site { p, n };
    let bad =
        [no(Vec3::NAN, Vec3::X), no(Vec3::ZERO, Vec3::ZERO), no(Vec3::INFINITY, Vec3::X), no(Vec3::ZERO, Vec3::NAN)];
    assert!(Voronoi::new(bad.to_vec(), &[]).is_none() && Voronoi::new(Vec::new(), &[]).is_none());
    let some = Voronoi::new([&bad[..], &[no(Vec3::ONE, Vec3::X * 3.0)]].concat(), &[(Vec3::NAN, Vec3::NAN)]).unwrap();
    assert_eq!(some.sites().collect::<Vec<_>>(), [no(Vec3::ONE, Vec3::X)]);
}

#[test]
fn bytes_are_counted_and_stay_within_the_estimate() {
    for n in [500, 5000, 50_000] {
        let facets = room();
        let sites = || sites_by_area(facets.iter().copied(), n, 1);
        let (bare, full) = (Voronoi::new(sites(), &[]).unwrap(), voronoi(&facets, n));
        let per_site = [bare.bytes(), full.bytes()].map(|bytes| bytes / n);
        assert!(per_site[0] > 24 + size_of::<Frame>() && per_site[0] <= per_site[1], "{n}: {per_site:?}");
        assert!(
            per_site[1] <= Voronoi::bytes_per_site() && per_site[1] > Voronoi::bytes_per_site() / 4,
            "{n}: {per_site:?}"
        );
    }
}

#[test]
fn the_same_input_gives_the_same_states() {
    let facets = room();
    let visits = points(&facets, 20_000, 3);
    let make = || Voronoi::new(sites_from_visits(&visits, 700), &visits).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(make);
    let many = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap().install(make);
    assert!(one.sites().eq(many.sites()) && one.bytes() == many.bytes());
    assert_eq!(one.prepared(&visits), many.prepared(&visits));
    let by_area = |seed| sites_by_area(facets.iter().copied(), 50, seed);
    assert_eq!(by_area(1), by_area(1));
    assert_ne!(by_area(1), by_area(2));
}

/// The unit square, two-sided, in uneven strips.
fn strips() -> Vec<Facet> {
    let corners = [0.0, 0.01, 0.1, 0.4, 1.0];
    let strip = |x: &[f32]| quad(Vec3::X * x[0], Vec3::X * (x[1] - x[0]), Vec3::Y, true);
    corners.windows(2).flat_map(strip).collect()
}

/// How many lie in each of 8 × 8 equal parts of the unit square, on each side.
fn counts(sites: &[Site]) -> Vec<u64> {
    let mut counts = vec![0; 128];
    for site in sites {
        let cell = |v: f32| ((v * 8.0) as usize).min(7);
        counts[cell(site.p.x) * 8 + cell(site.p.y) + if site.n.z < 0.0 { 64 } else { 0 }] += 1;
    }
    counts
}

#[test]
fn sites_by_area_are_uniform_in_area() {
    let n = 50_000;
    let sites = counts(&sites_by_area(strips().into_iter(), n, 11));
    let report = chi2_discrete(&sites, &[1.0 / 128.0; 128]);
    assert!(report.passes(LEVEL), "{report}");
    // better than independent points, of which each part's number would be off by 20 in the mean
    assert!(sites.iter().all(|c| c.abs_diff(n as u64 / 128) < 20), "{sites:?}");
    // as many sites in each triangle, whatever its area, are not uniform
    let by_facet: Vec<Site> = strips().into_iter().flat_map(|f| sites_by_area([f].into_iter(), n / 8, 11)).collect();
    assert!(chi2_discrete(&counts(&by_facet), &[1.0 / 128.0; 128]).p_value < LEVEL);
}

#[test]
fn triangles_without_area_get_no_sites() {
    let flat = |a: Vec3, b: Vec3, c: Vec3| Facet { corners: [a, b, c], two_sided: true };
    let bad = [
        flat(Vec3::ONE, Vec3::ONE, Vec3::X),
        flat(Vec3::NAN, Vec3::X, Vec3::Y),
        flat(Vec3::ZERO, Vec3::X, 2.0 * Vec3::X),
    ];
    assert!(sites_by_area(bad.into_iter(), 10, 1).is_empty());
    let good = flat(Vec3::ZERO, Vec3::X, Vec3::Y);
    let sites = sites_by_area(bad.into_iter().chain([good]).chain(bad), 10, 1);
    assert_eq!(sites.len(), 10);
    assert!(
        sites.iter().all(|s| s.p.z == 0.0 && s.n.z.abs() == 1.0 && s.p.min_element() >= 0.0 && s.p.x + s.p.y < 1.001)
    );
    assert_eq!(sites.iter().filter(|s| s.n.z > 0.0).count(), 5);
    assert!(sites_by_area([good].into_iter(), 0, 1).is_empty());
}

#[test]
fn sites_from_visits_follow_the_visits() {
    let mut rng = Rng::new(12);
    // nine visits of ten fall on the lower half of the floor
    let visits: Vec<(Vec3, Vec3)> = (0..100_000)
        .map(|i| (Vec3::new(rng.f32(), 0.0, 0.5 * (rng.f32() + if i % 10 == 0 { 1.0 } else { 0.0 })), Vec3::Y))
        .collect();
    let sites = sites_from_visits(&visits, 1000);
    assert_eq!(sites.len(), 1000);
    let low = sites.iter().filter(|site| site.p.z < 0.5).count();
    assert!(low.abs_diff(900) < 10, "{low}");
    assert!(sites.iter().all(|site| visits.contains(&(site.p, site.n))));
    // spread out: independent points have a tenth of them closer than a fifth of the mean spacing
    let close = |a: &Site| sites.iter().any(|b| a != b && (a.p - b.p).length() < 0.2 * (0.5f32 / 900.0).sqrt());
    let crowded = sites.iter().filter(|site| close(site)).count();
    assert!(crowded < 20, "{crowded}");
}

#[test]
fn thinning_keeps_the_sides_of_a_sheet_apart_and_copies_together() {
    let sheet: Vec<(Vec3, Vec3)> =
        (0..1000).map(|i| (Vec3::new(i as f32, 0.0, 0.0), if i % 3 == 0 { Vec3::Z } else { -Vec3::Z })).collect();
    let sites = sites_from_visits(&sheet, 9);
    assert_eq!((sites.len(), sites.iter().filter(|s| s.n == Vec3::Z).count()), (9, 3));
    let copies = [vec![(Vec3::ONE, Vec3::X); 50], vec![(Vec3::ZERO, Vec3::X)], vec![(Vec3::NAN, Vec3::X)]].concat();
    assert_eq!(sites_from_visits(&copies, 10).len(), 2);
    assert!(sites_from_visits(&[], 10).is_empty() && sites_from_visits(&sheet, 0).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Sites of any kind: clustered, coplanar, few normals or many, far from the origin or not.
    #[test]
    fn any_sites_and_points_agree_with_brute_force(
        seed in any::<u64>(), count in 1usize..400, flat in any::<bool>(), normals in 0usize..4, shift in prop_oneof![Just(0.0f32), Just(1e3), Just(1e6)], power in 1i32..5,
    ) {
        let mut rng = Rng::new(seed);
        let axes: Vec<Vec3> = (0..normals).map(|_| unit(&mut rng)).collect();
        let draw = |rng: &mut Rng| {
            let p = Vec3::new(rng.f32().powi(power), rng.f32(), if flat { 0.25 } else { rng.f32() });
            (p * 10.0 + shift, if axes.is_empty() { unit(rng) } else { axes[rng.next_u32() as usize % axes.len()] })
        };
        let sites = (0..count).map(|_| draw(&mut rng)).map(|(p, n)| Site { p, n }).collect();
        let samples: Vec<_> = (0..500).map(|_| draw(&mut rng)).collect();
        let voronoi = Voronoi::new(sites, &samples).unwrap();
        for (p, n) in samples {
            let jitter = rng.f32x2();
            prop_assert_eq!(voronoi.state(p, n, STILL), brute_force(&voronoi, p, n));
            let moved = voronoi.cells.moved(p, n, jitter).0;
            prop_assert_eq!(voronoi.state(p, n, jitter), brute_force(&voronoi, moved, n));
        }
    }

    /// Whatever a renderer may ask, not-a-number included, there is a state.
    #[test]
    fn every_question_has_an_answer(p in any::<[f32; 3]>(), n in any::<[f32; 3]>(), u in 0.0f32..1.0, v in 0.0f32..1.0) {
        static ROOM: std::sync::LazyLock<Voronoi> = std::sync::LazyLock::new(|| voronoi(&room(), 300));
        prop_assert!((ROOM.state(p.into(), n.into(), [u, v]) as usize) < ROOM.len());
        let holes = |p: Vec3| [Vec3::new(f32::NAN, p.y, p.z), Vec3::new(p.x, f32::INFINITY, f32::NAN)];
        for p in holes(p.into()).into_iter().chain(holes(Vec3::splat(0.5))) {
            prop_assert!((ROOM.state(p, n.into(), [u, v]) as usize) < ROOM.len());
        }
    }
}
