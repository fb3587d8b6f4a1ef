//! Materials of MTL libraries against Blender 4.2: its importer and Cycles, 256 samples, a box filter, so that nothing of the sky
//! beside the square is seen.

use crate::common::square::{SKY, halves, loaded, square};

/// The mean colour of the picture.
fn seen(library: &str) -> [f64; 3] {
    let folder = square(SKY, library);
    let [a, b] = halves(&loaded(&folder));
    std::array::from_fn(|channel| 0.5 * (a[channel] + b[channel]))
}

fn assert_within(share: f64, library: &str, wanted: [f64; 3]) {
    let found = seen(library);
    let near = found.iter().zip(wanted).all(|(found, wanted)| (found / wanted - 1.0).abs() < share);
    assert!(near, "{library}: {found:?} is not {wanted:?}");
}

#[test]
fn blenders_plastic_is_as_bright_as_in_cycles() {
    let red = "Ns 250\nKa 1 1 1\nKd 0.8 0.1 0.1\nKs 0.5 0.5 0.5\nNi 1.45\nd 1\nillum 2\n";
    assert_within(0.03, red, [0.806, 0.1292, 0.1292]);
    let dull = "Ns 10\nKd 0.8 0.8 0.8\nKs 0.1 0.1 0.1\nNi 1.5\nillum 2\n";
    assert_within(0.03, dull, [0.8008; 3]);
}

#[test]
fn blenders_metal_is_as_bright_as_in_cycles() {
    let gold = "Ns 250\nKa 1 1 1\nKd 0.9 0.6 0.1\nKs 0.5 0.5 0.5\nNi 1.45\nd 1\nillum 3\n";
    assert_within(0.03, gold, [0.8911, 0.5776, 0.0923]);
}
