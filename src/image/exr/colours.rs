//! Which channels of a file are a picture's colours.

use super::ExrFile;

impl ExrFile {
    /// Channels of colours, with that of alpha where there is one: those of `layer`, else those without a layer, else those of a
    /// layer that holds colours. Also says which one that is where there are several.
    ///
    /// # Errors
    /// A message where there are none.
    pub(crate) fn colour_channels(
        &self,
        layer: Option<&str>,
    ) -> std::result::Result<(Vec<String>, Option<String>), String> {
        let coloured: Vec<&str> = self.layer_names().into_iter().filter(|name| self.has_colours(name)).collect();
        let (chosen, note) = match layer {
            Some(name) if self.has_colours(name) || self.has_grey(name) => (name, None),
            Some(name) => {
                return Err(format!("there is no layer `{name}` of colours; layers of colours: {coloured:?}"));
            }
            None if coloured.contains(&"") || coloured.is_empty() => ("", None),
            None => {
                // Blender's name for the picture itself
                let combined = coloured.iter().find(|name| name.ends_with("Combined"));
                let chosen = *combined.unwrap_or(&coloured[0]);
                let note = format!("of its layers {coloured:?}, `{chosen}` is read; FILE.exr:LAYER chooses another");
                (chosen, (coloured.len() > 1).then_some(note))
            }
        };
        let mut names: Vec<String> = if self.has_grey(chosen) { vec!["Y"] } else { vec!["R", "G", "B"] }
            .into_iter()
            .map(|channel| full_name(chosen, channel))
            .collect();
        if let Some(missing) = names.iter().find(|name| !self.channels.contains_key(*name)) {
            return Err(format!("lacks channel {missing}"));
        }
        names.extend(Some(full_name(chosen, "A")).filter(|alpha| self.channels.contains_key(alpha)));
        Ok((names, note))
    }

    fn has_colours(&self, layer: &str) -> bool {
        ["R", "G", "B"].iter().all(|channel| self.channels.contains_key(&full_name(layer, channel)))
    }

    /// Whether there is a luminance and no red.
    fn has_grey(&self, layer: &str) -> bool {
        let has = |channel| self.channels.contains_key(&full_name(layer, channel));
        has("Y") && !has("R")
    }

    /// What stands before the last full stop of channels' names, each once.
    fn layer_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> =
            self.channels.keys().map(|name| name.rsplit_once('.').map_or("", |(layer, _)| layer)).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

fn full_name(layer: &str, channel: &str) -> String {
    if layer.is_empty() { channel.to_string() } else { format!("{layer}.{channel}") }
}
