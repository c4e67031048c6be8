//! The elements in their order, and the pads at both ends that stand outside of any element.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use barrelman_media_protocol::channel::Channel;
use barrelman_media_protocol::decoder::{DecoderElement, FromDecoder};
use barrelman_media_protocol::role::DecoderSettings;
use gst::prelude::*;
use gstreamer as gst;

use super::choice::{self, NoDecoder};
use super::damage::LibavErrors;
use super::output::Output;

/// The caps of the metadata that carries a unit's time through the line. Elements that work on time stamps
/// may change the time stamp of a buffer where times go backwards; they pass metadata on as it is.
const UNIT_TIME: &str = "timestamp/x-barrelman-unit";

/// Attempts to begin with a unit. Where H.264 begins at a picture that is no IDR picture, libav fills the gap
/// in the frame numbers in front of it, at most 16 frames, and GStreamer's element lets it have three of them
/// a call.
const START_ATTEMPTS: usize = 7;

/// The elements from the parser to the output.
pub(super) struct Line {
    pipeline: gst::Pipeline,
    bus: gst::Bus,
    input: gst::Pad,
    /// The pad after the last element, which nothing else keeps.
    _end: gst::Pad,
    output: Arc<Mutex<Output>>,
    caps: gst::Caps,
    unit_time: gst::Caps,
    errors: Arc<LibavErrors>,
    element: DecoderElement,
    /// Whether the parser has found a picture in the unit.
    parsed: Arc<AtomicBool>,
    is_awaiting_key: bool,
    /// Whether the elements hold a stream.
    has_stream: bool,
}

impl Line {
    /// All elements, with the decoder opened. Nothing runs yet.
    pub(super) fn new(settings: DecoderSettings, channel: Channel) -> Result<Self, NoDecoder> {
        let format = settings.format;
        gst::init().map_err(|error| NoDecoder {
            reason: format!("GStreamer does not start: {error}"),
            remedy: "Install gstreamer1.0-plugins-base".to_owned(),
        })?;
        let errors = LibavErrors::watch();
        let (decoder, element) = choice::decoder(format).ok_or_else(|| NoDecoder {
            reason: format!("there is no decoder of {}", format.name()),
            remedy: format!("Install {}", choice::package(format)),
        })?;
        set_up(&decoder, settings.is_live);
        let parser = make(choice::parser(format), "gstreamer1.0-plugins-bad")?;
        let convert = make("videoconvert", "gstreamer1.0-plugins-base")?;
        convert.set_property_from_str("dither", "none");
        let scale = make("videoscale", "gstreamer1.0-plugins-base")?;
        let filter = make("capsfilter", "gstreamer1.0-plugins-base")?;
        let pipeline = gst::Pipeline::new();
        let elements = [&parser, &decoder, &convert, &scale, &filter];
        pipeline.add_many(elements).map_err(unlinked)?;
        gst::Element::link_many(elements).map_err(unlinked)?;
        let output = Arc::new(Mutex::new(Output::new(channel, errors.clone())));
        let input = gst::Pad::builder(gst::PadDirection::Src).name("units").build();
        input.link(&pad(&parser, "sink")?).map_err(unlinked)?;
        let end = end_pad(&output)?;
        pad(&filter, "src")?.link(&end).map_err(unlinked)?;
        let parsed = Arc::new(AtomicBool::new(false));
        watch_parser(&pad(&parser, "src")?, &parsed);
        watch_layout(&pad(&decoder, "src")?, &filter, &output);
        Ok(Self {
            bus: pipeline.bus().ok_or_else(|| unlinked("no bus"))?,
            pipeline,
            input,
            _end: end,
            output,
            caps: choice::unit_caps(format),
            unit_time: gst::Caps::new_empty_simple(UNIT_TIME),
            errors,
            element,
            parsed,
            is_awaiting_key: true,
            has_stream: false,
        })
    }

    /// The line, ready for units.
    pub(super) fn started(self) -> Result<Self, NoDecoder> {
        let state = self.pipeline.set_state(gst::State::Playing).map(|_| ());
        state.map_err(unlinked)?;
        self.input.set_active(true).map_err(unlinked)?;
        Ok(self)
    }

    pub(super) fn ready(&self) -> FromDecoder {
        FromDecoder::Ready { element: self.element.name.clone(), is_hardware: self.element.is_hardware }
    }

    pub(super) fn output(&self) -> MutexGuard<'_, Output> {
        lock(&self.output)
    }

    /// Decodes a unit. Returns why it gives no intact picture.
    pub(super) fn decode(&mut self, payload: Vec<u8>, pts_ns: u64, key: bool) -> Option<String> {
        if self.is_awaiting_key && !key {
            return None;
        }
        let is_start = std::mem::replace(&mut self.is_awaiting_key, false);
        if !self.has_stream {
            self.begin_stream();
        }
        let mut buffer = gst::Buffer::from_mut_slice(payload);
        if let Some(buffer) = buffer.get_mut() {
            let time = gst::ClockTime::from_nseconds(pts_ns.min(gst::ClockTime::MAX.nseconds()));
            buffer.set_pts(time);
            gst::ReferenceTimestampMeta::add(buffer, &self.unit_time, time, None);
            if !key {
                buffer.set_flags(gst::BufferFlags::DELTA_UNIT);
            }
        }
        self.output().begin(pts_ns);
        let mut damage = self.push(buffer.clone());
        for _ in 1..if is_start { START_ATTEMPTS } else { 1 } {
            // Damage that libav tells stays.
            if damage.is_none() || self.errors.first().is_some() {
                break;
            }
            damage = self.push(buffer.clone());
        }
        if damage.is_some() {
            // The intact pictures that the decoder holds back come out here; that of this unit is withheld.
            self.drain();
        }
        damage
    }

    /// Pushes a unit through the line. Returns why it gives no intact picture.
    fn push(&self, unit: gst::Buffer) -> Option<String> {
        self.errors.forget();
        self.parsed.store(false, Ordering::Relaxed);
        let pushed = self.input.push(unit);
        self.damage(pushed)
    }

    /// Delivers all pictures that the elements hold back, and waits for a key frame.
    pub(super) fn flush(&mut self) {
        self.errors.forget();
        self.drain();
    }

    fn drain(&mut self) {
        self.is_awaiting_key = true;
        if !self.has_stream {
            return;
        }
        self.has_stream = false;
        self.input.push_event(gst::event::Eos::new());
        self.input.push_event(gst::event::FlushStart::new());
        self.input.push_event(gst::event::FlushStop::new(true));
        // A parser complains of a stream that ends without a picture.
        while self.bus.pop().is_some() {}
    }

    fn begin_stream(&mut self) {
        self.has_stream = true;
        self.input.push_event(gst::event::StreamStart::new("units"));
        self.input.push_event(gst::event::Caps::new(&self.caps));
        let segment = gst::FormattedSegment::<gst::ClockTime>::new();
        self.input.push_event(gst::event::Segment::new(&segment));
    }

    /// What the elements say about the unit that was pushed.
    fn damage(&self, pushed: Result<gst::FlowSuccess, gst::FlowError>) -> Option<String> {
        let mut reported = None;
        while let Some(message) = self.bus.pop() {
            if let gst::MessageView::Error(error) = message.view() {
                reported.get_or_insert_with(|| error.error().to_string());
            }
        }
        let refused = pushed.err().map(|error| format!("{} refuses it ({error})", self.element.name));
        let absent = || (!self.parsed.load(Ordering::Relaxed)).then(|| "it holds no picture".to_owned());
        self.errors.first().or(reported).or(refused).or_else(absent)
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        let _ = self.pipeline.set_state(gst::State::Null);
    }
}

fn lock(output: &Mutex<Output>) -> MutexGuard<'_, Output> {
    output.lock().unwrap_or_else(PoisonError::into_inner)
}

fn make(name: &str, package: &str) -> Result<gst::Element, NoDecoder> {
    gst::ElementFactory::make(name).build().map_err(|_| NoDecoder {
        reason: format!("GStreamer's element {name} is not installed"),
        remedy: format!("Install {package}"),
    })
}

fn pad(element: &gst::Element, name: &str) -> Result<gst::Pad, NoDecoder> {
    element.static_pad(name).ok_or_else(|| unlinked(format!("{} has no pad {name}", element.name())))
}

fn unlinked(error: impl std::fmt::Display) -> NoDecoder {
    let reason = format!("GStreamer's elements do not fit together: {error}");
    NoDecoder { reason, remedy: "Install GStreamer's packages anew, all of one version".to_owned() }
}

/// Sets what decoders have in common, and the decoders of libav.
fn set_up(decoder: &gst::Element, is_live: bool) {
    let set = |name: &str, value: &str| {
        if decoder.find_property(name).is_some() {
            decoder.set_property_from_str(name, value);
        }
    };
    // An error is told at once, for the unit that has it.
    set("max-errors", "0");
    set("qos", "false");
    set("output-corrupt", "false");
    // Several threads for one picture. Threads for several pictures would hold back as many.
    set("thread-type", "slice");
    // In the order of the standard, a picture waits for all that may be displayed before it.
    set("std-compliance", if is_live { "normal" } else { "strict" });
}

/// The pad after the last element.
fn end_pad(output: &Arc<Mutex<Output>>) -> Result<gst::Pad, NoDecoder> {
    let (pictures, events) = (output.clone(), output.clone());
    // Without a template, a pad accepts nothing but the size that it has.
    let any = gst::PadTemplate::new(
        "pictures",
        gst::PadDirection::Sink,
        gst::PadPresence::Always,
        &gst::Caps::new_any(),
    );
    let pad = gst::Pad::builder_from_template(&any.map_err(unlinked)?)
        .chain_function(move |_, _, buffer| lock(&pictures).picture(&buffer))
        .event_function(move |_, _, event| {
            if let gst::EventView::Caps(caps) = event.view() {
                lock(&events).set_caps(caps.caps());
            }
            true
        })
        .build();
    // A pad outside of an element is activated by hand; this cannot fail for a pad in push mode.
    let _ = pad.set_active(true);
    Ok(pad)
}

/// Notices what the parser passes on.
fn watch_parser(parsed_units: &gst::Pad, parsed: &Arc<AtomicBool>) {
    let parsed = parsed.clone();
    parsed_units.add_probe(gst::PadProbeType::BUFFER, move |_, _| {
        parsed.store(true, Ordering::Relaxed);
        gst::PadProbeReturn::Ok
    });
}

/// Follows size and colours of the decoded pictures: the filter scales large ones down, the output tells the
/// colours.
fn watch_layout(decoded: &gst::Pad, filter: &gst::Element, output: &Arc<Mutex<Output>>) {
    let (filter, output) = (filter.clone(), output.clone());
    decoded.add_probe(gst::PadProbeType::EVENT_DOWNSTREAM, move |_, info| {
        if let Some(gst::PadProbeData::Event(event)) = &info.data
            && let gst::EventView::Caps(caps) = event.view()
        {
            let delivered = lock(&output).set_decoded(caps.caps());
            filter.set_property("caps", delivered);
        }
        gst::PadProbeReturn::Ok
    });
}
