//! A page that shows a render while it goes on, served on this machine.

mod board;
mod packed;
mod server;

use super::address::Address;
use super::beside::Beside;
use super::output::beauty;
use super::progress::{Status, say};
use crate::film::FilmSettings;
use crate::format::SceneFile;
use crate::image::ViewTransform;
use crate::io::clock::WallClock;
use crate::render::{Moment, Occasion, Onlooker, Stop};
use anyhow::{Context as _, Result};
use board::Board;
use server::Server;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Seconds between two pictures.
const EVERY: f64 = 2.0;
/// How long the end of a render waits for open pages to take the last picture.
const FAREWELL: Duration = Duration::from_secs(2);

/// The page, for as long as it is there.
pub(super) struct Page {
    board: Arc<Board>,
    _server: Server,
}

impl Page {
    /// Serves it, and says where.
    ///
    /// # Errors
    /// Where nothing can be served at that address, for example since the port is in use.
    pub(super) fn open(address: &Address, name: &str, description: &SceneFile, quiet: bool) -> Result<Page> {
        let listener = address.listen().with_context(|| format!("the page cannot be served at {address}"))?;
        let at = listener.local_addr().context("the page's own address")?;
        let board = Arc::new(Board::new(name, description.scene.film.tone));
        let server = Server::start(listener, address, board.clone()).context("serving the page")?;
        if !quiet {
            let open = if at.ip().is_loopback() { "" } else { " (whoever reaches this address sees the picture)" };
            say(&format!("watch the render at http://{at}/{open}"));
        }
        Ok(Page { board, _server: server })
    }

    /// Has the page show how far the render is.
    pub(super) fn follow(&self, status: Status) {
        self.board.change(|shown| shown.status = Some(status));
    }

    /// What shows it the picture of a render.
    pub(super) fn onlooker(&self, film: &FilmSettings) -> PageOnlooker {
        PageOnlooker { board: self.board.clone(), film: film.clone(), packer: Beside::new("page", EVERY) }
    }

    /// Tells open pages that the render has ended and how, and waits a little until they have the last picture; no more once `stop`
    /// is urgent.
    pub(super) fn end(&self, how: &str, stop: &Stop) {
        self.board.change(|shown| shown.ended = Some(how.to_owned()));
        let deadline = Instant::now() + FAREWELL;
        while self.board.is_waited_for() && Instant::now() < deadline && !stop.is_urgent() {
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Shows the page pictures, beside a render that goes on meanwhile.
pub(super) struct PageOnlooker {
    board: Arc<Board>,
    film: FilmSettings,
    packer: Beside<()>,
}

impl Onlooker for PageOnlooker {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        self.packer.is_due(occasion) && (occasion == Occasion::Last || self.board.is_watched())
    }

    fn look(&mut self, moment: &Moment) {
        let clock = WallClock::start();
        self.settle(moment.stop());
        let (board, film, picture, figures) =
            (self.board.clone(), self.film.clone(), moment.picture(), moment.figures());
        self.packer.begin(clock, move || {
            let image = beauty(&picture);
            let view = ViewTransform::of(film.exposure, film.tone, &image);
            let packed = packed::picture(&image, &view);
            board.change(|shown| shown.show(packed, figures));
        });
    }

    fn wants_error(&self) -> bool {
        true
    }
}

impl PageOnlooker {
    /// Waits for the newest picture, unless `stop` is urgent.
    pub(super) fn settle(&mut self, stop: &Stop) {
        self.packer.settle_unless(stop);
    }
}
