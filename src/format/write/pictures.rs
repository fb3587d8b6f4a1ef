//! Pictures that a written scene names: files stay where they are, what is in no file is written beside the scene.

use crate::image::Layer;
use crate::image::exr::{self, Metadata, Window};
use crate::image::picture::{Picture, Samples};
use crate::io::atomic::write_atomically;
use crate::texture::{EmbeddedPicture, EmbeddedPictures};
use crate::{Error, Result};
use image::{ExtendedColorType, ImageEncoder};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Pictures by the names under which a scene file finds them.
pub(super) struct Pictures<'a> {
    scene: &'a Path,
    folder: &'a Path,
    embedded: &'a EmbeddedPictures,
    /// Those that are to be written, by the path that stands for them.
    found: BTreeMap<PathBuf, (String, Arc<EmbeddedPicture>)>,
}

impl<'a> Pictures<'a> {
    /// `folder` is for pictures that are in no file, beside the `scene`.
    pub(crate) fn new(scene: &'a Path, folder: &'a Path, embedded: &'a EmbeddedPictures) -> Pictures<'a> {
        Pictures { scene, folder, embedded, found: BTreeMap::new() }
    }

    /// What the scene file says of a picture: a path from its own folder where that is possible, else an absolute one.
    pub(crate) fn name(&mut self, path: &Path) -> String {
        let Some(embedded) = self.embedded.get(path) else { return self.file(path) };
        let next = self.found.len();
        let folder = self.folder.file_name().unwrap_or_default().to_string_lossy();
        let (name, _) = self
            .found
            .entry(path.to_path_buf())
            .or_insert_with(|| (format!("{folder}/picture-{next}.{}", extension(embedded)), embedded.clone()));
        name.clone()
    }

    fn file(&self, path: &Path) -> String {
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        let folder = absolute(self.scene.parent().unwrap_or(Path::new("")));
        let path = absolute(path);
        path.strip_prefix(&folder).unwrap_or(&path).to_string_lossy().into_owned()
    }

    /// Writes those that are in no file.
    pub(crate) fn write(&self) -> Result<()> {
        for (name, picture) in self.found.values() {
            let path = self.scene.with_file_name(name);
            match &**picture {
                EmbeddedPicture::Encoded(bytes) => write_atomically(&path, |out| out.write_all(bytes))?,
                EmbeddedPicture::Decoded(picture) => write_decoded(&path, picture)?,
            }
        }
        Ok(())
    }
}

/// The end of the file's name, which is for people: content says what a picture is.
fn extension(picture: &EmbeddedPicture) -> &'static str {
    match picture {
        EmbeddedPicture::Encoded(bytes) if bytes.starts_with(b"\x89PNG") => "png",
        EmbeddedPicture::Encoded(bytes) if bytes.starts_with(b"\xff\xd8") => "jpg",
        EmbeddedPicture::Encoded(_) => "picture",
        EmbeddedPicture::Decoded(Picture { samples: Samples::F32(_), .. }) => "exr",
        EmbeddedPicture::Decoded(_) => "png",
    }
}

fn write_decoded(path: &Path, picture: &Picture) -> Result<()> {
    let (width, height) = (picture.width as u32, picture.height as u32);
    let channels = picture.channels;
    match &picture.samples {
        Samples::F32(_) => {
            let layer = Layer::color("", &picture.colors());
            exr::write(path, &Window::full(picture.width, picture.height), vec![layer], &Metadata::default())
        }
        Samples::U8(values, _) => {
            let color =
                [ExtendedColorType::L8, ExtendedColorType::La8, ExtendedColorType::Rgb8, ExtendedColorType::Rgba8];
            let mut bytes = Vec::new();
            let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
            let written = encoder.write_image(values, width, height, color[channels - 1]);
            written.map_err(|error| Error::file(path, error.to_string()))?;
            write_atomically(path, |out| out.write_all(&bytes))
        }
        Samples::U16(..) => Err(Error::file(path, "a picture of 16 bits that is in no file is not written")),
    }
}
