//! Names of files that hold the number of a frame.

use std::path::{Path, PathBuf};

/// The file of a frame: in its name, `####` stands for the number with at least so many digits, as in Blender, and `%04d` or
/// `%d` as in ffmpeg. `None` where the name has neither.
pub(super) fn numbered(path: &Path, frame: u32) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let (before, digits, after) = conversion(name).or_else(|| hashes(name))?;
    Some(path.with_file_name(format!("{before}{frame:0digits$}{after}")))
}

/// What is before the first `%d` or `%0Nd`, how many digits that stands for at least, and what is after it.
fn conversion(name: &str) -> Option<(&str, usize, &str)> {
    name.match_indices('%').find_map(|(at, _)| {
        let rest = &name[at + 1..];
        let end = rest.find(|c: char| !c.is_ascii_digit())?;
        let digits = if end == 0 { 0 } else { rest[..end].strip_prefix('0')?.parse().ok().filter(|n| *n <= 20)? };
        Some((&name[..at], digits, rest[end..].strip_prefix('d')?))
    })
}

/// The same of the last row of `#`.
fn hashes(name: &str) -> Option<(&str, usize, &str)> {
    let end = name.rfind('#')? + 1;
    let begin = name[..end].trim_end_matches('#').len();
    Some((&name[..begin], end - begin, &name[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_the_place_of_patterns() {
        for (pattern, frame, name) in [
            ("out/a.####.exr", 7, "out/a.0007.exr"),
            ("a_%04d.png", 12345, "a_12345.png"),
            ("a%d.png", 7, "a7.png"),
            ("100%/50%a%03d#.png", 7, "100%/50%a007#.png"),
            ("#1-##.exr", 123, "#1-123.exr"),
            ("ä###ß.exr", 4, "ä004ß.exr"),
        ] {
            assert_eq!(numbered(Path::new(pattern), frame), Some(name.into()), "{pattern}");
        }
        for plain in ["a.exr", "#/a.exr", "a%4d.exr", "a%s.exr", "a%0x.exr", "%", "a%099999d.exr"] {
            assert_eq!(numbered(Path::new(plain), 1), None, "{plain}");
        }
    }
}
