//! Surfaces of a packet against single ones.

use super::*;
use crate::math::rng::Rng;
use crate::math::warp::square_to_uniform_sphere;
use crate::simd::disassembly::{Arithmetic, Function, functions};
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes};

#[test]
fn surfaces_of_a_packet_scatter_like_single_ones() {
    let (both, front, metal) = (diffuse(), diffuse().sided(false), conductor(None, Ggx, 0.3));
    let (mut rng, mut lanes) = (Rng::new(41), DiffuseLanes::new());
    let (mut lit, mut dark) = (0, 0);
    for _ in 0..200 {
        let bsdfs: Vec<Option<Bsdf>> =
            (0..LANES).map(|k| [Some(both.bsdf()), Some(front.bsdf()), Some(metal.bsdf()), None][k % 4]).collect();
        let [mut wo, mut wi, mut f, mut drawn, mut albedo] = [Vec3Lanes::ZERO; 5];
        let ([mut pdf, mut density], mut u) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        lanes.clear();
        for (k, bsdf) in bsdfs.iter().enumerate() {
            if let Some(bsdf) = bsdf {
                lanes.set(k, bsdf);
            }
            wo.set(k, square_to_uniform_sphere(rng.f32x2()));
            wi.set(k, square_to_uniform_sphere(rng.f32x2()));
            (u[0][k], u[1][k]) = (rng.f32(), rng.f32());
        }
        lanes.eval_pdf(&wo, &wi, &mut f, &mut pdf);
        lanes.albedo(&wo, &mut albedo);
        lanes.sample(&wo, &u, &mut drawn, &mut density);
        for (k, bsdf) in bsdfs.iter().enumerate() {
            let Some(bsdf) = bsdf else {
                assert!(!lanes.are().has(k), "nothing is there");
                continue;
            };
            assert_eq!(albedo.get(k), if lanes.are().has(k) { bsdf.albedo(wo.get(k)) } else { Rgb::ZERO });
            assert_eq!(lanes.are().has(k), bsdf.lambertian().is_some());
            if !lanes.are().has(k) {
                assert_eq!(f.get(k), Rgb::ZERO);
                continue;
            }
            assert_eq!((f.get(k), pdf[k]), bsdf.eval_pdf(wo.get(k), wi.get(k)));
            match bsdf.sample(wo.get(k), 0.5, [u[0][k], u[1][k]]) {
                Some(sample) => {
                    assert_eq!((drawn.get(k), density[k]), (sample.wi, sample.pdf));
                    assert_eq!(lanes.reflectance(k), sample.weight);
                    lit += 1;
                }
                None => {
                    assert_eq!(density[k], 0.0);
                    dark += 1;
                }
            }
        }
    }
    assert!(lit > 1000 && dark > 300, "{lit} lit, {dark} dark");
}

/// All materials of which packets evaluate surfaces side by side, in packets of two of them and a Lambertian one.
#[test]
fn surfaces_of_one_material_scatter_together_like_single_ones() {
    let (mut rng, mut lanes, matt) = (Rng::new(42), BsdfLanes::new(), diffuse());
    let one_sided = smooth_materials().into_iter().map(|material| material.sided(false));
    let materials: Vec<Material> = smooth_materials().into_iter().chain(one_sided).collect();
    let (mut together, mut bright, mut kinds, mut hit, mut missed) = (0, 0, 0, 0, 0);
    for (number, material) in materials.iter().enumerate() {
        let (other, mut of_kind) = (&materials[(number + 7) % materials.len()], 0);
        for _ in 0..40 {
            let tints: [Rgb; LANES] = std::array::from_fn(|_| Rgb::new(rng.f32(), rng.f32(), rng.f32()));
            let bsdfs: [Option<Bsdf>; LANES] = std::array::from_fn(|k| {
                let material = [material, other, material, &matt, material, material, other][k % 7];
                let bsdf = material.model.at(material.colors.map(|color| color * tints[k]));
                (k % 5 != 4).then_some(if k == 9 { bsdf.with_normal(polar(0.3, 1.0)) } else { bsdf })
            });
            let [mut wo, mut wi, mut f, mut albedo] = [Vec3Lanes::ZERO; 4];
            let mut pdf = [-1.0; LANES];
            lanes.clear();
            for (k, bsdf) in bsdfs.iter().enumerate() {
                bsdf.iter().for_each(|bsdf| lanes.set(k, bsdf));
                wo.set(k, square_to_uniform_sphere(rng.f32x2()));
                wi.set(k, square_to_uniform_sphere(rng.f32x2()));
            }
            lanes.find_groups_of(3);
            let asked = Mask::from_bits(0xfff7);
            let done = lanes.eval_pdf(asked, [&wo, &wi], &mut f, &mut pdf);
            let seen = lanes.albedo(&wo, &mut albedo);
            assert_eq!(done, seen & asked);
            let numbers: [Lanes; 3] = std::array::from_fn(|_| std::array::from_fn(|_| rng.f32()));
            let ([mut drawn, mut weight], mut density) = ([Vec3Lanes::ZERO; 2], [-1.0; LANES]);
            let (lobe, u) = (&numbers[0], &[numbers[1], numbers[2]]);
            let sampled = lanes.sample(asked, &wo, (lobe, u), [&mut drawn, &mut weight], &mut density);
            assert!(!(sampled & !done).any());
            for k in 0..LANES {
                if !sampled.has(k) {
                    assert_eq!((drawn.get(k), weight.get(k), density[k]), (Rgb::ZERO, Rgb::ZERO, -1.0));
                    continue;
                }
                let single = bsdfs[k].as_ref().and_then(|bsdf| bsdf.sample(wo.get(k), lobe[k], [u[0][k], u[1][k]]));
                let Some(BsdfSample { wi, weight: single, pdf, delta, .. }) = single else {
                    assert_eq!(density[k], 0.0, "{}", material.name);
                    missed += 1;
                    continue;
                };
                let name = &material.name;
                assert_eq!((bits(drawn.get(k)), delta), (bits(wi), false), "{name}");
                assert_eq!((bits(weight.get(k)), density[k].to_bits()), (bits(single), pdf.to_bits()), "{name}");
                hit += 1;
            }
            for k in 0..LANES {
                if !done.has(k) {
                    assert_eq!((f.get(k), pdf[k]), (Rgb::ZERO, -1.0), "what is not asked for stays");
                    continue;
                }
                let bsdf = bsdfs[k].as_ref().expect("nothing else is evaluated");
                let (value, density) = bsdf.eval_pdf(wo.get(k), wi.get(k));
                let name = &material.name;
                assert_eq!((bits(f.get(k)), pdf[k].to_bits()), (bits(value), density.to_bits()), "{name}");
                assert_eq!(bits(albedo.get(k)), bits(bsdf.albedo(wo.get(k))), "{name}");
                together += 1;
                bright += (value != Rgb::ZERO) as u32;
                of_kind += 1;
            }
        }
        kinds += (of_kind > 50) as u32;
    }
    assert!(together > 5000 && bright > 1500 && kinds > 20, "{together} together, {bright} bright, {kinds} kinds");
    assert!(hit > 1500 && missed > 500, "{hit} drawn, {missed} not");
}

/// Loops over lanes that no longer run in vectors would be slow, and nothing else.
#[test]
fn surfaces_of_one_material_are_evaluated_by_vector_instructions() {
    const KINDS: [&str; 4] =
        ["DiffuseTransmitterModel", "..PlasticModel", "RoughConductorModel", "TexturedPrincipledModel"];
    for loops in ["eval_pdf_lanes", "albedo_lanes", "draw_lanes"] {
        let Some(functions) = functions(&["phototaxis", "bsdf", loops]) else { return };
        // a smooth coat has a delta lobe, and is drawn from one by one
        for kind in KINDS.into_iter().filter(|&kind| loops != "draw_lanes" || kind != "..PlasticModel") {
            let mut of_kind = functions.iter().filter(|function| function.name.contains(kind)).peekable();
            assert!(of_kind.peek().is_some(), "{kind} has no {loops}");
            for Function { name, arithmetic } in of_kind {
                let Arithmetic { packed, scalar } = *arithmetic;
                // whole vectors of 512 bits, which some processors are compiled for, take one instruction for each component of a colour
                assert!(packed >= 3 && packed > 4 * scalar, "{packed} packed, {scalar} scalar in {name}");
            }
        }
    }
    // a negative control: frosted glass, which packets evaluate one by one
    let single = functions(&["RoughDielectric", "Scatter", "8eval_pdf"]).unwrap_or_default();
    let scalar = single.iter().any(|Function { arithmetic, .. }| arithmetic.scalar > 4 * arithmetic.packed);
    assert!(scalar, "{} functions, and all of them in vectors", single.len());
}

fn bits(color: Rgb) -> [u32; 3] {
    color.to_array().map(f32::to_bits)
}
