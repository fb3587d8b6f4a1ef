//! Steps of the transform that holds for what follows.

use super::{World, string};
use crate::Result;
use crate::error::SourceLocation;
use crate::format::pbrt::parameters::number;
use crate::format::pbrt::tokens::{Token, Tokens};
use crate::format::xml::transform;
use glam::{DAffine3, DVec3};

impl World {
    /// Whether the directive is a step of the transform.
    pub(super) fn transform(&mut self, tokens: &mut Tokens, token: &Token) -> Result<bool> {
        let at = tokens.place(token);
        let old = self.state.transform;
        let next = match &*token.text {
            "Identity" => DAffine3::IDENTITY,
            "Translate" => old * DAffine3::from_translation(numbers(tokens)?.into()),
            "Scale" => old * DAffine3::from_scale(numbers(tokens)?.into()),
            "Rotate" => {
                let [angle, x, y, z] = numbers(tokens)?;
                let turned = transform::rotation(DVec3::new(x, y, z), angle);
                old * turned.ok_or_else(|| at.error("the axis of a rotation is not zero"))?
            }
            "LookAt" => {
                let [ex, ey, ez, lx, ly, lz, ux, uy, uz] = numbers(tokens)?;
                let (eye, look, up) = (DVec3::new(ex, ey, ez), DVec3::new(lx, ly, lz), DVec3::new(ux, uy, uz));
                let frame = transform::look_at(eye, look, Some(up)).filter(|_| up != DVec3::ZERO);
                old * frame.ok_or_else(|| at.error("these three span no view"))?.inverse()
            }
            "Transform" => matrix(tokens, &at)?,
            "ConcatTransform" => old * matrix(tokens, &at)?,
            "CoordinateSystem" => {
                let name = string(tokens, "a name")?;
                self.coordinate_systems.insert(name, old);
                old
            }
            "CoordSysTransform" => {
                let name = string(tokens, "a name")?;
                let found = self.coordinate_systems.get(&name);
                *found.ok_or_else(|| at.error(format!("there is no coordinate system \"{name}\"")))?
            }
            "TransformTimes" => {
                numbers::<2>(tokens)?;
                old
            }
            "ActiveTransform" => {
                let which = tokens.needed("StartTime, EndTime or All")?;
                self.state.at_end = match &*which.text {
                    "StartTime" | "All" => false,
                    "EndTime" => true,
                    other => {
                        return Err(tokens.place(&which).error(format!("`{other}` is not StartTime, EndTime or All")));
                    }
                };
                if self.state.at_end {
                    self.warnings.add(&at, "nothing moves here: all is where it is in the beginning");
                }
                old
            }
            _ => return Ok(false),
        };
        if !next.is_finite() {
            return Err(at.error("the transform is no longer finite"));
        }
        if !self.state.at_end {
            self.state.transform = next;
        }
        Ok(true)
    }
}

fn numbers<const N: usize>(tokens: &mut Tokens) -> Result<[f64; N]> {
    let mut found = [0.0; N];
    for slot in &mut found {
        let token = tokens.needed("a number")?;
        let wrong = || tokens.place(&token).error(format!("`{}` is not a number", token.text));
        *slot = number(&token.text).filter(|_| !token.quoted).ok_or_else(wrong)?;
    }
    Ok(found)
}

/// 16 numbers in brackets, column by column.
fn matrix(tokens: &mut Tokens, at: &SourceLocation) -> Result<DAffine3> {
    let bracket = |tokens: &mut Tokens, wanted: &str| -> Result<()> {
        let token = tokens.needed(wanted)?;
        let fits = !token.quoted && token.text == wanted;
        fits.then_some(()).ok_or_else(|| tokens.place(&token).error(format!("`{wanted}` belongs here")))
    };
    bracket(tokens, "[")?;
    let m: [f64; 16] = numbers(tokens)?;
    bracket(tokens, "]")?;
    let rows: Vec<f64> = (0..16).map(|k| m[k % 4 * 4 + k / 4]).collect();
    transform::matrix(&rows).ok_or_else(|| at.error("the last row of a transform is 0 0 0 1"))
}
