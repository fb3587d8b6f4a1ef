//! Normals from pictures.

use super::description::{ReliefKind, ReliefTexture};
use super::{Texture, TextureCache, TextureMap};
use crate::Result;
use crate::math::{Frame, Rgb};
use glam::{DVec3, Vec3};

/// A resolved [`ReliefTexture`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relief {
    map: TextureMap,
    kind: ReliefKind,
    strength: f32,
}

/// How a point moves with its texture coordinates, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tangents {
    pub(crate) along_u: DVec3,
    pub(crate) along_v: DVec3,
}

impl Tangents {
    /// Of a triangle with these corners and texture coordinates; `None` where the coordinates have no area.
    pub(crate) fn of(corners: [Vec3; 3], uvs: [[f32; 2]; 3]) -> Option<Tangents> {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let [ua, ub, uc] = uvs.map(|[u, v]| glam::DVec2::new(u.into(), v.into()));
        let (e, f, s, t) = (b - a, c - a, ub - ua, uc - ua);
        let area = s.perp_dot(t);
        let tangents = Tangents { along_u: (e * t.y - f * s.y) / area, along_v: (f * s.x - e * t.x) / area };
        (tangents.along_u.is_finite() && tangents.along_v.is_finite()).then_some(tangents)
    }

    /// Along the coordinates of a picture that is scaled.
    fn scaled(self, [u, v]: [f32; 2]) -> Option<Tangents> {
        let scaled = Tangents { along_u: self.along_u / f64::from(u), along_v: self.along_v / f64::from(v) };
        (scaled.along_u.is_finite() && scaled.along_v.is_finite()).then_some(scaled)
    }
}

impl Relief {
    /// # Errors
    /// As of [`TextureCache::get`].
    pub(crate) fn new(texture: &ReliefTexture, cache: &mut TextureCache) -> Result<Relief> {
        let map = cache.resolve(&texture.image)?;
        let kind = match texture.kind {
            ReliefKind::NormalsOrTexelHeights if cache.textures()[map.index].looks_like_normals() => {
                ReliefKind::Normals
            }
            ReliefKind::NormalsOrTexelHeights => ReliefKind::TexelHeights,
            known => known,
        };
        Ok(Relief { map, kind, strength: texture.strength })
    }

    /// The unit normal at the surface's `uv`, in the shading frame and on its upper side.
    pub(crate) fn normal(&self, textures: &[Texture], uv: [f32; 2], frame: &Frame, tangents: Tangents) -> Vec3 {
        // what points along the picture's coordinates, mirrored ones too
        let Some(tangents) = tangents.scaled(self.map.scale) else { return Vec3::Z };
        let n = frame.n.as_dvec3();
        let turned = match self.kind {
            ReliefKind::Heights => self.slope(textures, uv, n, tangents),
            _ => self.tilt(textures, uv, n, tangents),
        };
        let local = turned.map(|w| frame.to_local(w.as_vec3())).unwrap_or(Vec3::Z);
        Vec3::new(local.x, local.y, local.z.max(0.0)).normalize_or(Vec3::Z)
    }

    /// A normal in the orthonormal frame of the coordinates: u's direction is kept, and v's side.
    fn tilt(&self, textures: &[Texture], uv: [f32; 2], n: DVec3, tangents: Tangents) -> Option<DVec3> {
        let t = (tangents.along_u - n * n.dot(tangents.along_u)).try_normalize()?;
        let across = n.cross(t);
        let b = across * across.dot(tangents.along_v).signum();
        let m = match self.kind {
            ReliefKind::Normals | ReliefKind::NormalsDown => {
                let m = self.map.stored_color(textures, uv) * 2.0 - Rgb::ONE;
                let up = if self.kind == ReliefKind::Normals { m.y } else { -m.y };
                Vec3::new(m.x * self.strength, up * self.strength, m.z.max(0.0))
            }
            _ => {
                let [x, y] = self.map.steps(textures, uv);
                Vec3::new(-x * self.strength, -y * self.strength, 1.0)
            }
        };
        (t * f64::from(m.x) + b * f64::from(m.y) + n * f64::from(m.z)).try_normalize()
    }

    /// The normal of a surface that is moved along its normal (Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the GPU").
    fn slope(&self, textures: &[Texture], uv: [f32; 2], n: DVec3, tangents: Tangents) -> Option<DVec3> {
        let [x, y] = self.map.steps(textures, uv);
        let [width, height] = textures[self.map.index].size();
        let per_u = f64::from(self.strength * x) * width as f64;
        let per_v = f64::from(self.strength * y) * height as f64;
        let (r1, r2) = (tangents.along_v.cross(n), n.cross(tangents.along_u));
        let determinant = tangents.along_u.dot(r1);
        (n - (r1 * per_u + r2 * per_v) / determinant).try_normalize()
    }
}

/// Normals are about as long as 1.
const LENGTH: f32 = 0.15;

/// Channels of a grey picture differ by less than this, in mean: compression and dithering included.
const GREY: f32 = 0.02;

impl Texture {
    /// Whether the picture is one of normals, and not of heights: coloured, with vectors as long as 1.
    fn looks_like_normals(&self) -> bool {
        let texels = &self.texels;
        let (mut off, mut colour, mut count) = (0.0, 0.0, 0.0);
        // a picture tells by a part of its rows and columns
        let step = |side: usize| side.div_ceil(64);
        for y in (0..texels.height).step_by(step(texels.height)) {
            for x in (0..texels.width).step_by(step(texels.width)) {
                let stored = texels.stored_color(x, y);
                off += ((stored * 2.0 - Rgb::ONE).length() - 1.0).abs();
                colour += stored.max_element() - stored.min_element();
                count += 1.0;
            }
        }
        colour / count > GREY && off / count < LENGTH
    }
}

#[cfg(test)]
#[path = "relief_tests.rs"]
mod tests;
