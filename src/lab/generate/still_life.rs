//! What stands on the table of the door scene. Each object stands on y = 0 about the y axis.

use super::shape::Shape;
use super::shapes::{displaced_sphere, revolve, spline, tube};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

const SEGMENTS: u32 = 48;

/// A pot with lid, handle (towards −x) and spout (towards +x): one closed body and two tubes that end inside it.
pub(crate) fn teapot(material: &'static str) -> Shape {
    let body = [
        (0.0, 0.0),
        (0.07, 0.0),
        (0.078, 0.006),
        (0.112, 0.04),
        (0.128, 0.085),
        (0.113, 0.13),
        (0.079, 0.154),
        (0.077, 0.16),
        (0.082, 0.163),
        (0.078, 0.168),
        (0.052, 0.181),
        (0.02, 0.188),
        (0.011, 0.193),
        (0.013, 0.202),
        (0.019, 0.21),
        (0.013, 0.219),
        (0.0, 0.222),
    ];
    let handle = [
        (-0.095, 0.138, 0.008),
        (-0.15, 0.153, 0.0095),
        (-0.2, 0.138, 0.011),
        (-0.212, 0.098, 0.011),
        (-0.182, 0.06, 0.01),
        (-0.11, 0.046, 0.008),
    ];
    let spout = [
        (0.09, 0.055, 0.034),
        (0.142, 0.075, 0.025),
        (0.17, 0.115, 0.018),
        (0.19, 0.155, 0.0145),
        (0.222, 0.182, 0.0135),
    ];
    revolve(&spline(&body.map(DVec2::from), 3), SEGMENTS, material)
        .with(tube(&spline(&handle.map(DVec3::from), 5), 0.0, 14, material))
        .with(tube(&spline(&spout.map(DVec3::from), 5), 0.02, 18, material))
}

/// A thick-walled vase: one closed surface, up the outside and down the inside. It stands half a millimetre high, so
/// that glass and table never coincide.
pub(crate) fn vase(material: &'static str) -> Shape {
    let profile = [
        (0.0, 0.0005),
        (0.05, 0.0005),
        (0.06, 0.006),
        (0.078, 0.05),
        (0.086, 0.1),
        (0.07, 0.165),
        (0.04, 0.225),
        (0.036, 0.265),
        (0.052, 0.305),
        (0.0515, 0.3095),
        (0.047, 0.3075),
        (0.0305, 0.266),
        (0.034, 0.226),
        (0.063, 0.165),
        (0.077, 0.1),
        (0.068, 0.055),
        (0.045, 0.033),
        (0.0, 0.028),
    ];
    revolve(&spline(&profile.map(DVec2::from), 3), SEGMENTS, material)
}

/// A warty pumpkin: a flattened sphere with ribs, hollows at its poles and bumps all over.
pub(crate) fn pumpkin(skin: &'static str, stem: &'static str) -> Shape {
    let bumps = sunflower(140);
    let radius = |d: DVec3| {
        let ribs = (5.0 * d.z.atan2(d.x)).cos().abs().powf(0.7);
        let equator = 1.0 - d.y * d.y;
        let hollow = (-equator / 0.06).exp();
        let wart: f64 = bumps.iter().map(|b| ((d.dot(*b) - 1.0) / 0.0022).exp()).sum();
        0.125 * (0.88 + 0.12 * ribs * equator - 0.28 * hollow + 0.035 * wart * equator)
    };
    let flatten =
        DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 0.8, 1.0), glam::DQuat::IDENTITY, DVec3::Y * 0.084);
    let stalk = [(0.0, 0.12, 0.02), (0.002, 0.15, 0.012), (0.012, 0.175, 0.01), (0.03, 0.188, 0.012)];
    displaced_sphere(18, skin, radius).transformed(&flatten).with(tube(
        &spline(&stalk.map(DVec3::from), 4),
        0.004,
        12,
        stem,
    ))
}

/// `count` unit vectors spread evenly along a spiral (Fibonacci lattice).
fn sunflower(count: u32) -> Vec<DVec3> {
    let golden = PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|i| {
            let y = 1.0 - (2 * i + 1) as f64 / count as f64;
            let (sin, cos) = (golden * i as f64 % TAU).sin_cos();
            let r = (1.0 - y * y).sqrt();
            DVec3::new(r * cos, y, r * sin)
        })
        .collect()
}

/// A door knob on a plate, along +y.
pub(crate) fn knob(material: &'static str) -> Shape {
    let profile = [
        (0.0, -0.004),
        (0.026, -0.004),
        (0.027, 0.004),
        (0.012, 0.008),
        (0.009, 0.02),
        (0.012, 0.032),
        (0.025, 0.043),
        (0.026, 0.054),
        (0.016, 0.064),
        (0.0, 0.066),
    ];
    revolve(&spline(&profile.map(DVec2::from), 2), 24, material)
}
