//! How stored values become linear light.
//!
//! A PNG says it in chunks, which rank so (PNG specification, third edition, 4.3): `cICP`, `iCCP`, `sRGB`, `gAMA` with `cHRM`. Other
//! formats have an ICC profile or nothing. Without a word a picture is sRGB, with 16 bits as with 8.

use crate::image::srgb;
use crate::io::contain::contain;
use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve, Xyzd};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

/// The curve from stored values to light, both in [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Transfer {
    Srgb,
    Linear,
    /// Light is the stored value to this power.
    Power(f32),
    /// Light at 65536 stored values.
    Table(Arc<[f32]>),
}

/// Exponents that differ by less than this are the same: a step of the colours of 8 bits at mid grey is larger.
const SAME_POWER: f32 = 0.02;

/// What programs write of sRGB in `gAMA`: 0.45455.
const SRGB_POWER: f32 = 2.2;

/// Light that differs by less than this is the same: half a step of 8 bits.
const SAME_LIGHT: f32 = 0.5 / 255.0;

/// x and y of red, green, blue and white in sRGB.
const SRGB_CHROMATICITIES: [f32; 8] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];

/// X, Y and Z of red, green and blue of sRGB, adapted to D50 as profiles have them (its profile by the ICC).
const SRGB_COLORANTS: [[f64; 3]; 3] = [[0.4360, 0.2225, 0.0139], [0.3851, 0.7169, 0.0971], [0.1431, 0.0606, 0.7141]];

const OTHER_PRIMARIES: &str = "its colours have other primaries than sRGB, and are shown as if they were sRGB's";

impl Transfer {
    fn decode(&self, index: usize, count: usize) -> f32 {
        let stored = index as f32 / (count - 1) as f32;
        match self {
            Transfer::Srgb => srgb::decode(stored),
            Transfer::Linear => stored,
            Transfer::Power(power) => stored.powf(*power),
            Transfer::Table(table) => table[index * (table.len() - 1) / (count - 1)],
        }
    }

    pub(super) fn table_8(&self) -> Arc<[f32; 256]> {
        match self {
            Transfer::Srgb => srgb::DECODE_8.clone(),
            other => Arc::new(std::array::from_fn(|i| other.decode(i, 256))),
        }
    }

    pub(super) fn table_16(&self) -> Arc<[f32]> {
        match self {
            Transfer::Srgb => srgb::DECODE_16.clone(),
            other => (0..1 << 16).map(|i| other.decode(i, 1 << 16)).collect(),
        }
    }

    fn power(power: f32) -> Transfer {
        let near = |other: f32| (power - other).abs() < SAME_POWER;
        match power {
            _ if near(1.0) => Transfer::Linear,
            // by the manual of libpng, 0.45455 stands for the curve of sRGB
            _ if near(SRGB_POWER) => Transfer::Srgb,
            power => Transfer::Power(power),
        }
    }
}

/// What the chunks of a PNG say; `None` where an ICC profile or nothing does.
pub(super) fn of_png(path: &Path, notes: &mut Vec<String>) -> Option<Transfer> {
    let header = |file| {
        let mut decoder = png::Decoder::new(BufReader::new(file));
        // a damaged text is no reason to know nothing of the colours
        decoder.set_ignore_text_chunk(true);
        decoder.read_info().ok().map(|reader| of_png_header(reader.info(), notes))
    };
    contain(path, || Ok(File::open(path).ok().and_then(header))).ok().flatten().flatten()
}

fn of_png_header(info: &png::Info, notes: &mut Vec<String>) -> Option<Transfer> {
    if let Some(points) = &info.coding_independent_code_points {
        if points.color_primaries != 1 {
            notes.push(OTHER_PRIMARIES.into());
        }
        match points.transfer_function {
            8 => return Some(Transfer::Linear),
            13 => return Some(Transfer::Srgb),
            4 => return Some(Transfer::power(2.2)),
            other => notes.push(format!("its transfer function {other} (cICP) is not known; it is read as sRGB")),
        }
        return Some(Transfer::Srgb);
    }
    if info.icc_profile.is_some() {
        return None;
    }
    if info.srgb.is_some() {
        return Some(Transfer::Srgb);
    }
    if info.chrm_chunk.is_some_and(|found| !are_of_srgb(&found)) {
        notes.push(OTHER_PRIMARIES.into());
    }
    let gamma = info.gama_chunk?.into_value();
    // beyond a factor of ten nobody means it
    if !(0.1..=10.0).contains(&gamma) {
        notes.push(format!("a gamma of {gamma} (gAMA) means nothing; it is read as sRGB"));
        return Some(Transfer::Srgb);
    }
    Some(Transfer::power(1.0 / gamma))
}

fn are_of_srgb(found: &png::SourceChromaticities) -> bool {
    let (x, y): (Vec<_>, Vec<_>) = [found.red, found.green, found.blue, found.white].into_iter().unzip();
    let found = x.iter().zip(&y).flat_map(|(x, y)| [x.into_value(), y.into_value()]);
    found.zip(SRGB_CHROMATICITIES).all(|(found, srgb)| (found - srgb).abs() < 0.01)
}

/// What an ICC profile says, if it is one of a curve for all channels; else `None`, with a note.
pub(super) fn of_profile(bytes: &[u8], notes: &mut Vec<String>) -> Option<Transfer> {
    let transfer = ColorProfile::new_from_slice(bytes).ok().and_then(|profile| {
        let curve = one_curve(&profile)?;
        if profile.color_space == DataColorSpace::Rgb && !has_srgb_primaries(&profile) {
            notes.push(OTHER_PRIMARIES.into());
        }
        of_curve(curve)
    });
    if transfer.is_none() {
        notes.push("its colour profile cannot be used; it is read as sRGB".into());
    }
    transfer
}

/// The curve of all channels. Profiles of tables (`A2B0`) have none.
fn one_curve(profile: &ColorProfile) -> Option<&ToneReprCurve> {
    let curves = [&profile.red_trc, &profile.green_trc, &profile.blue_trc].map(Option::as_ref);
    match profile.color_space {
        DataColorSpace::Gray => profile.gray_trc.as_ref(),
        DataColorSpace::Rgb if curves[0] == curves[1] && curves[1] == curves[2] => curves[0],
        _ => None,
    }
}

fn has_srgb_primaries(profile: &ColorProfile) -> bool {
    let found = [profile.red_colorant, profile.green_colorant, profile.blue_colorant];
    let near = |(found, srgb): (Xyzd, [f64; 3])| {
        [found.x, found.y, found.z].into_iter().zip(srgb).all(|(found, srgb)| (found - srgb).abs() < 0.01)
    };
    found.into_iter().zip(SRGB_COLORANTS).all(near)
}

fn of_curve(curve: &ToneReprCurve) -> Option<Transfer> {
    let evaluator = curve.make_linear_evaluator().ok()?;
    let table: Arc<[f32]> =
        (0..1 << 16).map(|i| evaluator.evaluate_value(i as f32 / 65535.0).clamp(0.0, 1.0)).collect();
    if table.iter().any(|light| !light.is_finite()) {
        return None;
    }
    let same = |known: Transfer| {
        let far = (0..1 << 16).any(|i| (known.decode(i, 1 << 16) - table[i]).abs() > SAME_LIGHT);
        (!far).then_some(known)
    };
    Some(same(Transfer::Srgb).or_else(|| same(Transfer::Linear)).unwrap_or(Transfer::Table(table)))
}
