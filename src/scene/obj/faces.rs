//! Third pass: faces into triangles, straight into their places.

use super::attributes::changed;
use super::lines::{self, Fields, Lines};
use super::scan::Counts;
use super::source::Fault;
use crate::geometry::mesh::ABSENT;
use crate::scene::triangulate::{self, LARGEST_CONCAVE};

/// The parts of the mesh's index arrays that a block fills. Those of an attribute the file has none of are empty.
///
/// Attributes' arrays come filled with zeros and take how indices differ (by bits) from those of the positions. Where
/// they do not, nothing is written: the system gives memory to pages that are written, and most files have the same
/// indices throughout.
pub(super) struct Slots<'a> {
    pub(crate) triangles: &'a mut [[u32; 3]],
    pub(crate) uvs: &'a mut [[u32; 3]],
    pub(crate) normals: &'a mut [[u32; 3]],
    /// Vertices before the block.
    pub(crate) before: Counts,
}

/// A face's corner: indices from 0, or [`ABSENT`].
#[derive(Clone, Copy)]
struct Corner {
    position: u32,
    uv: u32,
    normal: u32,
}

/// What faces may refer to, and scratch memory for one of them.
struct Reader<'a> {
    positions: &'a [[f32; 3]],
    totals: Counts,
    /// Vertices so far, which relative indices count back from.
    so_far: Counts,
    slots: Slots<'a>,
    /// Triangles written so far.
    next: usize,
    /// Whether any index of texture coordinates, of normals, differs from that of its position.
    differ: [bool; 2],
    corners: Vec<Corner>,
    points: Vec<[f32; 3]>,
    pieces: Vec<[usize; 3]>,
}

/// Reads the `f` statements of a block. `positions` are those of the whole file, `totals` counts them. Returns whether
/// indices of texture coordinates, and of normals, differ anywhere from those of positions.
pub(super) fn read(slots: Slots, positions: &[[f32; 3]], totals: Counts, text: &[u8]) -> Result<[bool; 2], Fault> {
    let (corners, points, pieces) = Default::default();
    let so_far = slots.before;
    let mut reader = Reader { positions, totals, so_far, slots, next: 0, differ: [false; 2], corners, points, pieces };
    for (at, line) in Lines::new(text) {
        let (keyword, _) = lines::keyword(line);
        match keyword {
            b"v" => reader.so_far.positions += 1,
            b"vt" => reader.so_far.uvs += 1,
            b"vn" => reader.so_far.normals += 1,
            b"f" => reader.face(&mut Fields::new(line, 1)).map_err(|fault| fault.shifted(at as u64))?,
            _ => {}
        }
    }
    if reader.next == reader.slots.triangles.len() { Ok(reader.differ) } else { Err(changed(text.len())) }
}

impl Reader<'_> {
    #[inline]
    fn face(&mut self, fields: &mut Fields) -> Result<(), Fault> {
        self.corners.clear();
        while let Some(corner) = self.corner(fields)? {
            self.corners.push(corner);
        }
        match self.corners[..] {
            [] | [_] | [_, _] => Ok(()),
            [a, b, c] => self.triangle([a, b, c]),
            _ => self.polygon(),
        }
    }

    fn polygon(&mut self) -> Result<(), Fault> {
        self.points.clear();
        self.points.extend(self.corners.iter().map(|c| self.positions[c.position as usize]));
        self.pieces.clear();
        if !triangulate::triangulate(&self.points, &mut self.pieces) {
            let corners = self.corners.len();
            let message = format!("a concave face of {corners} corners (at most {LARGEST_CONCAVE})");
            return Err(Fault::new(0, message));
        }
        for i in 0..self.pieces.len() {
            self.triangle(self.pieces[i].map(|k| self.corners[k]))?;
        }
        Ok(())
    }

    #[inline]
    fn triangle(&mut self, corners: [Corner; 3]) -> Result<(), Fault> {
        let slot = self.slots.triangles.get_mut(self.next).ok_or_else(|| changed(0))?;
        let positions = corners.map(|c| c.position);
        *slot = positions;
        if let Some(slot) = self.slots.uvs.get_mut(self.next) {
            self.differ[0] |= differs(slot, complete(corners.map(|c| c.uv)), positions);
        }
        if let Some(slot) = self.slots.normals.get_mut(self.next) {
            self.differ[1] |= differs(slot, complete(corners.map(|c| c.normal)), positions);
        }
        self.next += 1;
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`, where vt and vn may be left out.
    #[inline]
    fn corner(&self, fields: &mut Fields) -> Result<Option<Corner>, Fault> {
        let rest = fields.rest();
        if rest.is_empty() {
            return Ok(None);
        }
        let mut token = Token { text: rest, at: 0 };
        let corner = self.token(&mut token).map_err(|message| Fault::new(fields.at, message))?;
        fields.at += token.at;
        Ok(Some(corner))
    }

    #[inline]
    fn token(&self, token: &mut Token) -> Result<Corner, String> {
        let (totals, so_far) = (&self.totals, &self.so_far);
        let index = token.index().ok_or_else(|| token.garbage())?;
        let position = resolve(index, totals.positions, so_far.positions, "vertex")?;
        let mut corner = Corner { position, uv: ABSENT, normal: ABSENT };
        if token.slash()
            && let Some(index) = token.index()
        {
            corner.uv = resolve(index, totals.uvs, so_far.uvs, "texture coordinate")?;
        }
        if token.slash()
            && let Some(index) = token.index()
        {
            corner.normal = resolve(index, totals.normals, so_far.normals, "normal")?;
        }
        if token.ended() { Ok(corner) } else { Err(token.garbage()) }
    }
}

/// Stores how `indices` differ from `positions`, if they do.
#[inline]
fn differs(slot: &mut [u32; 3], indices: [u32; 3], positions: [u32; 3]) -> bool {
    let differ = indices != positions;
    if differ {
        *slot = [0, 1, 2].map(|k| indices[k] ^ positions[k]);
    }
    differ
}

/// A triangle has an attribute only if all its corners do.
#[inline]
fn complete(indices: [u32; 3]) -> [u32; 3] {
    if indices.contains(&ABSENT) { [ABSENT; 3] } else { indices }
}

/// An index as written, from 1, or back from the last vertex so far if negative, to one from 0.
#[inline]
fn resolve(index: i64, total: usize, so_far: usize, what: &str) -> Result<u32, String> {
    let resolved = if index > 0 { index - 1 } else { so_far as i64 + index };
    if index != 0 && (0..total as i64).contains(&resolved) {
        return Ok(resolved as u32);
    }
    Err(out_of_range(index, total, so_far, what))
}

#[cold]
fn out_of_range(index: i64, total: usize, so_far: usize, what: &str) -> String {
    match index {
        0 => format!("{what} index 0: OBJ counts from 1"),
        1.. => format!("{what} index {index} is out of range: the file has {total}"),
        _ => format!("{what} index {index} is out of range: there are {so_far} before this line"),
    }
}

/// A corner's text, which ends at a blank, a comment or the line's end.
struct Token<'a> {
    text: &'a [u8],
    at: usize,
}

impl Token<'_> {
    /// An integer, if one begins here; beyond 18 digits it saturates, being out of range anyway.
    #[inline]
    fn index(&mut self) -> Option<i64> {
        let mut at = self.at;
        let sign = self.text.get(at).copied();
        at += usize::from(matches!(sign, Some(b'-' | b'+')));
        let digits = at;
        let mut value = 0i64;
        while let Some(digit) = self.text.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            value = value.wrapping_mul(10).wrapping_add(i64::from(digit));
            at += 1;
        }
        if at == digits {
            return None;
        }
        if at - digits > 18 {
            value = i64::MAX;
        }
        self.at = at;
        Some(if sign == Some(b'-') { -value } else { value })
    }

    #[inline]
    fn slash(&mut self) -> bool {
        let slash = self.text.get(self.at) == Some(&b'/');
        self.at += usize::from(slash);
        slash
    }

    #[inline]
    fn ended(&self) -> bool {
        self.text.get(self.at).is_none_or(|&b| lines::is_blank(b) || b == b'#')
    }

    #[cold]
    fn garbage(&self) -> String {
        let token = &self.text[..lines::token_length(self.text)];
        format!("`{}` is not a face corner (v, v/vt, v//vn or v/vt/vn)", lines::excerpt(token))
    }
}
