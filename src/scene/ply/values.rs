//! Numbers one after another, as text or in bytes.

use super::header::{Element, Kind, Property};

/// A place in the file, as a byte offset, and what is wrong there.
#[derive(Debug, PartialEq)]
pub(super) struct Fault {
    pub(crate) at: usize,
    pub(crate) message: String,
}

impl Fault {
    #[cold]
    pub(crate) fn new(at: usize, message: impl Into<String>) -> Fault {
        Fault { at, message: message.into() }
    }

    /// The same fault where what is looked at begins at `offset`.
    pub(crate) fn after(mut self, offset: usize) -> Fault {
        self.at += offset;
        self
    }
}

/// Reads the numbers of things one by one.
pub(super) trait Values {
    /// Begins with the next thing.
    fn begin(&mut self) -> Result<(), Fault>;

    /// Its next number; of a whole kind in ASCII it may have a fraction.
    fn number(&mut self, kind: Kind) -> Result<f64, Fault>;

    /// Passes over numbers.
    fn skip(&mut self, kind: Kind, count: usize) -> Result<(), Fault>;

    /// Ends the thing, all of whose numbers have been read.
    fn end(&mut self) -> Result<(), Fault>;

    /// Where the next number is.
    fn at(&self) -> usize;

    /// The next thing whole, where it is nothing but a list of three whole numbers, of whose values nothing is known; else `None`, and
    /// nothing is read.
    #[inline(always)]
    fn triangle(&mut self, _list: &Property) -> Option<[u32; 3]> {
        None
    }

    /// The length of a list.
    #[inline]
    fn length(&mut self, kind: Kind) -> Result<usize, Fault> {
        let (at, length) = (self.at(), self.number(kind)?);
        if length >= 0.0 && length.fract() == 0.0 && length <= f64::from(u32::MAX) {
            return Ok(length as usize);
        }
        Err(Fault::new(at, format!("{length} is not the length of a list")))
    }

    /// Passes over a whole thing.
    fn pass(&mut self, element: &Element) -> Result<(), Fault> {
        self.begin()?;
        for property in &element.properties {
            let count = property.length.map_or(Ok(1), |length| self.length(length))?;
            self.skip(property.kind, count)?;
        }
        self.end()
    }
}

/// Numbers in bytes.
pub(super) struct Binary<'a, const BIG_ENDIAN: bool> {
    pub(crate) bytes: &'a [u8],
    pub(crate) at: usize,
}

impl<const BIG_ENDIAN: bool> Binary<'_, BIG_ENDIAN> {
    #[inline(always)]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let found = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let Some(found) = found else { return Err(ended(self.at)) };
        self.at += N;
        let mut bytes = *found;
        if BIG_ENDIAN {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

#[cold]
fn ended(at: usize) -> Fault {
    Fault::new(at, "the file ends here, and more is missing")
}

impl<const BIG_ENDIAN: bool> Values for Binary<'_, BIG_ENDIAN> {
    #[inline(always)]
    fn begin(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    #[inline(always)]
    fn number(&mut self, kind: Kind) -> Result<f64, Fault> {
        Ok(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Kind::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Kind::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Kind::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Kind::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Kind::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Kind::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Kind::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    #[inline(always)]
    fn skip(&mut self, kind: Kind, count: usize) -> Result<(), Fault> {
        match kind.bytes().checked_mul(count) {
            Some(bytes) if bytes <= self.bytes.len() - self.at => self.at += bytes,
            _ => return Err(ended(self.at)),
        }
        Ok(())
    }

    #[inline(always)]
    fn end(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    #[inline(always)]
    fn at(&self) -> usize {
        self.at
    }

    #[inline(always)]
    fn triangle(&mut self, list: &Property) -> Option<[u32; 3]> {
        if list.length != Some(Kind::U8) || !matches!(list.kind, Kind::I32 | Kind::U32) {
            return None;
        }
        // spelt out: `map` is not always inlined
        let &[3, a, b, c, d, e, f, g, h, i, j, k, l] = self.bytes.get(self.at..)?.first_chunk::<13>()? else {
            return None;
        };
        self.at += 13;
        let corner = if BIG_ENDIAN { u32::from_be_bytes } else { u32::from_le_bytes };
        Some([corner([a, b, c, d]), corner([e, f, g, h]), corner([i, j, k, l])])
    }
}

/// Numbers as text, each thing in a line of its own. Empty lines are passed over.
pub(super) struct Text<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) at: usize,
}

impl Text<'_> {
    fn blanks(&mut self) {
        while matches!(self.bytes.get(self.at), Some(b' ' | b'\t' | 0x0b | 0x0c)) {
            self.at += 1;
        }
    }

    fn line_ends(&self) -> bool {
        matches!(self.bytes.get(self.at), None | Some(b'\n' | b'\r'))
    }

    #[cold]
    fn no_number(&self) -> Fault {
        if self.line_ends() {
            return Fault::new(self.at, "the line ends here, and numbers are missing");
        }
        let rest = &self.bytes[self.at..];
        let word = rest.iter().take(32).take_while(|b| !b.is_ascii_whitespace()).copied().collect::<Vec<u8>>();
        Fault::new(self.at, format!("`{}` is not a number", String::from_utf8_lossy(&word)))
    }
}

impl Values for Text<'_> {
    fn begin(&mut self) -> Result<(), Fault> {
        while self.bytes.get(self.at).is_some_and(|b| b.is_ascii_whitespace() || *b == 0x0b) {
            self.at += 1;
        }
        if self.at < self.bytes.len() { Ok(()) } else { Err(ended(self.at)) }
    }

    fn number(&mut self, _: Kind) -> Result<f64, Fault> {
        self.blanks();
        match fast_float2::parse_partial::<f64, _>(&self.bytes[self.at..]) {
            Ok((value, length)) if self.bytes.get(self.at + length).is_none_or(u8::is_ascii_whitespace) => {
                self.at += length;
                Ok(value)
            }
            _ => Err(self.no_number()),
        }
    }

    fn skip(&mut self, kind: Kind, count: usize) -> Result<(), Fault> {
        (0..count).try_for_each(|_| self.number(kind).map(drop))
    }

    /// A line, whatever is in it.
    fn pass(&mut self, _: &Element) -> Result<(), Fault> {
        self.begin()?;
        let rest = &self.bytes[self.at..];
        self.at += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
        Ok(())
    }

    fn end(&mut self) -> Result<(), Fault> {
        self.blanks();
        if self.line_ends() { Ok(()) } else { Err(Fault::new(self.at, "more numbers than the header says")) }
    }

    fn at(&self) -> usize {
        self.at
    }
}

/// The fault with the thing that it is in.
#[cold]
pub(super) fn within(fault: Fault, element: &Element, index: usize) -> Fault {
    Fault { at: fault.at, message: format!("`{}` {index} of {}: {}", element.name, element.count, fault.message) }
}

/// Evaluates `$body` with the values of the encoding in all of `$bytes`.
macro_rules! with_values {
    ($encoding:expr, $bytes:expr, $values:ident => $body:expr) => {
        match $encoding {
            Encoding::Ascii => {
                let mut $values = Text { bytes: $bytes, at: 0 };
                $body
            }
            Encoding::LittleEndian => {
                let mut $values = Binary::<false> { bytes: $bytes, at: 0 };
                $body
            }
            Encoding::BigEndian => {
                let mut $values = Binary::<true> { bytes: $bytes, at: 0 };
                $body
            }
        }
    };
}

pub(super) use with_values;
