//! Reads the fields of BSDFs and lights from the keys of a table.

use super::textures::{color, share};
use super::world::{affine, unit};
use crate::document::{Bounds, COORDINATE, FINITE, Fault, Key, Reader};
use crate::fields::{Choice, FieldVisitor};
use crate::math::Rgb;
use crate::texture::{ColorTexture, ScalarTexture};
use glam::{Affine3A, DMat3, DVec3, Vec3, Vec3A};
use std::path::{Path, PathBuf};

/// Reads fields over what is in their slots. Paths are relative to the folder `base`.
pub(super) struct KeyReader<'a> {
    pub(crate) table: &'a mut Reader,
    pub(crate) base: &'a Path,
}

impl FieldVisitor for KeyReader<'_> {
    type Error = Fault;

    fn flag(&mut self, key: Key, slot: &mut bool) -> Result<(), Fault> {
        self.table.flag(key, slot)
    }

    fn number(&mut self, key: Key, bounds: Bounds, slot: &mut f32) -> Result<(), Fault> {
        self.table.number(key, bounds, slot)
    }

    fn share(&mut self, key: Key, number: &mut f32, map: &mut Option<ScalarTexture>) -> Result<(), Fault> {
        share(self.table, key, self.base, number, map)
    }

    fn color(&mut self, key: Key, bounds: Bounds, slot: &mut Rgb) -> Result<(), Fault> {
        self.table.color(key, bounds, slot)
    }

    fn choice<T: Choice>(&mut self, key: Key, slot: &mut T) -> Result<(), Fault> {
        self.table.choice(key, T::NAMES, slot)
    }

    fn texture(&mut self, key: Key, slot: &mut ColorTexture) -> Result<(), Fault> {
        color(self.table, key, self.base, slot)
    }

    fn color_pair(&mut self, [first, second]: [(Key, Bounds); 2], slot: &mut Option<(Rgb, Rgb)>) -> Result<(), Fault> {
        let t = &mut *self.table;
        let (mut a, mut b) = slot.unwrap_or_default();
        t.color(first.0, first.1, &mut a)?;
        t.color(second.0, second.1, &mut b)?;
        let names = [first.0.name, second.0.name];
        let given = names.map(|name| t.has(name));
        if slot.is_none() && given[0] != given[1] {
            let message = format!("`{}` and `{}` go together, but only one is given", names[0], names[1]);
            return Err(Fault::new(t.place(&names), message));
        }
        if given != [false; 2] {
            *slot = Some((a, b));
        }
        Ok(())
    }

    fn position(&mut self, key: Key, slot: &mut DVec3) -> Result<(), Fault> {
        self.table.point(key, COORDINATE, slot)
    }

    fn direction(&mut self, key: Key, slot: &mut Vec3) -> Result<(), Fault> {
        self.table.vector(key, COORDINATE, slot)?;
        // a direction that is missing is told at the end, with all that is
        if self.table.has(key.name) {
            *slot = unit(self.table, key.name, *slot)?;
        }
        Ok(())
    }

    fn orientation(&mut self, angle: Key, matrix: Key, slot: &mut Affine3A) -> Result<(), Fault> {
        let t = &mut *self.table;
        let mut degrees = 0.0;
        t.number(angle, FINITE, &mut degrees)?;
        if t.has(angle.name) {
            *slot = Affine3A::from_rotation_y(degrees.to_radians());
        }
        let Some(node) = t.ask(matrix, "16 numbers or 4 rows of 4", "", "rotation or reflection")? else {
            return Ok(());
        };
        if t.has(angle.name) {
            return Err(Fault::new(node.at, format!("`{}` and `{}` exclude each other", matrix.name, angle.name)));
        }
        *slot = affine(&node, matrix.name)?.as_affine3a();
        slot.translation = Vec3A::ZERO;
        if !keeps_lengths(slot) {
            let message = format!("`{}` must be a rotation, with or without a reflection", matrix.name);
            return Err(Fault::new(node.at, message));
        }
        Ok(())
    }

    fn picture(&mut self, key: Key, slot: &mut PathBuf) -> Result<(), Fault> {
        if let Some(path) = self.table.path(key, self.base)? {
            *slot = path;
        }
        Ok(())
    }

    fn check(&mut self, holds: bool, keys: &[&str], message: &str) -> Result<(), Fault> {
        if holds { Ok(()) } else { Err(Fault::new(self.table.place(keys), message)) }
    }
}

/// Whether a transform keeps lengths and angles.
fn keeps_lengths(transform: &Affine3A) -> bool {
    let m = transform.matrix3;
    let m = DMat3::from_cols_array_2d(&[m.x_axis, m.y_axis, m.z_axis].map(|c| Vec3::from(c).as_dvec3().to_array()));
    (m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-4)
}
