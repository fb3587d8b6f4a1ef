//! The picture so far, while a render goes on.

use super::{TINY, folder, names, phototaxis, scene, stderr};
use phototaxis::image::exr::read_layers;
use std::path::Path;

/// Renders a scene of the project, tiny; what it printed on standard error.
fn render(here: &Path, arguments: &[&str]) -> String {
    let mut command = phototaxis(here);
    let command = command.arg("render").arg(scene("cornell.toml")).args(TINY).args(["--spp", "16"]).args(arguments);
    stderr(command.assert().code(0).get_output()).to_string()
}

#[test]
fn the_last_preview_is_the_picture_and_previews_change_no_picture() {
    let here = folder();
    let looks = ["--exposure", "1.5", "--tone", "agx"];
    let written = render(
        here.path(),
        &[&looks[..], &["-o", "a.png", "-o", "a.exr", "--preview", "p.png", "--every", "1ms"]].concat(),
    );
    assert!(!written.contains("warning"), "{written}");
    render(here.path(), &["-o", "b.exr", "--preview", "p.exr"]);
    render(here.path(), &["-o", "c.exr"]);
    assert_eq!(names(here.path()), ["a.exr", "a.png", "b.exr", "c.exr", "p.exr", "p.png"]);
    let bytes = |name: &str| std::fs::read(here.path().join(name)).unwrap();
    assert_eq!(bytes("a.png"), bytes("p.png"));
    let [a, b, c, p] =
        ["a.exr", "b.exr", "c.exr", "p.exr"].map(|name| read_layers(&here.path().join(name)).unwrap().channels);
    assert!(a == c && b == c, "previews change the picture");
    assert_eq!(p.keys().collect::<Vec<_>>(), ["A", "B", "G", "R", "samples.Y"]);
    p.iter().for_each(|(name, values)| assert!(values == &c[name], "{name}"));
}

#[test]
fn a_preview_that_cannot_be_written_is_told_of_once_and_the_render_goes_on() {
    if !Path::new("/dev/full").exists() {
        eprintln!("SKIPPED: this system has no full disk");
        return;
    }
    let here = folder();
    std::os::unix::fs::symlink("/dev/full", here.path().join("p.png")).unwrap();
    let said = render(here.path(), &["-o", "a.exr", "--preview", "p.png", "--every", "1ms"]);
    assert!(
        said.matches("warning").count() == 1 && said.contains("p.png") && said.contains("the render goes on"),
        "{said}"
    );
    let quiet = render(here.path(), &["-q", "-o", "a.exr", "--preview", "p.png", "--every", "1ms"]);
    assert_eq!(quiet, "");
}

#[test]
fn previews_that_could_never_be_written_are_refused() {
    let here = folder();
    for (preview, why) in [("p.jpg", "as .exr or .png"), ("none/p.png", "its folder does not exist")] {
        let mut command = phototaxis(here.path());
        command.arg("render").arg(scene("cornell.toml")).args(["--preview", preview]);
        let said = stderr(command.assert().code(1).get_output()).to_string();
        assert!(said.contains(why), "{said}");
    }
    let mut command = phototaxis(here.path());
    command.arg("render").arg(scene("cornell.toml")).args(["--every", "3s"]).assert().code(2);
}
