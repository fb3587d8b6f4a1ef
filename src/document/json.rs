//! JSON into the same tree, with places: serde_json judges the text, this only notes where its values stand.

use super::tree::{At, Entries, Entry, Fault, Node, Value};
use serde::de::DeserializeOwned;

/// Parses a JSON text.
pub(crate) fn from_json(text: &str) -> Result<Node, Fault> {
    // This also bounds the depth of what follows: serde_json refuses more than 128 levels.
    serde_json::from_str::<serde_json::Value>(text).map_err(|e| {
        let line_start: usize = text.split_inclusive('\n').take(e.line().saturating_sub(1)).map(str::len).sum();
        let message = e.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        Fault::new(At::Text(line_start + e.column().saturating_sub(1)), message)
    })?;
    Cursor { text, position: 0 }.node()
}

/// Walks over a text that is known to be JSON.
struct Cursor<'a> {
    text: &'a str,
    position: usize,
}

impl Cursor<'_> {
    /// The next byte after white space and separators, which the first pass has found to be right.
    fn peek(&mut self) -> u8 {
        let rest = &self.text.as_bytes()[self.position..];
        let skipped = rest.iter().take_while(|b| b" \t\r\n,:".contains(b)).count();
        self.position += skipped;
        rest.get(skipped).copied().unwrap_or(0)
    }

    fn node(&mut self) -> Result<Node, Fault> {
        let value = match self.peek() {
            b'{' => return self.table(),
            b'[' => return self.array(),
            _ => (At::Text(self.position), self.scalar::<serde_json::Value>()?),
        };
        Ok(Node { at: value.0, value: convert(value.1) })
    }

    fn table(&mut self) -> Result<Node, Fault> {
        let at = At::Text(self.position);
        self.position += 1;
        let mut entries = Entries::new();
        while self.peek() != b'}' {
            let key = At::Text(self.position);
            let name: String = self.scalar()?;
            let entry = Entry { key, node: self.node()? };
            if entries.insert(name.clone(), entry).is_some() {
                return Err(Fault::new(key, format!("duplicate key `{name}`")));
            }
        }
        self.position += 1;
        Ok(Node { at, value: Value::Table(entries) })
    }

    fn array(&mut self) -> Result<Node, Fault> {
        let at = At::Text(self.position);
        self.position += 1;
        let mut items = Vec::new();
        while self.peek() != b']' {
            items.push(self.node()?);
        }
        self.position += 1;
        Ok(Node { at, value: Value::Array(items) })
    }

    fn scalar<T: DeserializeOwned>(&mut self) -> Result<T, Fault> {
        let at = At::Text(self.position);
        let mut stream = serde_json::Deserializer::from_str(&self.text[self.position..]).into_iter();
        let value = stream.next().ok_or_else(|| Fault::new(at, "a value is missing"))?;
        self.position += stream.byte_offset();
        value.map_err(|e| Fault::new(at, e.to_string()))
    }
}

fn convert(value: serde_json::Value) -> Value {
    match value {
        serde_json::Value::Bool(b) => Value::Boolean(b),
        serde_json::Value::String(s) => Value::String(s),
        serde_json::Value::Number(n) => match n.as_i128() {
            Some(i) => Value::Integer(i),
            None => Value::Float(n.as_f64().unwrap_or(f64::NAN)),
        },
        _ => Value::Null,
    }
}
