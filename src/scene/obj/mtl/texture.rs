//! Texture statements: options, then a file name that may hold blanks.

use super::super::lines;
use super::super::source::Fault;
use super::Notes;
use crate::io::paths;
use crate::math::Rgb;
use crate::texture::{ImageTexture, ScalarTexture};
use std::path::Path;

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TextureStatement {
    pub(crate) image: ImageTexture,
    /// `-bm`
    pub(crate) bump: Option<f32>,
    /// `-imfchan`
    pub(crate) channel: Option<Channel>,
}

/// Which number of a texel counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channel {
    /// Red (0), green (1) or blue (2).
    Color(usize),
    Matte,
    Luminance,
}

impl TextureStatement {
    /// The picture as one of numbers; without `-imfchan` they are of the channel `usual`.
    pub(super) fn scalar(self, usual: Channel) -> ScalarTexture {
        match self.channel.unwrap_or(usual) {
            Channel::Color(channel) => ScalarTexture::Channel(self.image, channel),
            Channel::Matte => ScalarTexture::Image(self.image),
            Channel::Luminance => ScalarTexture::Luminance(self.image),
        }
    }
}

/// Reads the arguments of a texture statement; `None` if there is no file name. Faults count from the start of `rest`.
pub(super) fn read(rest: &[u8], folder: &Path, notes: &mut Notes) -> Result<Option<TextureStatement>, Fault> {
    let argument = lines::name(rest);
    let mut words = Words { text: argument, at: 0 };
    let mut statement = TextureStatement { image: ImageTexture::new(Default::default()), bump: None, channel: None };
    while words.option(&mut statement, notes)? {}
    let name = paths::unquoted(lines::trim(&argument[words.at..]));
    statement.image.path = paths::resolve(folder, name);
    Ok((!name.is_empty()).then_some(statement))
}

/// The words of a texture statement.
struct Words<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    /// The next word and where it ends; `None` at the end.
    fn peek(&self) -> Option<(&'a [u8], usize)> {
        let rest = &self.text[self.at..];
        let blanks = rest.iter().take_while(|&&b| lines::is_blank(b)).count();
        let length = lines::token_length(&rest[blanks..]);
        (length > 0).then(|| (&rest[blanks..][..length], self.at + blanks + length))
    }

    /// Takes an option with its arguments into account; false if the next word begins the file name.
    fn option(&mut self, statement: &mut TextureStatement, notes: &mut Notes) -> Result<bool, Fault> {
        let Some((word, end)) = self.peek() else { return Ok(false) };
        let start = self.at;
        self.at = end;
        let texture = &mut statement.image;
        match &*lines::text(word).to_ascii_lowercase() {
            "-s" => texture.scale = self.pair(texture.scale)?,
            "-o" => texture.offset = self.pair(texture.offset)?,
            "-mm" => texture.tint = self.gain(notes)?,
            "-bm" => statement.bump = Some(self.pair([0.0; 2])?[0]),
            "-clamp" => texture.clamp = self.word().eq_ignore_ascii_case("on"),
            "-imfchan" => statement.channel = self.channel(notes),
            // How an image is filtered or cached.
            "-blendu" | "-blendv" | "-texres" | "-boost" | "-cc" => self.skip(),
            option @ ("-type" | "-colorspace" | "-t") => {
                notes.once(format!("option `{option}` is ignored"));
                if option == "-t" { self.pair([0.0; 2]).map(drop)? } else { self.skip() }
            }
            _ => {
                self.at = start;
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// `-mm base gain` maps a texel t to base + gain·t.
    fn gain(&mut self, notes: &mut Notes) -> Result<Rgb, Fault> {
        let [base, gain] = self.pair([0.0, 1.0])?;
        if base != 0.0 || gain < 0.0 {
            notes.once("option `-mm`: only a gain that is not negative is supported");
        }
        Ok(Rgb::splat(gain.max(0.0)))
    }

    fn channel(&mut self, notes: &mut Notes) -> Option<Channel> {
        match &*self.word() {
            "r" => Some(Channel::Color(0)),
            "g" => Some(Channel::Color(1)),
            "b" => Some(Channel::Color(2)),
            "m" => Some(Channel::Matte),
            "l" => Some(Channel::Luminance),
            other => {
                notes.once(format!("option `-imfchan {other}` is ignored"));
                None
            }
        }
    }

    /// Takes the next word.
    fn word(&mut self) -> String {
        let word = self.peek().map(|(word, _)| lines::text(word)).unwrap_or_default();
        self.skip();
        word
    }

    fn skip(&mut self) {
        if let Some((_, end)) = self.peek() {
            self.at = end;
        }
    }

    /// One to three numbers, of which the third is dropped; a missing second one is as in `default`. The last word of
    /// the statement is the file's name even if it is a number.
    fn pair(&mut self, default: [f32; 2]) -> Result<[f32; 2], Fault> {
        let mut values = [default[0], default[1], 0.0];
        for (i, value) in values.iter_mut().enumerate() {
            let word = self.peek().filter(|&(_, end)| end < self.text.len());
            let number = word.and_then(|(word, end)| Some((fast_float2::parse(word).ok()?, end)));
            match number {
                Some((x, end)) if f32::is_finite(x) => (*value, self.at) = (x, end),
                None if i > 0 => break,
                _ => return Err(Fault::new(self.at, "a texture option needs a finite number")),
            }
        }
        Ok([values[0], values[1]])
    }
}
