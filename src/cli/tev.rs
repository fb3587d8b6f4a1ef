//! The picture so far in tev, a viewer that is told of pictures by TCP.

use super::address::Address;
use super::beside::Beside;
use super::progress::say;
use crate::film::accumulate::Estimate;
use crate::image::Layer;
use crate::io::clock::WallClock;
use crate::render::{Moment, Occasion, Onlooker, Stop};
use anyhow::{Context as _, Result};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tev_client::{PacketCloseImage, PacketCreateImage, PacketUpdateImage, TevClient};

/// Seconds between two pictures.
const EVERY: f64 = 1.0;
/// What does not answer or take anything for so long is given up.
const PATIENCE: Duration = Duration::from_secs(10);

const COLORS: [&str; 3] = ["R", "G", "B"];

/// A connection to tev.
#[derive(Clone)]
pub(super) struct Tev(Arc<Mutex<Link>>);

struct Link {
    /// `None` once it is lost.
    client: Option<TevClient>,
    /// Of the picture.
    name: String,
    shown: Shown,
    quiet: bool,
}

/// What tev has of the picture, with the channels that it was made with.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shown {
    Nothing,
    Colors,
    Layers,
}

impl Tev {
    /// # Errors
    /// Where no tev answers at that address.
    pub(super) fn connect(address: &Address, name: &str, quiet: bool) -> Result<Tev> {
        let open = || {
            let stream = address.connect(PATIENCE)?;
            stream.set_write_timeout(Some(PATIENCE))?;
            stream.set_nodelay(true)?;
            io::Result::Ok(TevClient::wrap(stream))
        };
        let client = open().with_context(|| {
            format!("no tev answers at {address}: start tev first, or name by --tev=HOST:PORT where it listens")
        })?;
        // the protocol ends names by a zero
        let name = name.replace('\0', " ");
        Ok(Tev(Arc::new(Mutex::new(Link { client: Some(client), name, shown: Shown::Nothing, quiet }))))
    }

    /// What shows it the picture of a render.
    pub(super) fn onlooker(&self) -> TevOnlooker {
        TevOnlooker { tev: self.clone(), sender: Beside::new("tev", EVERY) }
    }

    fn with(&self, send: impl FnOnce(&mut Link) -> io::Result<()>) {
        let mut link = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Err(error) = send(&mut link) {
            link.client = None;
            if !link.quiet {
                say(&format!("warning: tev takes no pictures any more: {error}; the render goes on"));
            }
        }
    }

    /// Shows the finished picture with all of its layers, unless `stop` is urgent, or once it is.
    pub(super) fn show_layers(&self, layers: impl FnOnce() -> Vec<Layer>, size: [u32; 2], stop: &Stop) {
        if !stop.is_urgent() {
            let (tev, layers) = (self.clone(), layers());
            let mut sender = Beside::new("tev", EVERY);
            sender.begin(WallClock::start(), move || tev.with(|link| link.send_layers(&layers, size)));
            sender.settle_unless(stop);
        }
    }
}

impl Link {
    fn send_picture(&mut self, picture: &Estimate) -> io::Result<()> {
        let Estimate { width, height, .. } = *picture;
        if self.shown != Shown::Colors {
            self.make(&COLORS, [width, height])?;
            self.shown = Shown::Colors;
        }
        let Link { client: Some(client), name: image_name, .. } = self else { return Ok(()) };
        client.send(PacketUpdateImage {
            image_name,
            grab_focus: false,
            channel_names: &COLORS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3; 3],
            x: 0,
            y: 0,
            width,
            height,
            data: bytemuck::cast_slice(&picture.mean),
        })
    }

    /// Makes a black picture with these channels, in place of the one there is.
    fn make(&mut self, channel_names: &[impl AsRef<str>], [width, height]: [u32; 2]) -> io::Result<()> {
        let Link { client: Some(client), name: image_name, shown, .. } = self else { return Ok(()) };
        let grab_focus = *shown == Shown::Nothing;
        if *shown != Shown::Nothing {
            client.send(PacketCloseImage { image_name })?;
        }
        client.send(PacketCreateImage { image_name, grab_focus, width, height, channel_names })
    }

    fn send_layers(&mut self, layers: &[Layer], [width, height]: [u32; 2]) -> io::Result<()> {
        let channels = || layers.iter().flat_map(|layer| layer.channels.iter().map(move |channel| (layer, channel)));
        let names: Vec<String> = channels().map(|(layer, (suffix, _))| layer.channel_name(suffix)).collect();
        self.make(&names, [width, height])?;
        self.shown = Shown::Layers;
        let Link { client: Some(client), name: image_name, .. } = self else { return Ok(()) };
        for (name, (_, (_, data))) in names.iter().zip(channels()) {
            client.send(PacketUpdateImage {
                image_name,
                grab_focus: false,
                channel_names: &[name],
                channel_offsets: &[0],
                channel_strides: &[1],
                x: 0,
                y: 0,
                width,
                height,
                data,
            })?;
        }
        Ok(())
    }
}

/// Sends pictures, beside a render that goes on meanwhile.
pub(super) struct TevOnlooker {
    tev: Tev,
    sender: Beside<()>,
}

impl Onlooker for TevOnlooker {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        // the last picture comes with its layers
        occasion == Occasion::Between && self.sender.is_due(occasion)
    }

    fn look(&mut self, moment: &Moment) {
        let clock = WallClock::start();
        let (tev, picture) = (self.tev.clone(), moment.picture());
        self.sender.begin(clock, move || tev.with(|link| link.send_picture(&picture)));
    }
}

impl TevOnlooker {
    /// Waits for the newest picture, unless `stop` is urgent.
    pub(super) fn settle(&mut self, stop: &Stop) {
        self.sender.settle_unless(stop);
    }
}
