//! What an unknown option may have meant.

use crate::document::nearest;
use crate::format::reference::setting_keys;
use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Adds to an error about an unknown option the key of the scene file that has this name, or nearly.
pub(crate) fn add(error: &mut clap::Error) {
    if error.kind() != ErrorKind::UnknownArgument {
        return;
    }
    let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg) else { return };
    if error.get(ContextKind::SuggestedArg).is_some() {
        return;
    }
    let Some(hint) = hint(option.trim_start_matches('-').split('=').next().unwrap_or_default()) else { return };
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()]));
}

/// What to write instead of the option `name`.
fn hint(name: &str) -> Option<String> {
    let (name, keys) = (name.replace('-', "_"), setting_keys());
    let last = |key: &'_ str| key.rsplit_once('.').map_or(key.to_string(), |(_, last)| last.to_string());
    let lasts: Vec<String> = keys.iter().map(|key| last(key)).collect();
    let lasts: Vec<&str> = lasts.iter().map(String::as_str).collect();
    let nearest = nearest(&name, &lasts)?;
    let fitting: Vec<String> =
        keys.iter().filter(|key| last(key) == nearest).map(|key| format!("--set {key}=…")).collect();
    let size = if matches!(nearest, "width" | "height") { "--size WIDTHxHEIGHT or " } else { "" };
    Some(format!("render and inspect take {size}{}", fitting.join(" or ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_by_their_names_and_nearly_so() {
        let says = |name: &str| hint(name).unwrap_or_default();
        assert!(says("width").contains("--size") && says("width").contains("--set film.width=…"), "{}", says("width"));
        assert!(says("max-depth").contains("--set integrator.max_depth=…"), "{}", says("max-depth"));
        assert!(says("maxdepth").contains("integrator.max_depth") && says("fov").contains("camera.vfov"));
        assert_eq!(hint("supercalifragilistic"), None);
    }
}
