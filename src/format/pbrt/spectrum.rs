//! Colours: RGB, black bodies, and spectra by pairs, by name or in a file, which become linear sRGB.

use super::parameters::{Parameter, Parameters, Values};
use super::world::World;
use crate::Result;
use crate::document::read_text;
use crate::format::mitsuba::metals;
use crate::format::xml::color;
use crate::math::{Rgb, luminance};

/// What a colour is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    /// Even means white.
    Reflectance,
    /// Version 4 makes all light but RGB as bright as white of 1.
    Light,
}

/// Indices of refraction at 587.6 nm of glasses that version 4 names (Schott's data).
const GLASSES: &[(&str, f32)] = &[
    ("BK7", 1.5168),
    ("BAF10", 1.6700),
    ("FK51A", 1.4866),
    ("LASF9", 1.8503),
    ("SF5", 1.6727),
    ("F5", 1.6034),
    ("SF10", 1.7283),
    ("SF11", 1.7847),
];

/// Brass, of which Mitsuba has no data (Querry 1985), for linear sRGB.
const BRASS: (Rgb, Rgb) = (Rgb::new(0.444, 0.527, 1.094), Rgb::new(3.695, 2.765, 1.829));

impl World {
    /// The colour that a parameter says; `None` where there is none of this name, or it is the name of a texture.
    ///
    /// # Errors
    /// What is no colour; a negative one; a name or a file that is not there.
    pub(crate) fn color(&self, parameters: &Parameters, name: &str, role: Role) -> Result<Option<Rgb>> {
        match parameters.find(name) {
            Some(found) if found.kind != "texture" => self.color_of(parameters, found, role).map(Some),
            _ => Ok(None),
        }
    }

    fn color_of(&self, parameters: &Parameters, found: &Parameter, role: Role) -> Result<Rgb> {
        let fault = |what: &str| found.at.error(format!("`{}` of {} {what}", found.name, parameters.label()));
        let color = match (found.kind.as_str(), &found.values) {
            ("rgb" | "color", Values::Numbers(numbers)) => match numbers[..] {
                [r, g, b] => Rgb::new(r as f32, g as f32, b as f32),
                _ => return Err(fault("must be three numbers")),
            },
            ("float", Values::Numbers(numbers)) if numbers.len() == 1 => Rgb::splat(numbers[0] as f32),
            ("xyz", Values::Numbers(numbers)) => match numbers[..] {
                [x, y, z] => clipped(color::linear_srgb([x, y, z])),
                _ => return Err(fault("must be three numbers")),
            },
            ("blackbody", Values::Numbers(numbers)) => match numbers[..] {
                [kelvin] | [kelvin, _] if !(1.0..=1e6).contains(&kelvin) => {
                    return Err(fault("must be a temperature in kelvin"));
                }
                [kelvin] => self.light(clipped(color::seen(color::black_body(kelvin)))),
                [kelvin, scale] => self.light(clipped(color::seen(color::black_body(kelvin)))) * scale as f32,
                _ => return Err(fault("must be a temperature in kelvin")),
            },
            ("spectrum", Values::Numbers(numbers)) => {
                let pairs = color::pairs(numbers);
                let pairs =
                    pairs.ok_or_else(|| fault("must be pairs of a wavelength in nm and a number, in their order"))?;
                self.of_pairs(&pairs, role)
            }
            ("spectrum", Values::Texts(names)) if names.len() == 1 => match named(&names[0]) {
                Some(known) => known,
                None => {
                    let unknown = || fault(&format!("is \"{}\", which no spectrum here is called", names[0]));
                    let path = self.file(&names[0]);
                    if !path.is_file() && !names[0].contains(['.', '/']) {
                        return Err(unknown());
                    }
                    let numbers = color::uncommented(&read_text(&path)?).and_then(|numbers| color::pairs(&numbers));
                    let pairs =
                        numbers.ok_or_else(|| fault("must name a file of pairs of a wavelength in nm and a number"))?;
                    self.of_pairs(&pairs, role)
                }
            },
            _ => return Err(fault("must be a colour or a spectrum")),
        };
        if color.min_element() < 0.0 {
            return Err(fault("must be 0 or more"));
        }
        Ok(color)
    }

    /// Light as bright as this, or, in version 4, as white of 1.
    fn light(&self, seen: Rgb) -> Rgb {
        if self.old { seen } else { seen / luminance(seen).max(f32::MIN_POSITIVE) }
    }

    fn of_pairs(&self, pairs: &[[f64; 2]], role: Role) -> Rgb {
        match role {
            Role::Reflectance => color::from_pairs(pairs),
            Role::Light => self.light(clipped(color::seen(|wavelength| color::at(pairs, wavelength)))),
        }
    }
}

fn clipped(color: [f64; 3]) -> Rgb {
    Rgb::from(color.map(|x| x.max(0.0) as f32))
}

/// A spectrum that version 4 knows by name.
fn named(name: &str) -> Option<Rgb> {
    if let Some(glass) = name.strip_prefix("glass-") {
        return GLASSES.iter().find(|(known, _)| *known == glass).map(|(_, index)| Rgb::splat(*index));
    }
    if name.starts_with("stdillum-") || name.starts_with("illum-") {
        return Some(Rgb::ONE);
    }
    let name = name.strip_prefix("metal-")?;
    let of = |metal: &str| if metal == "CuZn" { Some(BRASS) } else { metals::known(metal) };
    match name.strip_suffix("-eta") {
        Some(metal) => of(metal).map(|(eta, _)| eta),
        None => of(name.strip_suffix("-k")?).map(|(_, k)| k),
    }
}
