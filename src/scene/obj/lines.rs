//! Lines, tokens and numbers of OBJ and MTL text. Works on bytes: names need not be UTF-8.

use super::source::Fault;

/// White space within a line.
#[inline]
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

/// Whether the line whose end follows `text` goes on in the next one.
pub(super) fn continues(text: &[u8]) -> bool {
    text.ends_with(b"\\") || text.ends_with(b"\\\r")
}

/// Whether the text has the line ends of classic Mac OS.
pub(super) fn ends_in_cr(text: &[u8]) -> bool {
    memchr::memchr(b'\n', text).is_none() && memchr::memchr(b'\r', text).is_some()
}

/// Turns the line ends of classic Mac OS into LF.
pub(super) fn convert_cr(text: &mut [u8]) {
    if ends_in_cr(text) {
        text.iter_mut().filter(|b| **b == b'\r').for_each(|b| *b = b'\n');
    }
}

/// Overwrites `\` and the line end after it with blanks, which leaves every other byte where it was. A backslash that
/// ends a comment (a folder's name, as a rule) joins nothing: it would swallow the statement after it.
pub(super) fn join_continuations(text: &mut [u8]) {
    let mut from = 0;
    while let Some(i) = memchr::memchr(b'\\', &text[from..]) {
        let slash = from + i;
        from = slash + 1;
        let end = from + usize::from(text.get(from) == Some(&b'\r'));
        if text.get(end) == Some(&b'\n') && !in_comment(&text[..slash]) {
            text[slash..=end].fill(b' ');
        }
    }
}

fn in_comment(text: &[u8]) -> bool {
    let start = memchr::memrchr(b'\n', text).map_or(0, |i| i + 1);
    memchr::memchr(b'#', &text[start..]).is_some()
}

/// The lines that say something, each with its offset: leading blanks, empty lines and comment lines are left out.
pub(super) struct Lines<'a> {
    text: &'a [u8],
    next: usize,
}

impl<'a> Lines<'a> {
    /// `text` begins with a line, its continuations have been joined. A byte-order mark is skipped.
    pub(crate) fn new(text: &'a [u8]) -> Lines<'a> {
        Lines { text, next: if text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 } }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    #[inline]
    fn next(&mut self) -> Option<(usize, &'a [u8])> {
        while self.next < self.text.len() {
            let mut start = self.next;
            let rest = &self.text[start..];
            let end = memchr::memchr(b'\n', rest).map_or(self.text.len(), |i| start + i);
            self.next = end + 1;
            while start < end && is_blank(self.text[start]) {
                start += 1;
            }
            if start < end && self.text[start] != b'#' {
                return Some((start, &self.text[start..end]));
            }
        }
        None
    }
}

/// The first word of a line and what follows it.
#[inline]
pub(super) fn keyword(line: &[u8]) -> (&[u8], &[u8]) {
    line.split_at(line.iter().position(|&b| is_blank(b)).unwrap_or(line.len()))
}

/// A name or file name that takes the rest of a line and may hold blanks. A `#` begins a comment only where it stands
/// alone or is doubled ("wood # note"), for exporters write names such as "Material #25".
pub(super) fn name(rest: &[u8]) -> &[u8] {
    let comment = memchr::memchr_iter(b'#', rest).find(|&i| {
        let before = i == 0 || is_blank(rest[i - 1]);
        before && rest.get(i + 1).is_none_or(|&b| is_blank(b) || b == b'#')
    });
    trim(&rest[..comment.unwrap_or(rest.len())])
}

/// Without blanks at both ends.
pub(super) fn trim(mut text: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = text
        && is_blank(*first)
    {
        text = rest;
    }
    while let [rest @ .., last] = text
        && is_blank(*last)
    {
        text = rest;
    }
    text
}

/// Bytes as text for names and messages.
pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// `f32` or `f64`.
trait Float: fast_float2::FastFloat + From<f32> {}

impl Float for f32 {}
impl Float for f64 {}

/// Reads a statement's arguments one by one. A `#` ends them.
pub(super) struct Fields<'a> {
    line: &'a [u8],
    pub(crate) at: usize,
}

impl<'a> Fields<'a> {
    /// The arguments of `line` from its byte `at`.
    #[inline]
    pub(crate) fn new(line: &'a [u8], at: usize) -> Fields<'a> {
        Fields { line, at }
    }

    /// What is left after skipping blanks; empty at the end and at a comment.
    #[inline]
    pub(crate) fn rest(&mut self) -> &'a [u8] {
        while self.at < self.line.len() && is_blank(self.line[self.at]) {
            self.at += 1;
        }
        match self.line.get(self.at) {
            None | Some(b'#') => &[],
            Some(_) => &self.line[self.at..],
        }
    }

    /// The next number, correctly rounded; `None` where there are no more arguments. May be infinite or not a number.
    #[inline]
    pub(crate) fn number(&mut self) -> Result<Option<f32>, Fault> {
        self.float()
    }

    #[inline]
    fn float<T: Float>(&mut self) -> Result<Option<T>, Fault> {
        let rest = self.rest();
        if rest.is_empty() {
            return Ok(None);
        }
        if let Ok((value, length)) = fast_float2::parse_partial::<T, _>(rest)
            && rest.get(length).is_none_or(|&b| is_blank(b))
        {
            self.at += length;
            return Ok(Some(value));
        }
        self.odd_number(rest).map(Some)
    }

    /// Numbers that a comment follows without a blank, and what Microsoft's C library prints for infinities and NaN.
    #[cold]
    fn odd_number<T: Float>(&mut self, rest: &[u8]) -> Result<T, Fault> {
        let token = &rest[..token_length(rest)];
        if let Some(tail) = memchr::memmem::find(token, b"1.#")
            && [&b"INF"[..], b"IND", b"QNAN", b"SNAN"].iter().any(|k| token[tail + 3..].starts_with(k))
        {
            self.at += token.len();
            return Ok(f32::NAN.into());
        }
        let number = &token[..memchr::memchr(b'#', token).unwrap_or(token.len())];
        let value = fast_float2::parse::<T, _>(number)
            .map_err(|_| Fault::new(self.at, format!("`{}` is not a number", excerpt(token))))?;
        self.at += number.len();
        Ok(value)
    }

    /// At least `N` numbers; more of them are read and dropped.
    #[inline]
    pub(crate) fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f32; N], Fault> {
        let values = self.first_numbers(what)?;
        while self.number()?.is_some() {}
        Ok(values)
    }

    /// `N` numbers, whatever comes after them.
    #[inline]
    pub(crate) fn first_numbers<const N: usize>(&mut self, what: &str) -> Result<[f32; N], Fault> {
        self.floats(what)
    }

    /// The same without rounding to single precision.
    pub(crate) fn doubles<const N: usize>(&mut self, what: &str) -> Result<[f64; N], Fault> {
        self.floats(what)
    }

    #[inline]
    fn floats<T: Float, const N: usize>(&mut self, what: &str) -> Result<[T; N], Fault> {
        let mut values = [T::from(0.0); N];
        for (i, value) in values.iter_mut().enumerate() {
            *value =
                self.float()?.ok_or_else(|| Fault::new(self.at, format!("{what} needs {N} numbers, here are {i}")))?;
        }
        Ok(values)
    }
}

/// Bytes up to the next blank.
pub(super) fn token_length(rest: &[u8]) -> usize {
    rest.iter().position(|&b| is_blank(b)).unwrap_or(rest.len())
}

/// A token for a message, cut where it is long.
pub(super) fn excerpt(token: &[u8]) -> String {
    let shown = text(&token[..token.len().min(32)]);
    if token.len() > 32 { shown + "…" } else { shown }
}
