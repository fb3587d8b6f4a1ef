//! Parts of pictures, and smaller pictures.

use super::Layer;

/// A rectangle of pixels, counted from the upper left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Rectangle {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// What the values of a layer are, which decides what those of several pixels together are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Their mean.
    Mean,
    /// Variances of independent pixels: the variance of their mean.
    Variance,
    /// Names of things, of which there is no mean: that of the pixel in the middle.
    Id,
}

impl Layer {
    /// The values within `part` of a picture that is `width` pixels wide.
    ///
    /// # Panics
    /// Where `part` reaches beyond the picture.
    pub(crate) fn crop(&self, width: usize, part: &Rectangle) -> Layer {
        assert!(part.x + part.width <= width, "columns of the picture");
        let cut = |values: &Vec<f32>| {
            let rows = values.chunks(width).skip(part.y).take(part.height);
            rows.flat_map(|row| &row[part.x..part.x + part.width]).copied().collect()
        };
        self.with_values(cut)
    }

    /// The picture in another size, at most as large: means over the area of each new pixel. A layer `variance` becomes the
    /// variance of these means, ids (`guide.state`, `crypto…`) are those of the pixels in the middle.
    ///
    /// # Panics
    /// Where a side is 0 or larger than before.
    pub(crate) fn shrink(&self, size: (usize, usize), smaller: (usize, usize)) -> Layer {
        let (columns, rows) = (Shares::new(size.0, smaller.0), Shares::new(size.1, smaller.1));
        let kind = kind(&self.name);
        self.with_values(|values| match kind {
            Kind::Id => middle(values, size, smaller),
            _ => mean(values, size.0, &columns, &rows, kind),
        })
    }

    fn with_values(&self, f: impl Fn(&Vec<f32>) -> Vec<f32>) -> Layer {
        let channels = self.channels.iter().map(|(suffix, values)| (suffix.clone(), f(values))).collect();
        Layer { name: self.name.clone(), channels }
    }
}

fn kind(layer: &str) -> Kind {
    let name = layer.to_ascii_lowercase();
    match &*name {
        "variance" => Kind::Variance,
        "guide.state" => Kind::Id,
        name if name.starts_with("crypto") => Kind::Id,
        _ => Kind::Mean,
    }
}

/// Along one side: which old pixels each new one covers, and the share that each has of it.
struct Shares(Vec<Vec<(usize, f64)>>);

impl Shares {
    fn new(old: usize, new: usize) -> Shares {
        assert!(new >= 1 && new <= old, "{new} pixels of {old}");
        let step = old as f64 / new as f64;
        let covered = |k: usize| {
            let (from, to) = (k as f64 * step, ((k + 1) as f64 * step).min(old as f64));
            let last = (to.ceil() as usize).min(old);
            let share = move |i: usize| (i, (to.min(i as f64 + 1.0) - from.max(i as f64)) / step);
            (from as usize..last).map(share).filter(|(_, share)| *share > 0.0).collect()
        };
        Shares((0..new).map(covered).collect())
    }
}

fn mean(values: &[f32], width: usize, columns: &Shares, rows: &Shares, kind: Kind) -> Vec<f32> {
    let weight = |share: f64| if kind == Kind::Variance { share * share } else { share };
    let pixel = |row: &Vec<(usize, f64)>, column: &Vec<(usize, f64)>| {
        let mut sum = 0.0;
        for (y, down) in row {
            let line = &values[y * width..(y + 1) * width];
            sum += weight(*down) * column.iter().map(|(x, across)| weight(*across) * f64::from(line[*x])).sum::<f64>();
        }
        sum as f32
    };
    rows.0.iter().flat_map(|row| columns.0.iter().map(move |column| pixel(row, column))).collect()
}

fn middle(values: &[f32], (width, height): (usize, usize), (columns, rows): (usize, usize)) -> Vec<f32> {
    let at = |k: usize, new: usize, old: usize| (2 * k + 1) * old / (2 * new);
    (0..rows)
        .flat_map(|y| (0..columns).map(move |x| (x, y)))
        .map(|(x, y)| values[at(y, rows, height) * width + at(x, columns, width)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(name: &str, values: impl IntoIterator<Item = f32>) -> Layer {
        Layer::scalar(name, "Y", values.into_iter().collect())
    }

    fn values(layer: Layer) -> Vec<f32> {
        layer.channels.into_iter().next().unwrap().1
    }

    #[test]
    fn a_crop_is_the_part_that_was_asked_for() {
        let whole = layer("a", (0..12).map(|i| i as f32));
        let part = Rectangle { x: 1, y: 1, width: 2, height: 2 };
        assert_eq!(values(whole.crop(4, &part)), [5.0, 6.0, 9.0, 10.0]);
        let all = Rectangle { x: 0, y: 0, width: 4, height: 3 };
        assert_eq!(whole.crop(4, &all), whole);
    }

    #[test]
    fn smaller_pixels_are_means_of_what_they_cover() {
        let whole = layer("a", [1.0, 3.0, 5.0, 7.0, 1.0, 3.0, 5.0, 7.0]);
        assert_eq!(values(whole.shrink((4, 2), (2, 1))), [2.0, 6.0]);
        // Each covers one pixel and a half.
        let thirds = values(layer("a", [3.0, 0.0, 6.0]).shrink((3, 1), (2, 1)));
        assert!((thirds[0] - 2.0).abs() < 1e-6 && (thirds[1] - 4.0).abs() < 1e-6, "{thirds:?}");
        for (size, smaller) in [((7, 5), (3, 2)), ((640, 3), (333, 1)), ((10, 10), (10, 10))] {
            let flat = values(layer("a", vec![0.7; size.0 * size.1]).shrink(size, smaller));
            assert!(flat.len() == smaller.0 * smaller.1 && flat.iter().all(|x| (x - 0.7).abs() < 1e-6), "{size:?}");
        }
    }

    #[test]
    fn the_mean_of_four_varies_a_quarter_as_much() {
        assert_eq!(values(layer("variance", [4.0; 16]).shrink((4, 4), (2, 2))), [1.0; 4]);
    }

    #[test]
    fn ids_are_not_averaged() {
        let ids = layer("guide.state", (0..16).map(|i| (i * i) as f32));
        let small = values(ids.shrink((4, 4), (2, 2)));
        assert!(small.iter().all(|id| values(ids.clone()).contains(id)), "{small:?}");
        assert_eq!(small, [25.0, 49.0, 169.0, 225.0]);
    }
}
