//! Which format a file has, by its first bytes.

use image::ImageFormat;

/// The first bytes of every OpenEXR file.
pub(super) const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Radiance pictures begin with this, and then `RADIANCE` or `RGBE`.
pub(super) const RADIANCE_MAGIC: &[u8] = b"#?";

/// The format of a file that begins with `head`; `None` for what is no picture.
pub(super) fn guess(head: &[u8]) -> Option<ImageFormat> {
    image::guess_format(head).ok().or_else(|| is_tga(head).then_some(ImageFormat::Tga))
}

/// Whether the header is one that a TGA file may have. The format has no mark at its beginning, and the one at the end of a file
/// is left out by many programs.
fn is_tga(head: &[u8]) -> bool {
    let &[
        _,
        palette,
        kind,
        _,
        _,
        length_low,
        length_high,
        entry,
        _,
        _,
        _,
        _,
        width,
        wide,
        height,
        high,
        depth,
        flags,
        ..,
    ] = head
    else {
        return false;
    };
    let length = u16::from_le_bytes([length_low, length_high]);
    let indexed = palette == 1 && length > 0 && [15, 16, 24, 32].contains(&entry) && [8, 16].contains(&depth);
    let plain = palette <= 1 && [8, 15, 16, 24, 32].contains(&depth);
    let known = match kind {
        1 | 9 => indexed,
        2 | 10 => plain && depth != 8,
        3 | 11 => plain && [8, 16].contains(&depth),
        _ => false,
    };
    // the upper two bits of the flags are for interleaving, which nobody writes
    known && [width, wide] != [0; 2] && [height, high] != [0; 2] && flags & 0xc0 == 0
}

/// How many pixels a byte of a file stands for at most; `None` where there is no bound.
pub(super) fn pixels_per_byte(format: ImageFormat) -> Option<u64> {
    match format {
        // a bit is a block of 8 × 8 pixels at most
        ImageFormat::Jpeg => Some(8 * 64),
        // a byte of DEFLATE is 1032 at most (RFC 1951), and a byte of those eight pixels
        ImageFormat::Png => Some(1032 * 8),
        // a code of at least nine bits is at most as many pixels as there are codes
        ImageFormat::Gif => Some(4096),
        // of one colour WebP needs no bits for pixels, and rows of faxes in TIFF one for 65536
        ImageFormat::WebP | ImageFormat::Tiff => None,
        // palettes of one bit, in runs of up to 128 or 255
        _ => Some(255 * 8),
    }
}
