//! Which axis is up, as far as the comments at the head of an OBJ file say so.

use glam::Vec3;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes of a file that are searched: its head.
const HEAD: u64 = 16 << 10;

/// Programs in whose world z is up, and which write its coordinates as they are, by the words in their first comment.
const Z_IS_UP: &[&str] = &["created by freecad", "openscad obj exporter"];

/// What is up in an OBJ file by its own words; `None` where it does not say, and where it cannot be read.
pub(super) fn up_of_file(path: &Path) -> Option<Vec3> {
    let mut head = Vec::new();
    File::open(path).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
    up_of_text(&String::from_utf8_lossy(&head))
}

/// The same of a text; only comments before the first statement count.
pub(super) fn up_of_text(text: &str) -> Option<Vec3> {
    let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
    let comments = lines.take_while(|line| line.is_empty() || line.starts_with('#'));
    comments.map(str::to_lowercase).find_map(|line| match Z_IS_UP.iter().any(|words| line.contains(words)) {
        true => Some(Vec3::Z),
        false => line.split([',', ';', '(', ')', '|']).find_map(up_of_phrase),
    })
}

/// "z-up", "+Z is up", "up axis: y", "up_axis = -z".
fn up_of_phrase(phrase: &str) -> Option<Vec3> {
    let words = words(phrase);
    let word = |k: usize| words.get(k).map_or("", String::as_str);
    (0..words.len()).find_map(|k| match word(k) {
        "up" | "upaxis" => {
            let between = ["axis", "is", "vector", "direction", "dir"].contains(&word(k + 1));
            axis(word(k + 1 + usize::from(between)))
        }
        name if word(k + 1) == "up" || (word(k + 1) == "is" && word(k + 2) == "up") => axis(name),
        _ => None,
    })
}

/// Letters and digits in a row, with the sign before an axis.
fn words(phrase: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in phrase.chars() {
        let sign = matches!(c, '+' | '-') && !before.is_alphanumeric();
        if !(c.is_alphanumeric() || sign) || (sign && !words.concat().is_empty()) {
            words.push(String::new());
        }
        if c.is_alphanumeric() || sign {
            words.last_mut().expect("there is always a word").push(c);
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

fn axis(name: &str) -> Option<Vec3> {
    match name {
        "x" | "+x" => Some(Vec3::X),
        "-x" => Some(Vec3::NEG_X),
        "y" | "+y" => Some(Vec3::Y),
        "-y" => Some(Vec3::NEG_Y),
        "z" | "+z" => Some(Vec3::Z),
        "-z" => Some(Vec3::NEG_Z),
        _ => None,
    }
}
