//! Numbers with units: sizes and durations.

use super::key::Key;
use super::reader::Reader;
use super::tree::{At, Fault, Value};

impl Reader {
    /// A positive number in double precision, which need not be given.
    pub(crate) fn positive(&mut self, key: impl Into<Key>, slot: &mut Option<f64>) -> Result<(), Fault> {
        let key = key.into();
        let Some(node) = self.ask(key, "number", "none", "greater than 0")? else { return Ok(()) };
        let number = match node.value {
            Value::Integer(i) => i as f64,
            Value::Float(x) => x,
            _ => return Err(node.mismatch(key.name, "a number")),
        };
        if !(number > 0.0 && number.is_finite()) {
            let message = format!("`{}` must be finite and greater than 0, found {number}", key.name);
            return Err(Fault::new(node.at, message));
        }
        *slot = Some(number);
        Ok(())
    }

    /// Bytes as an integer, or text with a unit.
    pub(crate) fn memory(&mut self, key: impl Into<Key>, slot: &mut u64) -> Result<(), Fault> {
        let key = key.into();
        let default = format!("\"{} MiB\"", *slot >> 20);
        let Some(node) = self.ask(key, "integer or string", default, "1 B or more")? else { return Ok(()) };
        *slot = match &node.value {
            Value::Integer(i) => u64::try_from(*i).ok().filter(|b| *b > 0),
            Value::String(s) => bytes(s),
            _ => return Err(node.mismatch(key.name, "an integer or a string like \"256 MiB\"")),
        }
        .ok_or_else(|| memory_fault(node.at, key.name))?;
        Ok(())
    }
}

fn memory_fault(at: At, key: &str) -> Fault {
    let units = "B, KiB, MiB, GiB, TiB, kB, MB, GB or TB";
    Fault::new(at, format!("`{key}` must be 1 or more bytes, or text with a unit ({units})"))
}

/// "1.5 GiB" in bytes, rounded down; `None` where it is no size or less than a byte.
fn bytes(text: &str) -> Option<u64> {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let factor = match unit.trim() {
        "" | "B" => 1.0,
        "KiB" => 1024.0,
        "MiB" => f64::from(1 << 20),
        "GiB" => f64::from(1 << 30),
        "TiB" => (1u64 << 40) as f64,
        "kB" => 1e3,
        "MB" => 1e6,
        "GB" => 1e9,
        "TB" => 1e12,
        _ => return None,
    };
    let size = number.parse::<f64>().ok()? * factor;
    (1.0..u64::MAX as f64).contains(&size).then_some(size as u64)
}
