//! OBJ text that goes to the file as it is made: nothing is kept but the number of vertices.

use glam::DVec3;
use std::io::{self, Write};

/// Decimals of all numbers: a tenth of a millimetre.
const UNIT: f64 = 10_000.0;

/// An OBJ file under way. Every vertex has texture coordinates, and all vertices have normals or none has.
pub(crate) struct ObjStream<'a> {
    out: &'a mut dyn Write,
    line: Vec<u8>,
    vertices: u64,
    normals: bool,
    material: &'static str,
}

impl<'a> ObjStream<'a> {
    /// Begins the file of the scene `scene` with the library `library`.
    pub(crate) fn new(out: &'a mut dyn Write, scene: &str, library: &str) -> io::Result<ObjStream<'a>> {
        writeln!(out, "# Made by phototaxis generate {scene}. CC0 1.0.\nmtllib {library}")?;
        Ok(ObjStream { out, line: Vec::with_capacity(128), vertices: 0, normals: false, material: "" })
    }

    /// A vertex without a normal; returns its index, from 1.
    pub(crate) fn vertex(&mut self, p: DVec3, uv: [f64; 2]) -> io::Result<u64> {
        self.statement("v", &p.to_array());
        self.statement("vt", &uv);
        self.vertices += 1;
        self.flush()?;
        Ok(self.vertices)
    }

    /// A vertex with a unit normal; returns its index, from 1.
    pub(crate) fn smooth_vertex(&mut self, p: DVec3, uv: [f64; 2], n: DVec3) -> io::Result<u64> {
        self.normals = true;
        self.statement("vn", &n.to_array());
        self.vertex(p, uv)
    }

    /// What the triangles from here on are made of.
    pub(crate) fn material(&mut self, name: &'static str) -> io::Result<()> {
        if self.material == name {
            return Ok(());
        }
        self.material = name;
        writeln!(self.out, "usemtl {name}")
    }

    /// A triangle of vertices, counter-clockwise seen from its front.
    pub(crate) fn triangle(&mut self, corners: [u64; 3]) -> io::Result<()> {
        self.line.push(b'f');
        for index in corners {
            for k in 0..if self.normals { 3 } else { 2 } {
                self.line.push(if k == 0 { b' ' } else { b'/' });
                push_integer(&mut self.line, index);
            }
        }
        self.line.push(b'\n');
        self.flush()
    }

    /// A flat quadrilateral, counter-clockwise seen from its front; texture coordinates measure it in its own unit from
    /// its first corner.
    pub(crate) fn quad(&mut self, corners: [DVec3; 4]) -> io::Result<()> {
        let (width, height) = ((corners[1] - corners[0]).length(), (corners[3] - corners[0]).length());
        let uvs = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        let mut first = 0;
        for (k, uv) in uvs.into_iter().enumerate() {
            let index = self.vertex(corners[k], uv)?;
            first = if k == 0 { index } else { first };
        }
        self.triangle([first, first + 1, first + 2])?;
        self.triangle([first, first + 2, first + 3])
    }

    fn statement(&mut self, keyword: &str, numbers: &[f64]) {
        self.line.extend_from_slice(keyword.as_bytes());
        for &number in numbers {
            self.line.push(b' ');
            push_decimal(&mut self.line, number);
        }
        self.line.push(b'\n');
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.write_all(&self.line)?;
        self.line.clear();
        Ok(())
    }
}

/// A number with four decimals, which is much faster than formatting it.
fn push_decimal(line: &mut Vec<u8>, x: f64) {
    let units = (x * UNIT).round() as i64;
    if units < 0 {
        line.push(b'-');
    }
    let (whole, mut rest) = (units.unsigned_abs() / UNIT as u64, units.unsigned_abs() % UNIT as u64);
    push_integer(line, whole);
    line.push(b'.');
    for place in [1000, 100, 10, 1] {
        line.push(b'0' + (rest / place) as u8);
        rest %= place;
    }
}

fn push_integer(line: &mut Vec<u8>, mut value: u64) {
    let mut digits = [0; 20];
    let mut first = digits.len();
    loop {
        first -= 1;
        digits[first] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    line.extend_from_slice(&digits[first..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_formatting_writes_them() {
        for x in [0.0, -0.00004, 1.0, -1.5, 12.34565, -1234.9999, 99_999.5, 1e-4] {
            let mut line = Vec::new();
            push_decimal(&mut line, x);
            let written: f64 = String::from_utf8(line).unwrap().parse().unwrap();
            assert!((written - x).abs() <= 0.500_001 / UNIT, "{x}: {written}");
        }
        for n in [0, 9, 10, 1_234_567_890, u64::MAX] {
            let mut line = Vec::new();
            push_integer(&mut line, n);
            assert_eq!(line, n.to_string().into_bytes());
        }
    }
}
