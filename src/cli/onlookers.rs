//! All that looks at a render while it goes on.

use super::checkpointer::Checkpointer;
use super::page::{Page, PageOnlooker};
use super::preview::Preview;
use super::progress::Status;
use super::render_arguments::DisplayArguments;
use super::tev::{Tev, TevOnlooker};
use crate::format::SceneFile;
use crate::image::Layer;
use crate::render::{Moment, Occasion, Onlooker, Stop};
use anyhow::Result;
use std::path::PathBuf;

/// Where pictures are shown beside files, for as long as the command runs.
pub(super) struct Displays {
    page: Option<Page>,
    tev: Option<Tev>,
}

impl Displays {
    /// # Errors
    /// Where a page cannot be served, or tev does not answer.
    pub(super) fn open(asked: &DisplayArguments, name: &str, description: &SceneFile, quiet: bool) -> Result<Displays> {
        let tev = asked.tev.as_ref().map(|address| Tev::connect(address, name, quiet)).transpose()?;
        let page = asked.serve.as_ref().map(|address| Page::open(address, name, description, quiet)).transpose()?;
        Ok(Displays { page, tev })
    }

    /// Shows how far the command is.
    pub(super) fn follow(&self, status: impl Fn() -> Status) {
        self.page.iter().for_each(|page| page.follow(status()));
    }

    /// Shows a finished picture, unless `stop` is urgent.
    pub(super) fn show(&self, layers: impl Fn() -> Vec<Layer>, size: [u32; 2], stop: &Stop) {
        self.tev.iter().for_each(|tev| tev.show_layers(&layers, size, stop));
    }

    /// Says that the command ends and how, and lets those who watch have the last picture, unless `stop` is urgent.
    pub(super) fn end(&self, how: &str, stop: &Stop) {
        self.page.iter().for_each(|page| page.end(how, stop));
    }
}

/// Previews, displays and checkpoints, where they are asked for.
pub(super) struct Onlookers {
    preview: Option<Preview>,
    page: Option<PageOnlooker>,
    tev: Option<TevOnlooker>,
    checkpointer: Option<Checkpointer>,
    /// Which of them wants to look, in the order of [`Self::all`].
    due: [bool; 4],
}

impl Onlookers {
    pub(super) fn new(
        preview: Option<Preview>,
        displays: &Displays,
        description: &SceneFile,
        checkpointer: Option<Checkpointer>,
    ) -> Onlookers {
        let page = displays.page.as_ref().map(|page| page.onlooker(&description.scene.film));
        let tev = displays.tev.as_ref().map(Tev::onlooker);
        Onlookers { preview, page, tev, checkpointer, due: [false; 4] }
    }

    /// Waits until all is in its file, unless `stop` is urgent; the checkpoint, where it holds the end of the render.
    pub(super) fn finish(mut self, stop: &Stop) -> Option<PathBuf> {
        self.preview.iter_mut().for_each(|preview| preview.settle(stop));
        self.page.iter_mut().for_each(|page| page.settle(stop));
        self.tev.iter_mut().for_each(|tev| tev.settle(stop));
        self.checkpointer.as_ref().and_then(Checkpointer::written).map(PathBuf::from)
    }

    /// A signal that comes again ends the program: what cannot be made again comes first.
    fn all(&mut self) -> [Option<&mut dyn Onlooker>; 4] {
        let Onlookers { preview, page, tev, checkpointer, .. } = self;
        [
            checkpointer.as_mut().map(|it| it as &mut dyn Onlooker),
            preview.as_mut().map(|it| it as &mut dyn Onlooker),
            page.as_mut().map(|it| it as &mut dyn Onlooker),
            tev.as_mut().map(|it| it as &mut dyn Onlooker),
        ]
    }
}

impl Onlooker for Onlookers {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        self.due = self.all().map(|onlooker| onlooker.is_some_and(|onlooker| onlooker.is_due(occasion)));
        self.due.contains(&true)
    }

    fn look(&mut self, moment: &Moment) {
        let due = self.due;
        let wanting = self.all().into_iter().zip(due).filter(|(_, due)| *due);
        for (k, onlooker) in wanting.filter_map(|(onlooker, _)| onlooker).enumerate() {
            // whoever looks first may take so long that somebody becomes impatient: the picture itself is next
            if k == 0 || !moment.stop().is_urgent() {
                onlooker.look(moment);
            }
        }
    }

    fn keeps_state(&self) -> bool {
        self.checkpointer.is_some()
    }

    fn wants_error(&self) -> bool {
        self.page.is_some()
    }
}
