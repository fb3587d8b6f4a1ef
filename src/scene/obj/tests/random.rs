//! Random files: legal ones load to what they were made from, others do not panic.

use super::{load_text, triples};
use crate::geometry::mesh::ABSENT;
use crate::math::rng::Rng;
use crate::scene::triangulate::triangulate;
use proptest::prelude::*;
use std::fmt::Write;

/// Text of an OBJ file, and what it says.
#[derive(Default)]
struct Written {
    text: String,
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    uv_indices: Vec<[u32; 3]>,
    normal_indices: Vec<[u32; 3]>,
    materials: Vec<String>,
}

/// Writes with every liberty that the format gives.
struct Writer {
    rng: Rng,
    out: Written,
    material: String,
}

impl Writer {
    fn write(seed: u64) -> Written {
        let mut writer = Writer { rng: Rng::new(seed), out: Written::default(), material: String::new() };
        for _ in 0..3 {
            writer.position();
        }
        for _ in 0..writer.below(80) {
            match writer.below(9) {
                0 | 1 => writer.position(),
                2 => writer.uv(),
                3 => writer.normal(),
                4 => writer.material(),
                5 => writer.noise(),
                _ => writer.face(),
            }
        }
        writer.out
    }

    fn below(&mut self, n: usize) -> usize {
        self.rng.next_u32() as usize % n
    }

    fn pick(&mut self, choices: &[&'static str]) -> &'static str {
        choices[self.below(choices.len())]
    }

    fn put(&mut self, choices: &[&'static str]) {
        let chosen = self.pick(choices);
        self.out.text += chosen;
    }

    fn number(&mut self) -> f32 {
        (self.rng.f32() - 0.5) * 10f32.powi(self.below(12) as i32 - 6)
    }

    fn statement(&mut self, keyword: &str, words: &[String]) {
        self.put(&["", "", " ", "\t"]);
        self.out.text += keyword;
        for word in words {
            self.put(&[" ", " ", "\t", "   ", " \\\n", "\\\r\n ", " \\\n\\\n "]);
            self.out.text += word;
        }
        self.put(&["", " ", " # note", "# 1 2 3", "\t# C:\\", " ## \\"]);
        self.end();
    }

    fn end(&mut self) {
        self.put(&["\n", "\n", "\r\n", "\n\n", "\n \t\r\n"]);
    }

    fn digits(&mut self, x: f32) -> String {
        match self.below(5) {
            0 => format!("{x:e}"),
            1 => format!("{x:E}").replace("E", "E+").replace("+-", "-"),
            2 if x >= 0.0 => format!("+{x}"),
            3 if x.abs() < 1.0 => format!("{x}").replacen("0.", ".", 1),
            _ => format!("{x}"),
        }
    }

    fn position(&mut self) {
        let p = [0; 3].map(|_| self.number());
        let mut words = p.map(|x| self.digits(x)).to_vec();
        let more = [0, 0, 1, 3][self.below(4)];
        words.extend((0..more).map(|_| "0.25".to_string()));
        self.statement("v", &words);
        self.out.positions.push(p);
    }

    fn uv(&mut self) {
        let mut uv = [self.number(), self.number()];
        let mut words = uv.map(|x| self.digits(x)).to_vec();
        match self.below(4) {
            0 => words.push("7".to_string()),
            1 => {
                words.pop();
                uv[1] = 0.0;
            }
            _ => {}
        }
        self.statement("vt", &words);
        self.out.uvs.push(uv);
    }

    fn normal(&mut self) {
        let n = [self.number(), self.number(), 1.0];
        let words = n.map(|x| self.digits(x));
        self.statement("vn", &words);
        self.out.normals.push(n);
    }

    fn material(&mut self) {
        self.material = self.pick(&["a", "b c", "Material #2", "größe", ""]).to_string();
        self.out.text += "usemtl ";
        self.out.text += &self.material;
        self.put(&["", "  ", " # note"]);
        self.end();
    }

    fn noise(&mut self) {
        self.put(&["g a b", "o", "s off", "s 0", "# v 1 2 3", "#\\", "l 1 2", "p 1", "curv 1", "f 1 2"]);
        self.end();
    }

    /// An index of one of `count` values, and how it is written.
    fn index(&mut self, count: usize) -> (u32, String) {
        let index = self.below(count);
        let absolute = self.below(2) == 0;
        let written = if absolute { index as i64 + 1 } else { index as i64 - count as i64 };
        (index as u32, written.to_string())
    }

    fn corner(&mut self) -> ([u32; 3], String) {
        let (position, mut text) = self.index(self.out.positions.len());
        let mut corner = [position, ABSENT, ABSENT];
        let kind = self.below(8);
        let mut uv = String::new();
        if kind > 1 && !self.out.uvs.is_empty() {
            (corner[1], uv) = self.index(self.out.uvs.len());
        }
        let mut normal = String::new();
        if kind & 3 != 0 && !self.out.normals.is_empty() {
            (corner[2], normal) = self.index(self.out.normals.len());
        }
        let _ = match (&*uv, &*normal) {
            ("", "") => write!(text, "{}", self.pick(&["", "/", "//"])),
            (uv, "") => write!(text, "/{uv}{}", self.pick(&["", "/"])),
            (uv, normal) => write!(text, "/{uv}/{normal}"),
        };
        (corner, text)
    }

    fn face(&mut self) {
        let n = [3, 3, 3, 4, 4, 5, 9][self.below(7)];
        let (corners, words): (Vec<[u32; 3]>, Vec<String>) = (0..n).map(|_| self.corner()).unzip();
        self.statement("f", &words);
        let points: Vec<[f32; 3]> = corners.iter().map(|c| self.out.positions[c[0] as usize]).collect();
        let mut pieces = Vec::new();
        assert!(triangulate(&points, &mut pieces));
        for piece in pieces {
            let indices = |k: usize| piece.map(|c| corners[c][k]);
            let whole = |t: [u32; 3]| if t.contains(&ABSENT) { [ABSENT; 3] } else { t };
            self.out.triangles.push(indices(0));
            self.out.uv_indices.push(whole(indices(1)));
            self.out.normal_indices.push(whole(indices(2)));
            self.out.materials.push(self.material.clone());
        }
    }
}

/// What a loader that knows nothing of attributes that no triangle has would say.
fn attribute<T: Clone>(values: &[T], indices: &[[u32; 3]]) -> Option<(Vec<T>, Vec<[u32; 3]>)> {
    let any = indices.iter().any(|t| t[0] != ABSENT);
    any.then(|| (values.to_vec(), indices.to_vec()))
}

fn assert_loads_as_written(written: &Written, block: u64) {
    let obj = load_text(&written.text, block).unwrap_or_else(|e| panic!("{e}\n{}", written.text));
    let mesh = &obj.mesh;
    assert_eq!(mesh.positions, written.positions);
    assert_eq!(mesh.triangles, written.triangles, "{}", written.text);
    let uvs = mesh.uvs.as_ref().map(|a| (a.values.clone(), triples(a, &mesh.triangles)));
    assert_eq!(uvs, attribute(&written.uvs, &written.uv_indices), "{}", written.text);
    let normals = mesh.normals.as_ref().map(|a| (a.values.clone(), triples(a, &mesh.triangles)));
    assert_eq!(normals, attribute(&written.normals, &written.normal_indices), "{}", written.text);
    let names: Vec<&str> = mesh.materials.iter().map(|&m| &*obj.material_names[m as usize]).collect();
    assert_eq!(names, written.materials, "{}", written.text);
}

/// The outcome in one comparable piece.
fn outcome(text: &[u8], block: u64) -> String {
    match load_text(text, block) {
        Ok(obj) => format!("{:?} {:?} {:?}", obj.mesh, obj.material_names, obj.warnings),
        Err(error) => error.to_string(),
    }
}

proptest! {
    #[test]
    fn legal_files_load_as_written(seed: u64, block in 1u64..200) {
        let written = Writer::write(seed);
        for block in [1, block, 1 << 20] {
            assert_loads_as_written(&written, block);
        }
    }

    /// Damaged files neither panic nor depend on the blocks in what becomes of them.
    #[test]
    fn damaged_files_do_not_panic(
        seed: u64,
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut: prop::sample::Index,
    ) {
        let mut text = Writer::write(seed).text.into_bytes();
        for (at, byte) in damage {
            let at = at.index(text.len());
            text[at] = byte;
        }
        text.truncate(cut.index(2 * text.len()));
        prop_assert_eq!(outcome(&text, 1), outcome(&text, 1 << 20));
    }

    #[test]
    fn random_statements_do_not_panic(text in r"((v|vt|vn|f|usemtl|mtllib|l|q)( [-+0-9./e#\\]{1,5}){0,5}\r?\n){0,20}") {
        prop_assert_eq!(outcome(text.as_bytes(), 1), outcome(text.as_bytes(), 64));
    }

    #[test]
    fn random_bytes_do_not_panic(text in prop::collection::vec(any::<u8>(), 0..300)) {
        outcome(&text, 16);
    }
}
