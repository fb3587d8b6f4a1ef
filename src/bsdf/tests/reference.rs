//! Values against an independent renderer: Mitsuba 3.9.1, variant `scalar_rgb`, radiance transport.

use super::*;

/// Material, (θ, φ) of wo and of wi, f(wo, wi)·|cosθi| there.
type Value = (Material, [f32; 2], [f32; 2], [f32; 3]);

fn metal(kind: MicrofacetDistribution, alpha: f32) -> Material {
    let aluminium = (Rgb::new(1.65746, 0.880369, 0.521229), Rgb::new(9.22387, 6.26952, 4.837));
    conductor(Some(aluminium), kind, alpha).colored(Rgb::new(0.9, 0.5, 0.2), Rgb::ZERO)
}

fn glass(kind: MicrofacetDistribution, alpha: f32, ior: f32) -> Material {
    dielectric(ior, kind, alpha, false)
}

fn coated(kind: MicrofacetDistribution, alpha: f32, nonlinear: bool) -> Material {
    plastic(kind, alpha, nonlinear, Rgb::new(1.0, 0.5, 0.8))
}

#[rustfmt::skip]
fn values() -> Vec<Value> {
    vec![
        (metal(Ggx, 0.1), [0.3, 0.0], [0.35, 3.0], [5.5656, 3.05784, 1.22462]),
        (metal(Ggx, 0.1), [1.0, 0.2], [0.6, 2.5], [0.0365381, 0.0200713, 0.00804036]),
        (metal(Ggx, 0.1), [1.4, 0.5], [1.3, 3.6], [7.5675, 4.21941, 1.72521]),
        (metal(Ggx, 0.1), [0.8, 1.0], [0.2, 4.0], [0.100447, 0.0551855, 0.0221018]),
        (metal(Beckmann, 0.25), [0.3, 0.0], [0.35, 3.0], [1.09468, 0.601438, 0.240866]),
        (metal(Beckmann, 0.25), [1.0, 0.2], [0.6, 2.5], [0.0982163, 0.0539528, 0.0216129]),
        (metal(Beckmann, 0.25), [1.4, 0.5], [1.3, 3.6], [4.52876, 2.52509, 1.03245]),
        (metal(Beckmann, 0.25), [0.8, 1.0], [0.2, 4.0], [0.390518, 0.21455, 0.0859271]),
        (glass(Ggx, 0.3, 1.5), [0.3, 0.0], [0.35, 3.0], [0.0361377, 0.0361377, 0.0361377]),
        (glass(Ggx, 0.3, 1.5), [1.0, 0.2], [0.6, 2.5], [0.00941733, 0.00941733, 0.00941733]),
        (glass(Ggx, 0.3, 1.5), [1.4, 0.5], [1.3, 3.6], [0.695459, 0.695459, 0.695459]),
        (glass(Ggx, 0.3, 1.5), [0.8, 1.0], [0.2, 4.0], [0.0142786, 0.0142786, 0.0142786]),
        (glass(Ggx, 0.3, 1.5), [0.4, 0.0], [2.9, 3.0], [8.3842, 8.3842, 8.3842]),
        (glass(Ggx, 0.3, 1.5), [1.2, 0.3], [2.5, 3.3], [1.45125, 1.45125, 1.45125]),
        (glass(Ggx, 0.3, 1.5), [2.6, 0.5], [0.7, 3.4], [3.50168, 3.50168, 3.50168]),
        (glass(Ggx, 0.3, 1.5), [2.0, 0.5], [2.2, 3.5], [1.20312, 1.20312, 1.20312]),
        (glass(Beckmann, 0.2, 1.33), [0.3, 0.0], [0.35, 3.0], [0.0409121, 0.0409121, 0.0409121]),
        (glass(Beckmann, 0.2, 1.33), [1.0, 0.2], [0.6, 2.5], [0.000684657, 0.000684657, 0.000684657]),
        (glass(Beckmann, 0.2, 1.33), [1.4, 0.5], [1.3, 3.6], [2.2925, 2.2925, 2.2925]),
        (glass(Beckmann, 0.2, 1.33), [0.8, 1.0], [0.2, 4.0], [0.00640092, 0.00640092, 0.00640092]),
        (glass(Beckmann, 0.2, 1.33), [0.4, 0.0], [2.9, 3.0], [12.1546, 12.1546, 12.1546]),
        (glass(Beckmann, 0.2, 1.33), [1.2, 0.3], [2.5, 3.3], [0.62226, 0.62226, 0.62226]),
        (glass(Beckmann, 0.2, 1.33), [2.6, 0.5], [0.7, 3.4], [0.658304, 0.658304, 0.658304]),
        (glass(Beckmann, 0.2, 1.33), [2.0, 0.5], [2.2, 3.5], [2.71048, 2.71048, 2.71048]),
        (coated(Ggx, 0.2, true), [0.3, 0.0], [0.35, 3.0], [0.237907, 0.0997591, 0.0759162]),
        (coated(Ggx, 0.2, true), [1.0, 0.2], [0.6, 2.5], [0.138248, 0.0531818, 0.0155738]),
        (coated(Ggx, 0.2, true), [1.4, 0.5], [1.3, 3.6], [1.62158, 0.807196, 1.27584]),
        (coated(Ggx, 0.2, true), [0.8, 1.0], [0.2, 4.0], [0.174809, 0.0677449, 0.0226646]),
        (coated(Ggx, 0.05, false), [0.3, 0.0], [0.35, 3.0], [0.847006, 0.423503, 0.521709]),
        (coated(Ggx, 0.05, false), [1.0, 0.2], [0.6, 2.5], [0.194694, 0.0973468, 0.0247089]),
        (coated(Ggx, 0.05, false), [1.4, 0.5], [1.3, 3.6], [1.96627, 0.983135, 1.54958]),
        (coated(Ggx, 0.05, false), [0.8, 1.0], [0.2, 4.0], [0.239474, 0.119737, 0.0309048]),
        (coated(Beckmann, 0.3, true), [0.3, 0.0], [0.35, 3.0], [0.206479, 0.0804165, 0.0423417]),
        (coated(Beckmann, 0.3, true), [1.0, 0.2], [0.6, 2.5], [0.15181, 0.0569286, 0.0193108]),
        (coated(Beckmann, 0.3, true), [1.4, 0.5], [1.3, 3.6], [1.24739, 0.619274, 0.974123]),
        (coated(Beckmann, 0.3, true), [0.8, 1.0], [0.2, 4.0], [0.195467, 0.0743324, 0.0304212]),
        (coated(Ggx, 0.0, true), [0.3, 0.0], [0.35, 3.0], [0.187423, 0.0643251, 0.0130193]),
        (coated(Ggx, 0.0, true), [1.0, 0.2], [0.6, 2.5], [0.157838, 0.0541711, 0.0109641]),
        (coated(Ggx, 0.0, true), [1.4, 0.5], [1.3, 3.6], [0.0265412, 0.00910913, 0.00184367]),
        (coated(Ggx, 0.0, true), [0.8, 1.0], [0.2, 4.0], [0.19333, 0.0663523, 0.0134296]),
        (coated(Ggx, 0.0, false), [0.3, 0.0], [0.35, 3.0], [0.242909, 0.121454, 0.0303636]),
        (coated(Ggx, 0.0, false), [1.0, 0.2], [0.6, 2.5], [0.204565, 0.102282, 0.0255706]),
        (coated(Ggx, 0.0, false), [1.4, 0.5], [1.3, 3.6], [0.0343986, 0.0171993, 0.00429982]),
        (coated(Ggx, 0.0, false), [0.8, 1.0], [0.2, 4.0], [0.250564, 0.125282, 0.0313205]),
        (principled(TILES), [0.3, 0.0], [0.35, 3.0], [0.838481, 0.425798, 0.116287]),
        (principled(TILES), [1.0, 0.2], [0.6, 2.5], [0.158649, 0.0804119, 0.0217338]),
        (principled(TILES), [1.4, 0.5], [1.3, 3.6], [2.46088, 1.73087, 1.18337]),
        (principled(TILES), [0.8, 1.0], [0.2, 4.0], [0.265726, 0.134615, 0.0362809]),
        (principled(ALL_LOBES), [0.3, 0.0], [0.35, 3.0], [1.97117, 1.12774, 0.495164]),
        (principled(ALL_LOBES), [1.0, 0.2], [0.6, 2.5], [0.178212, 0.09081, 0.0252583]),
        (principled(ALL_LOBES), [1.4, 0.5], [1.3, 3.6], [4.38878, 3.69752, 3.17907]),
        (principled(ALL_LOBES), [0.8, 1.0], [0.2, 4.0], [0.226705, 0.117231, 0.0351246]),
    ]
}

#[test]
fn smooth_lobes_have_the_values_of_mitsuba() {
    for (material, wo, wi, value) in values() {
        let (wo, wi, value) = (polar(wo[0], wo[1]), polar(wi[0], wi[1]), Rgb::from(value));
        let got = material.bsdf().eval(wo, wi);
        let off = ((got - value) / value).abs().max_element();
        // Mitsuba fits Beckmann's shadowing to 0.35 % and the diffuse reflectance of a smooth coat to 0.1 %
        let tolerance = match material.bsdf().kind() {
            BsdfKind::Plastic(_) => 2e-3,
            _ if material.name.contains("Beckmann") => 4e-3,
            _ => 1e-3,
        };
        assert!(off < tolerance, "{} {wo} {wi}: {got}, not {value}", material.name);
    }
}

/// Numbers from pictures are the numbers, wherever they come from.
#[test]
fn shares_from_pictures_are_shares() {
    let constant = principled(PrincipledParameters { metallic: 0.6, roughness: 0.45, specular: 0.3, ..ALL_LOBES });
    let textured = textured_principled(Rgb::new(0.6, 0.45, 0.3));
    for (wo, wi) in [(polar(0.4, 1.0), polar(0.7, 3.0)), (polar(1.2, 2.0), polar(0.1, 0.0))] {
        assert_eq!(textured.bsdf().eval_pdf(wo, wi), constant.bsdf().eval_pdf(wo, wi));
        assert_eq!(textured.bsdf().albedo(wo), constant.bsdf().albedo(wo));
    }
    // what no picture may say is brought into range
    let beyond = textured_principled(Rgb::new(7.0, -1.0, f32::INFINITY)).bsdf().albedo(Vec3::Z);
    assert!(beyond.is_finite());
}
