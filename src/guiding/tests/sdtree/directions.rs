//! Directions drawn, against the density that is claimed for them.

use super::*;
use crate::math::Frame;
use crate::math::rng::Rng;
use crate::stats::{Chi2Report, DirectionTest, Domain, chi2_discrete, sidak};
use proptest::prelude::*;

/// False alarm of the whole set of χ² tests.
const LEVEL: f64 = 1e-6;

/// Cells as fine as quadtrees of six levels: those densities jump at borders of cells only, so the quadrature is exact.
fn chi2(quadtree: Quadtree, rng: &mut Rng, wrong: impl Fn(Vec3) -> Vec3) -> Chi2Report {
    let test = DirectionTest { cos_bins: 64, phi_bins: 64, samples: 100_000, depth: 0, domain: Domain::Sphere };
    test.run(|| Some(quadtree.draw(rng.f32x2())), |w| quadtree.pdf(wrong(w)))
}

/// What light a tree is trained with.
type Light = fn(Vec3) -> f32;

const LIGHTS: [(&str, Light); 6] = [
    ("even", |_| 1.0),
    ("from above", |w| w.z.max(0.0)),
    ("one spot", |w| lobe(w, Vec3::new(0.6, 0.0, 0.8), 200)),
    ("two spots, at the pole and at the seam", |w| lobe(w, Vec3::NEG_Z, 60) + 3.0 * lobe(w, Vec3::X, 90)),
    ("mostly black", |w| if (w.x * 9.0).sin() > 0.8 { 1.0 } else { 0.0 }),
    ("tiny", |w| 1e-35 * (1.5 + w.y)),
];

#[test]
fn directions_follow_their_density() {
    let mut rng = Rng::new(1);
    let level = sidak(LEVEL, 2 * LIGHTS.len());
    for (name, light) in LIGHTS {
        for filter in [true, false] {
            let mut tree = single(|s| (s.directional_filter, s.levels) = (filter, 6));
            train(&mut tree, &mut rng, 3, 10_000, |_, w| light(w));
            let quadtree = tree.distribution(0).expect("it is trained");
            let report = chi2(quadtree, &mut rng, |w| w);
            assert!(report.passes(level), "{name}, filter {filter}: {report}");
            assert!((report.mass - 1.0).abs() < 1e-3, "{name}: {report}");
            // the same density, turned by a few degrees; evenly spread light looks the same from everywhere
            let turned = Frame::from_normal(Vec3::new(0.12, 0.05, 0.99).normalize());
            let wrong = chi2(quadtree, &mut rng, |w| turned.to_world(w));
            assert!(name == "even" || !wrong.passes(LEVEL), "{name}: turned, and unseen: {wrong}");
            println!("{name}, filter {filter}, {} nodes: {report}", quadtree.nodes());
        }
    }
}

#[test]
fn directions_drawn_have_a_density() {
    let mut rng = Rng::new(2);
    for (name, light) in LIGHTS {
        let mut tree = single(|s| s.rho = 1e-4);
        train(&mut tree, &mut rng, 3, 20_000, |_, w| light(w));
        let quadtree = tree.distribution(0).expect("it is trained");
        let n = 1_000_000;
        let lost = (0..n).filter(|_| {
            let w = quadtree.draw(rng.f32x2());
            assert!(w.is_normalized(), "{w}");
            let pdf = quadtree.pdf(w);
            assert!(pdf.is_finite() && pdf >= 0.0);
            pdf == 0.0
        });
        assert_eq!(lost.count(), 0, "{name}");
    }
}

#[test]
fn corners_of_the_unit_square_give_directions() {
    let mut tree = single(|_| ());
    train(&mut tree, &mut Rng::new(3), 2, 5_000, |_, w| lobe(w, Vec3::X, 40));
    let quadtree = tree.distribution(0).expect("it is trained");
    let last = crate::math::ONE_MINUS_EPSILON;
    for u in [[0.0, 0.0], [0.0, last], [last, 0.0], [last, last], [0.5, 0.5]] {
        let w = quadtree.draw(u);
        assert!(w.is_normalized() && quadtree.pdf(w) > 0.0, "{u:?} gives {w}");
    }
    assert!(quadtree.pdf(Vec3::NAN).is_finite());
}

#[test]
fn known_directions_lie_where_the_map_puts_them() {
    assert_eq!(encode(Vec3::X), [32_768, 0]);
    assert_eq!(encode(Vec3::Y), [32_768, 16_384]);
    assert_eq!(encode(Vec3::NEG_X), [32_768, 32_768]);
    assert_eq!(encode(Vec3::new(0.0, -0.6, 0.8))[0], 58_982);
    assert_eq!(encode(Vec3::Z)[0], 65_535);
    assert_eq!(encode(Vec3::NEG_Z)[0], 0);
}

/// A leaf of a quadtree.
struct Leaf {
    /// Its lowest direction, as [`morton`] orders them: leaves follow one another without gaps.
    start: u64,
    /// ∫ pdf dω over it.
    mass: f64,
}

/// All leaves, in order.
fn leaves(nodes: &[QuadNode]) -> Vec<Leaf> {
    let (quadtree, mut leaves, mut open) = (Quadtree::new(nodes), Vec::new(), vec![(0, [0u32; 2], 1)]);
    while let Some((node, corner, level)) = open.pop() {
        let side = 1 << (16 - level);
        for q in 0..4 {
            let corner = [corner[0] + (q & 1) * side, corner[1] + (q >> 1) * side];
            match nodes[node].branch().child(q) {
                Some(child) => open.push((child, corner, level + 1)),
                None => {
                    let solid_angle = 4.0 * PI * 0.25f64.powi(level);
                    let mass = quadtree.density_encoded(corner.map(|c| c as u16)) as f64 * solid_angle;
                    leaves.push(Leaf { start: morton(corner), mass });
                }
            }
        }
    }
    leaves.sort_by_key(|leaf| leaf.start);
    leaves
}

/// The bits of both coordinates in turn.
fn morton([x, y]: [u32; 2]) -> u64 {
    (0..16).map(|i| ((x >> i & 1) as u64) << (2 * i) | ((y >> i & 1) as u64) << (2 * i + 1)).sum()
}

/// The same for deep quadtrees, against masses that are exact, leaf by leaf.
#[test]
fn deep_quadtrees_draw_their_leaves_by_their_masses() {
    let mut rng = Rng::new(4);
    let level = sidak(LEVEL, LIGHTS.len());
    for (name, light) in LIGHTS {
        let mut tree = single(|s| s.rho = 1e-3);
        train(&mut tree, &mut rng, 3, 20_000, |_, w| light(w));
        let quadtree = tree.distribution(0).expect("it is trained");
        let leaves = leaves(tree.distribution(0).expect("it is trained").words());
        let masses: Vec<f64> = leaves.iter().map(|leaf| leaf.mass).collect();
        let mut counts = vec![0; masses.len()];
        for _ in 0..400_000 {
            let at = morton(encode(quadtree.draw(rng.f32x2())).map(u32::from));
            counts[leaves.partition_point(|leaf| leaf.start <= at) - 1] += 1;
        }
        let report = chi2_discrete(&counts, &masses);
        println!("{name}, {} leaves: {report}", masses.len());
        assert!(report.passes(level), "{name}: {report}");
        // every leaf with the mass of the next: seen, unless all are alike
        let mut wrong = masses.clone();
        wrong.rotate_left(1);
        assert!(name == "even" || !chi2_discrete(&counts, &wrong).passes(LEVEL), "{name}: unseen");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    /// Of samples with energies from 2⁻⁶⁰ to 2⁶⁰ in few or many directions, at any fineness.
    #[test]
    fn densities_integrate_to_one(seed: u64, n in 1usize..300, rho in 0.0005f32..0.5, levels in 1u32..=16, filter: bool) {
        let (mut rng, mut tree) = (Rng::new(seed), single(|s| (s.rho, s.levels, s.directional_filter) = (rho, levels, filter)));
        for _ in 0..3 {
            let one = |rng: &mut Rng| {
                let radiance = (120.0 * rng.f32() - 60.0).exp2();
                sample(0, square_to_uniform_sphere(rng.f32x2()), radiance, 1.0, 1.0)
            };
            let samples: Vec<_> = (0..n).map(|_| one(&mut rng)).collect();
            tree.fold(&[&samples]);
            tree.end_iteration(1);
            let mass: f64 = leaves(tree.distribution(0).expect("it is trained").words()).iter().map(|leaf| leaf.mass).sum();
            prop_assert!((mass - 1.0).abs() < 1e-5, "mass {}", mass);
        }
        let quadtree = tree.distribution(0).expect("it is trained");
        for _ in 0..100 {
            let w = quadtree.draw(rng.f32x2());
            prop_assert!(w.is_normalized() && quadtree.pdf(w).is_finite());
        }
    }

    /// Wherever the box lies, at the seam and the poles too.
    #[test]
    fn filtering_loses_no_energy(seed: u64, at: [u16; 2], filter: bool) {
        let (mut rng, mut tree) = (Rng::new(seed), single(|s| s.rho = 0.003));
        train(&mut tree, &mut rng, 2, 500, |_, w| lobe(w, Vec3::X, 50));
        let mut quadtree = tree.0.store.get(RegionId(0)).expect("it is trained").directions.energy().clone();
        quadtree.decay(0.0);
        quadtree.splat(at, 3.0, filter);
        prop_assert!((quadtree.sum_up() - 3.0).abs() < 1e-12);
    }
}

#[test]
fn a_word_holds_what_a_node_is() {
    for mask in 0..16u32 {
        let node = QuadNode::new(Branch::new(12_345, mask), [1.0, 2.0, 3.0, 10.0]);
        let mut next = 12_345;
        for q in 0..4 {
            let divided = mask >> q & 1 == 1;
            assert_eq!(node.branch().child(q), divided.then_some(next), "mask {mask}, quadrant {q}");
            next += usize::from(divided);
        }
        for (q, expected) in [(0u32, 1.0 / 4.0), (1, 2.0 / 4.0), (2, 3.0 / 4.0), (3, 10.0 / 4.0)] {
            let density = node.density(q & 1, q >> 1);
            assert!((density - expected).abs() < 5e-4, "quadrant {q}: {density}");
        }
    }
    // what is black gets nothing, what is not gets something
    let node = QuadNode::new(Branch::new(1, 0), [0.0, 1e-30, 0.0, 1e30]);
    assert_eq!((node.density(0, 0), node.density(0, 1)), (0.0, 0.0));
    assert!(node.density(1, 0) > 0.0);
}
