//! Words, strings and brackets of a file.

use crate::Result;
use crate::error::SourceLocation;
use std::borrow::Cow;
use std::path::Path;

/// A part of the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token<'a> {
    pub(crate) text: Cow<'a, str>,
    /// It stood in quotes, which are no part of it.
    pub(crate) quoted: bool,
    line: usize,
    column: usize,
}

/// Cuts a text into tokens; comments are passed over.
pub(super) struct Tokens<'a> {
    pub(crate) path: &'a Path,
    text: &'a str,
    at: usize,
    line: usize,
    line_start: usize,
    peeked: Option<Token<'a>>,
}

impl<'a> Tokens<'a> {
    pub(crate) fn new(path: &'a Path, text: &'a str) -> Tokens<'a> {
        Tokens { path, text, at: 0, line: 1, line_start: 0, peeked: None }
    }

    /// Where a token is.
    pub(crate) fn place(&self, token: &Token) -> SourceLocation {
        SourceLocation { path: self.path.to_path_buf(), line: token.line, column: token.column }
    }

    /// The next token; `None` at the end.
    ///
    /// # Errors
    /// A string without an end.
    pub(crate) fn next(&mut self) -> Result<Option<Token<'a>>> {
        match self.peeked.take() {
            Some(token) => Ok(Some(token)),
            None => self.read(),
        }
    }

    /// The next token, which stays the next.
    ///
    /// # Errors
    /// As [`Self::next`].
    pub(crate) fn peek(&mut self) -> Result<Option<&Token<'a>>> {
        if self.peeked.is_none() {
            self.peeked = self.read()?;
        }
        Ok(self.peeked.as_ref())
    }

    /// The next token, which has to be there.
    ///
    /// # Errors
    /// As [`Self::next`], and the end.
    pub(crate) fn needed(&mut self, what: &str) -> Result<Token<'a>> {
        match self.next()? {
            Some(token) => Ok(token),
            None => Err(self.here().error(format!("the file ends where {what} is missing"))),
        }
    }

    fn here(&self) -> SourceLocation {
        let before = &self.text[self.line_start..self.at];
        SourceLocation { path: self.path.to_path_buf(), line: self.line, column: 1 + before.chars().count() }
    }

    fn skip_blanks(&mut self) {
        let bytes = self.text.as_bytes();
        while let Some(&byte) = bytes.get(self.at) {
            match byte {
                b'\n' => {
                    self.line += 1;
                    self.line_start = self.at + 1;
                }
                b' ' | b'\t' | b'\r' => (),
                b'#' => {
                    self.at = memchr::memchr(b'\n', &bytes[self.at..]).map_or(bytes.len(), |n| self.at + n);
                    continue;
                }
                _ => return,
            }
            self.at += 1;
        }
    }

    fn read(&mut self) -> Result<Option<Token<'a>>> {
        self.skip_blanks();
        let bytes = self.text.as_bytes();
        let Some(&first) = bytes.get(self.at) else { return Ok(None) };
        // columns count bytes: lines of data are long, and cheap to count so
        let (line, column) = (self.line, 1 + self.at - self.line_start);
        let token = |text, quoted| Some(Token { text, quoted, line, column });
        match first {
            b'"' => {
                let text = self.string()?;
                Ok(token(text, true))
            }
            b'[' | b']' => {
                self.at += 1;
                Ok(token(Cow::Borrowed(&self.text[self.at - 1..self.at]), false))
            }
            _ => {
                let ends = |byte: &u8| matches!(byte, b' ' | b'\t' | b'\r' | b'\n' | b'"' | b'[' | b']' | b'#');
                let length = bytes[self.at..].iter().position(ends).unwrap_or(bytes.len() - self.at);
                self.at += length;
                Ok(token(Cow::Borrowed(&self.text[self.at - length..self.at]), false))
            }
        }
    }

    /// What stands between quotes, of which the first is here.
    fn string(&mut self) -> Result<Cow<'a, str>> {
        let open = self.here();
        let rest = &self.text[self.at + 1..];
        let end = rest.find(['"', '\\', '\n']);
        if let Some(end) = end.filter(|&end| rest.as_bytes()[end] == b'"') {
            self.at += end + 2;
            return Ok(Cow::Borrowed(&rest[..end]));
        }
        let (mut text, mut escaped) = (String::new(), false);
        for (at, c) in rest.char_indices() {
            match c {
                '\n' => break,
                _ if escaped => {
                    text.push(match c {
                        'n' => '\n',
                        't' => '\t',
                        'r' => '\r',
                        other => other,
                    });
                    escaped = false;
                }
                '\\' => escaped = true,
                '"' => {
                    self.at += at + 2;
                    return Ok(Cow::Owned(text));
                }
                other => text.push(other),
            }
        }
        Err(open.error("this string has no end on its line"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<(String, bool, usize, usize)> {
        let mut tokens = Tokens::new(Path::new("a.pbrt"), text);
        let mut all = Vec::new();
        while let Some(token) = tokens.next().unwrap() {
            all.push((token.text.into_owned(), token.quoted, token.line, token.column));
        }
        all
    }

    #[test]
    fn texts_are_cut_at_blanks_quotes_and_brackets() {
        let found = words("Shape\"a b\"[1 2.5]# no\n  \"x\\\"y\" -3e4\t]");
        let wanted = [
            ("Shape", false, 1, 1),
            ("a b", true, 1, 6),
            ("[", false, 1, 11),
            ("1", false, 1, 12),
            ("2.5", false, 1, 14),
            ("]", false, 1, 17),
            ("x\"y", true, 2, 3),
            ("-3e4", false, 2, 10),
            ("]", false, 2, 15),
        ];
        assert_eq!(found, wanted.map(|(text, quoted, line, column)| (text.to_string(), quoted, line, column)));
        let mut open = Tokens::new(Path::new("a.pbrt"), "A\n \"open\nB");
        assert!(open.next().unwrap().is_some());
        assert_eq!(open.next().unwrap_err().to_string(), "a.pbrt:2:2: this string has no end on its line");
    }
}
