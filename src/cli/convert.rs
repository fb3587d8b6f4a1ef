//! `phototaxis convert`: a scene of any form that is read, as a scene file.

use super::choices::Definitions;
use super::progress::say;
use crate::format::mitsuba::export::Translation;
use crate::format::{self, SceneFile};
use anyhow::{Result, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub(crate) struct ConvertArguments {
    /// Scene (.toml, .json, .xml, .gltf, .glb, .pbrt) or model (.obj, .ply).
    scene: PathBuf,
    /// The scene file to write (.toml), or a scene of Mitsuba 3 (.xml); meshes and pictures go into the folder "NAME files"
    /// beside it.
    output: PathBuf,
    /// The camera of this name, of a scene with several. [default: that of [camera], else the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Overrides a key of the scene file, for example film.width=640; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    definitions: Definitions,
}

pub(crate) fn run(arguments: &ConvertArguments) -> Result<ExitCode> {
    let ConvertArguments { scene, output, camera, set, definitions } = arguments;
    let end = output.extension().map(|end| end.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !["toml", "xml"].contains(&&*end) {
        bail!("{}: a scene is written as .toml, or for Mitsuba as .xml", output.display());
    }
    let same = scene.canonicalize().is_ok_and(|from| output.canonicalize().is_ok_and(|to| from == to));
    if same {
        bail!("{}: the scene would be written over itself", output.display());
    }
    let overrides: Vec<String> = set.iter().cloned().chain(definitions.overrides()).collect();
    let (file, warnings) = format::load_seen_by(scene, camera.as_deref(), &overrides)?;
    let more = if end == "xml" { for_mitsuba(&file, output)? } else { format::write::write(&file, output)? };
    warnings.iter().chain(&more).for_each(|warning| say(&format!("warning: {warning}")));
    Ok(ExitCode::SUCCESS)
}

/// As a scene of Mitsuba's, where it has counterparts of all that is in it.
fn for_mitsuba(file: &SceneFile, output: &Path) -> crate::Result<Vec<String>> {
    let beside = format::write::folder_beside(output)?;
    let folder = beside.file_name().unwrap_or_default().to_string_lossy();
    let written = Translation::write_as(file, file.render.spp, output, &format!("{folder}/"));
    if written.is_err() {
        // only where nothing is in it
        _ = std::fs::remove_dir(&beside);
    }
    written.map(|_| Vec::new())
}
