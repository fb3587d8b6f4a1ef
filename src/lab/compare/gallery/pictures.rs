//! What a cell looks like: its worst run beside the reference.

use super::matrix::Matrix;
use crate::image::exr::read_rgb;
use crate::image::{Image, ViewTransform, png};
use crate::lab::compare::executor::worst_path;
use crate::lab::compare::plan::{Plan, file_stem};
use crate::lab::compare::scene_cache::SceneCache;
use crate::lab::compare::store::Store;
use crate::math::Rgb;
use crate::{Error, Result};
use std::path::Path;

/// Pixels on the screen along each side of one of the picture, and between the two pictures.
const ENLARGED: usize = 4;
const GAP: usize = 8;

/// Writes a PNG for each cell into `pictures/` and names it in the matrix.
///
/// # Errors
/// Pictures that cannot be read or written.
pub(crate) fn write(
    matrix: &mut Matrix,
    plan: &Plan,
    scene_cache: &SceneCache,
    store: &Store,
    folder: &Path,
) -> Result<()> {
    let pictures = folder.join("pictures");
    std::fs::create_dir_all(&pictures).map_err(Error::io(&pictures))?;
    for (scene, entry) in plan.scenes.iter().enumerate() {
        let name = entry.name();
        let Some(reference) = store.reference(&name) else { continue };
        let reference = read_rgb(&reference.file(folder))?;
        let film = &scene_cache.plain(scene).1.scene.film;
        let view = ViewTransform::of(film.exposure, film.tone, &reference);
        for (index, method) in plan.methods.iter().enumerate() {
            let path = worst_path(folder, plan, scene, index);
            let own = |cell: &&mut super::matrix::MatrixCell| cell.scene == name && cell.method == method.name;
            let Some(cell) = matrix.cells.iter_mut().find(own).filter(|_| path.exists()) else { continue };
            let file = format!("{}_{}.png", file_stem(&name), file_stem(&method.name));
            png::write(&pictures.join(&file), &beside(&read_rgb(&path)?, &reference), &view, &[])?;
            cell.picture = Some(format!("pictures/{file}"));
        }
    }
    Ok(())
}

/// Two pictures of one size, enlarged without blending, the first on the left.
fn beside(left: &Image, right: &Image) -> Image {
    let (width, height) = (left.width * ENLARGED, left.height * ENLARGED);
    let mut both = Image { width: 2 * width + GAP, height, data: vec![Rgb::ZERO; (2 * width + GAP) * height] };
    for (i, pixel) in both.data.iter_mut().enumerate() {
        let (x, y) = (i % (2 * width + GAP), i / (2 * width + GAP));
        if x < width {
            *pixel = left.pixel(x / ENLARGED, y / ENLARGED);
        } else if x >= width + GAP {
            *pixel = right.pixel((x - width - GAP) / ENLARGED, y / ENLARGED);
        }
    }
    both
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pictures_stand_side_by_side() {
        let level = |value: f32| Image { width: 2, height: 1, data: vec![Rgb::ZERO, Rgb::splat(value)] };
        let both = beside(&level(1.0), &level(2.0));
        assert_eq!((both.width, both.height), (2 * 2 * ENLARGED + GAP, ENLARGED));
        let row: Vec<f32> = (0..both.width).map(|x| both.pixel(x, ENLARGED - 1).x).collect();
        let count = |value: f32| row.iter().filter(|v| **v == value).count();
        assert_eq!((count(1.0), count(2.0)), (ENLARGED, ENLARGED));
        assert_eq!((row[ENLARGED], row[both.width - 1]), (1.0, 2.0));
    }
}
