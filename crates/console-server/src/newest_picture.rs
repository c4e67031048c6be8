//! The newest picture of the video for programs: encoded when a program asks, once for all that ask.
//!
//! The run loop replaces a shared pointer and waits for nothing. At most one plain and one drawn picture are
//! encoded at a time, on a thread of their own. A program that goes away leaves the picture to the next one.

use std::sync::{Arc, Mutex, PoisonError};

use barrelman_overlay::{Overlay, Scene};
use barrelman_pilot::Outcome;
use barrelman_video::jpeg;
use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PictureSize, Timestamp, VehicleRates, VideoFrame};
use bytes::Bytes;

/// Whether box, ellipse and mode are drawn into the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Drawing {
    /// The picture as it was received.
    Plain,
    /// With the drawings of a film.
    Overlay,
}

/// A JPEG file of a video frame.
#[derive(Debug, Clone, Default)]
pub(super) struct StillPicture {
    pub(super) jpeg: Bytes,
    pub(super) captured: Timestamp,
}

/// A video frame with what the pilot made of it.
#[derive(Debug)]
struct Shown {
    /// Counts the frames from 1: those of a new drive begin with the sequence 0 again.
    number: u64,
    frame: VideoFrame,
    outcome: Outcome,
    rates: VehicleRates,
}

/// The newest video frame, and the newest JPEG files of one.
#[derive(Debug, Default)]
pub(super) struct NewestPicture {
    shown: Mutex<Option<Arc<Shown>>>,
    plain: Arc<tokio::sync::Mutex<Encoder>>,
    drawn: Arc<tokio::sync::Mutex<Encoder>>,
}

impl NewestPicture {
    pub(super) fn put(&self, frame: &VideoFrame, outcome: &Outcome, rates: VehicleRates) {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let number = shown.as_ref().map_or(0, |before| before.number) + 1;
        *shown = Some(Arc::new(Shown { number, frame: frame.clone(), outcome: outcome.clone(), rates }));
    }

    /// The newest picture. `time_of_day`: that of a time of capture, for the drawings. `None`: there is no
    /// picture yet.
    ///
    /// # Errors
    /// If the picture cannot be encoded.
    pub(super) async fn get(
        &self,
        drawing: Drawing,
        time_of_day: impl FnOnce(Timestamp) -> Option<String> + Send + 'static,
    ) -> Result<Option<StillPicture>, String> {
        let Some(asked) = self.newest() else { return Ok(None) };
        let encoder = match drawing {
            Drawing::Plain => &self.plain,
            Drawing::Overlay => &self.drawn,
        };
        let mut encoder = Arc::clone(encoder).lock_owned().await;
        if encoder.number < asked.number {
            let shown = self.newest().unwrap_or(asked);
            let work = move || {
                let time_of_day = time_of_day(shown.frame.capture.at);
                encoder.encode(&shown, drawing, time_of_day.as_deref())
            };
            return tokio::task::spawn_blocking(work).await.map_err(|error| error.to_string())?.map(Some);
        }
        Ok(Some(encoder.newest.clone()))
    }

    fn newest(&self) -> Option<Arc<Shown>> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Draws and encodes, and keeps the newest result.
#[derive(Debug, Default)]
struct Encoder {
    /// Number of the frame of `newest`; 0: there is none.
    number: u64,
    newest: StillPicture,
    overlay: Overlay,
    /// The pictures that were encoded, for tests.
    #[cfg(test)]
    encoded: u64,
}

impl Encoder {
    fn encode(
        &mut self,
        shown: &Shown,
        drawing: Drawing,
        time_of_day: Option<&str>,
    ) -> Result<StillPicture, String> {
        let scene = match drawing {
            Drawing::Plain => None,
            Drawing::Overlay => Scene::from_outcome(&shown.outcome),
        };
        let jpeg = match scene {
            None => jpeg::encode(&shown.frame.picture),
            Some(scene) => {
                let mut drawn = Picture::black(PictureSize::new(2, 2), ColourEncoding::JPEG);
                let scene = Scene { rates: Some(shown.rates), time_of_day, ..scene };
                self.overlay.draw(&shown.frame, &scene, &mut drawn);
                jpeg::encode(&drawn)
            }
        };
        let jpeg = Bytes::from(jpeg.map_err(|error| format!("the picture cannot be encoded: {error}"))?);
        self.newest = StillPicture { jpeg, captured: shown.frame.capture.at };
        self.number = shown.number;
        #[cfg(test)]
        {
            self.encoded += 1;
        }
        Ok(self.newest.clone())
    }
}

#[cfg(test)]
mod tests {
    use barrelman_control::Region;
    use barrelman_vocab::profile::VehicleProfile;

    use super::super::in_memory::block_on;
    use super::*;
    use crate::test_scenes::{PICTURE, at, frame, idle};

    fn put(newest: &NewestPicture, ms: u64) {
        let region = Some(Region::from_shares(VehicleProfile::fotokite_pro().region, PICTURE));
        newest.put(&frame(0, at(ms)), &Outcome { region, ..idle(at(ms)) }, VehicleRates::REST);
    }

    fn get(newest: &NewestPicture, drawing: Drawing) -> StillPicture {
        block_on(newest.get(drawing, |_| None)).unwrap().unwrap()
    }

    #[test]
    fn before_the_first_picture_there_is_none() {
        assert!(block_on(NewestPicture::default().get(Drawing::Plain, |_| None)).unwrap().is_none());
    }

    #[test]
    fn a_picture_is_encoded_once_for_all_that_ask() {
        let newest = NewestPicture::default();
        put(&newest, 40);
        let first = get(&newest, Drawing::Plain);
        assert_eq!((&first.jpeg[..2], first.captured), (&[0xff, 0xd8][..], at(40)));
        let (second, third) = block_on(async {
            let ask = || newest.get(Drawing::Plain, |_| None);
            tokio::join!(ask(), ask())
        });
        assert_eq!(second.unwrap().unwrap().jpeg, first.jpeg);
        assert_eq!(third.unwrap().unwrap().jpeg, first.jpeg);
        assert_eq!(newest.plain.blocking_lock().encoded, 1);
        put(&newest, 80);
        assert_eq!(get(&newest, Drawing::Plain).captured, at(80));
        assert_eq!((newest.plain.blocking_lock().encoded, newest.drawn.blocking_lock().encoded), (2, 0));
    }

    #[test]
    fn the_region_and_the_mode_are_drawn_where_asked_for() {
        let newest = NewestPicture::default();
        put(&newest, 40);
        let (plain, drawn) = (get(&newest, Drawing::Plain), get(&newest, Drawing::Overlay));
        assert!(drawn.jpeg.len() > plain.jpeg.len() + 1000, "a black picture is small");
        assert_eq!(drawn.captured, at(40));
    }
}
