//! The scenes of a comparison, loaded once, and what each method makes of them.

use super::plan::{Plan, SceneEntry};
use super::store::plan_hash;
use crate::format::SceneFile;
use crate::guiding::settings::GuidingSettings;
use crate::integrator::IntegratorSettings;
use crate::platform::Platform;
use crate::render::{RenderSettings, Settings};
use crate::scene::Scene;
use crate::{Error, Result};
use rustc_hash::FxHashMap;

/// All scenes and methods of a plan.
#[derive(Default)]
pub(crate) struct SceneCache {
    /// By scene of the plan: the scene as it is, and as each method has it.
    plain: Vec<Set>,
    methods: Vec<Vec<Set>>,
    /// Where the reference is made of another scene.
    references: Vec<Option<Set>>,
    scenes: Vec<Scene>,
}

/// A description and which of the loaded scenes it is.
struct Set {
    description: SceneFile,
    scene: usize,
}

impl SceneCache {
    /// Reads all settings, then loads what they name; methods that change only how light is sought share a scene. Also
    /// returns warnings.
    ///
    /// # Errors
    /// Wrong settings, with their places; scenes that cannot be loaded; a method that changes the picture's size.
    pub(crate) fn load(plan: &Plan, threads: usize) -> Result<(SceneCache, Vec<String>)> {
        let mut warnings = Vec::new();
        let mut described = Vec::new();
        for entry in &plan.scenes {
            let (plain, more) = plan.describe(entry, None)?;
            warnings.extend(more);
            let of_method = |method| Ok(plan.describe(entry, Some(method))?.0);
            let methods: Vec<SceneFile> = plan.methods.iter().map(of_method).collect::<Result<_>>()?;
            check_sizes(plan, &plain, &methods)?;
            let reference = plan.describe_reference(entry)?.map(|(description, _)| description);
            check_reference(entry, &plain, reference.as_ref())?;
            described.push((plain, methods, reference));
        }
        let mut loader = Loader { threads, scenes: Vec::new(), known: FxHashMap::default(), warnings };
        let mut scene_cache = SceneCache::default();
        for (plain, methods, reference) in described {
            scene_cache.plain.push(loader.set(plain)?);
            scene_cache.methods.push(methods.into_iter().map(|d| loader.set(d)).collect::<Result<_>>()?);
            scene_cache.references.push(reference.map(|d| loader.set(d)).transpose()?);
        }
        scene_cache.scenes = loader.scenes;
        Ok((scene_cache, loader.warnings))
    }

    /// A scene without any method's changes.
    pub(crate) fn plain(&self, scene: usize) -> (&Scene, &SceneFile) {
        self.set(&self.plain[scene])
    }

    /// What a scene's reference is made of.
    pub(crate) fn reference(&self, scene: usize) -> (&Scene, &SceneFile) {
        self.set(self.references[scene].as_ref().unwrap_or(&self.plain[scene]))
    }

    /// A scene as a method has it.
    pub(crate) fn with_method(&self, scene: usize, method: usize) -> (&Scene, &SceneFile) {
        self.set(&self.methods[scene][method])
    }

    fn set<'a>(&'a self, set: &'a Set) -> (&'a Scene, &'a SceneFile) {
        (&self.scenes[set.scene], &set.description)
    }

    /// What all scenes are rendered with.
    ///
    /// # Panics
    /// Where the plan has no scene.
    pub(crate) fn platform(&self) -> Platform {
        Platform::of(self.scenes[0].geometry().device())
    }

    /// Tells comparisons apart: the plan, what was loaded, all settings, and what figures depend on beside them.
    pub(crate) fn plan_hash(&self, plan: &Plan) -> String {
        let text = |set: &Set| {
            let d = &set.description;
            let render = RenderSettings { spp: 0, time: None, seed: 0, ..d.render.clone() };
            let scene = self.scenes[set.scene].hash_text();
            format!("{scene} {:?} {:?} {render:?} {:?}", d.integrator, d.guiding, d.scene.film.exposure)
        };
        let mut contents: Vec<String> = self.plain.iter().chain(self.methods.iter().flatten()).map(text).collect();
        contents.extend(self.references.iter().flatten().map(text));
        contents.extend(plan.scenes.iter().filter_map(|s| Some(format!("{} {}", s.name(), s.samples?))));
        let Platform { compiled_for, embree, embree_isa, .. } = self.platform();
        contents.push(format!("{compiled_for} {embree} {embree_isa}"));
        plan_hash(plan, &contents)
    }
}

/// What to render a description with.
pub(crate) fn settings(description: &SceneFile) -> Settings {
    Settings {
        integrator: description.integrator.clone(),
        guiding: description.guiding.clone(),
        render: description.render.clone(),
    }
}

fn check_sizes(plan: &Plan, plain: &SceneFile, methods: &[SceneFile]) -> Result<()> {
    let size = |d: &SceneFile| (d.scene.film.width, d.scene.film.height);
    match methods.iter().position(|m| size(m) != size(plain)) {
        None => Ok(()),
        Some(index) => Err(Error::Scene(format!(
            "the method `{}` changes the picture's size, so that there is nothing to compare: --set changes it for all",
            plan.methods[index].name
        ))),
    }
}

fn check_reference(entry: &SceneEntry, plain: &SceneFile, reference: Option<&SceneFile>) -> Result<()> {
    let size = |d: &SceneFile| (d.scene.film.width, d.scene.film.height);
    match reference {
        Some(other) if size(other) != size(plain) => {
            Err(Error::Scene(format!("{}: the scene of its reference has a picture of another size", entry.name())))
        }
        _ => Ok(()),
    }
}

struct Loader {
    threads: usize,
    scenes: Vec<Scene>,
    /// Indices by what a scene is made of.
    known: FxHashMap<String, usize>,
    warnings: Vec<String>,
}

impl Loader {
    fn set(&mut self, description: SceneFile) -> Result<Set> {
        let key = format!(
            "{:?}",
            SceneFile {
                integrator: IntegratorSettings::default(),
                guiding: GuidingSettings::default(),
                render: RenderSettings { build: description.render.build, ..RenderSettings::default() },
                ..description.clone()
            }
        );
        if let Some(&scene) = self.known.get(&key) {
            return Ok(Set { description, scene });
        }
        let (scene, more) = description.load_scene(self.threads)?;
        self.warnings.extend(more);
        self.scenes.push(scene);
        self.known.insert(key, self.scenes.len() - 1);
        Ok(Set { description, scene: self.scenes.len() - 1 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::compare::plan::{Budget, Draft, parse_set, plain_scene};
    use std::path::Path;

    fn plan(methods: &[&str], set: &[&str]) -> Plan {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
        let draft = Draft {
            scenes: vec![plain_scene(&path)],
            methods: methods.iter().map(|m| m.to_string()).collect(),
            overrides: set.iter().map(|text| parse_set(text).unwrap()).collect(),
            budgets: vec![Budget::Samples(4)],
            ..Draft::default()
        };
        draft.finish().unwrap()
    }

    #[test]
    fn methods_share_a_scene_unless_they_change_it() {
        let plan = plan(
            &["none", "grid", "sweep:film.filter=tent;render.robust=true,false", "sweep:render.build_quality=low"],
            &[],
        );
        let (scene_cache, _) = SceneCache::load(&plan, 1).unwrap();
        assert_eq!(scene_cache.scenes.len(), 4, "box, tent and robust, tent, and built otherwise");
        assert!(std::ptr::eq(scene_cache.plain(0).0, scene_cache.with_method(0, 1).0));
        assert!(!std::ptr::eq(scene_cache.with_method(0, 2).0, scene_cache.with_method(0, 3).0));
    }

    #[test]
    fn plans_are_told_apart_by_what_they_measure_and_not_by_how_often() {
        let hash = |plan: &Plan| SceneCache::load(plan, 1).unwrap().0.plan_hash(plan);
        let first = plan(&["none", "grid"], &[]);
        let one = hash(&first);
        assert_eq!(one, hash(&Plan { runs: 9, title: "other".into(), ..first.clone() }));
        assert_ne!(one, hash(&Plan { seed: 1, ..first.clone() }));
        let mut capped = first.clone();
        capped.scenes[0].samples = Some(1);
        assert_ne!(one, hash(&capped));
        assert_ne!(one, hash(&Plan { budgets: vec![Budget::Samples(8)], ..first }));
        assert_ne!(one, hash(&plan(&["none", "grid"], &["guiding.memory=1 MiB"])));
        assert_ne!(one, hash(&plan(&["none", "grid"], &["film.width=32"])));
        assert_ne!(one, hash(&plan(&["grid", "none"], &[])));
    }

    #[test]
    fn methods_that_cannot_be_compared_are_refused() {
        let error = SceneCache::load(&plan(&["none", "sweep:film.width=32"], &[]), 1).err().unwrap().to_string();
        assert!(error.contains("`width=32` changes the picture's size"), "{error}");
        let mut other = plan(&["none"], &["film.width=32", "film.height=32"]);
        other.scenes[0].reference_scene = Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/furnace.toml"));
        assert!(
            SceneCache::load(&other, 1)
                .is_ok_and(|(scene_cache, _)| !std::ptr::eq(scene_cache.plain(0).0, scene_cache.reference(0).0))
        );
        other.scenes[0].overrides = vec![parse_set("film.width=16").unwrap()];
        let error = SceneCache::load(&other, 1).err().unwrap().to_string();
        assert!(error.contains("cornell: the scene of its reference"), "{error}");
    }
}
