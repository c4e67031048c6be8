//! A vehicle that is measured: the link to it, its far end, and the same way without a link.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender};

use anyhow::{Context as _, Result, bail, ensure};
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_link::guard::message::GuardedVehicle;
use barrelman_link::guarded::GuardedLinkSettings;
use barrelman_link::url::Endpoint;
use barrelman_link::{GuardedLink, LinkHandle, LinkReport, LinkUrl};
use barrelman_link_http::{Credential, HttpProtocol, HttpSettings, SigmaAccess, Trust};
use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::onvif::OnvifSettings;
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing};

use super::bare::{BareDatagrams, BareLoop, BareRequests, BareStream};
use super::heard::Heard;
use super::{fotokite_pro, fotokite_sigma, mavlink_gimbal, onvif};
use crate::vehicle::Vehicle;

impl Vehicle {
    /// The 99th percentile may be later than that of a bare write by this, milliseconds.
    pub(super) const fn limit_ms(self) -> f64 {
        match self {
            Self::FotokitePro | Self::MavlinkGimbal => 1.0,
            Self::FotokiteSigma | Self::OnvifPtz => 3.0,
        }
    }

    /// Starts the emulated vehicle: its address, and what it hears.
    pub(super) fn start(self, clock: Clock) -> Result<(String, Receiver<Heard>)> {
        match self {
            Self::FotokitePro => fotokite_pro::start(clock),
            Self::MavlinkGimbal => mavlink_gimbal::start(clock),
            Self::FotokiteSigma => fotokite_sigma::start(clock),
            Self::OnvifPtz => onvif::start(clock),
        }
    }

    /// The same way without link and guard.
    pub(super) fn bare(self) -> Result<Box<dyn BareLoop>> {
        Ok(match self {
            Self::FotokitePro => Box::new(BareStream::open()?),
            Self::MavlinkGimbal => Box::new(BareDatagrams::open()?),
            Self::FotokiteSigma => Box::new(BareRequests::of_sigma()?),
            Self::OnvifPtz => Box::new(BareRequests::of_onvif()?),
        })
    }

    /// Opens the link to the vehicle at this address.
    ///
    /// # Errors
    /// If the guard's program is not there, or the vehicle is not reached.
    pub(super) fn open(
        self,
        address: &str,
        guard: Option<&Path>,
        clock: Clock,
        report: Sender<LinkReport>,
    ) -> Result<MeasuredLink> {
        let url = LinkUrl::parse(address)?;
        let tell = move |content| report.send(content).is_ok();
        let profile = self.profile();
        if !profile.keeps_last_rate() {
            let Endpoint::Http(address) = url.endpoint else { bail!("{address} is not reached over HTTP") };
            let protocol = if self == Self::OnvifPtz {
                HttpProtocol::Onvif(OnvifSettings {
                    login: Some(onvif::login()),
                    speeds: profile.speeds,
                    profile: None,
                })
            } else {
                let credential = Credential::Token(fotokite_sigma::TOKEN.to_owned());
                HttpProtocol::FotokiteSigma(SigmaAccess {
                    credential,
                    stream: None,
                    full_zoom: profile.max_zoom_rate(),
                })
            };
            let settings = HttpSettings { address, trust: Trust::WellKnown, protocol };
            let link = barrelman_link_http::open_link(settings, FaultPlan::default(), clock, tell)?;
            return Ok(MeasuredLink::OfProgram(link));
        }
        let protocol =
            ByteProtocolName::of(profile.protocol).context("the vehicle's port carries no bytes")?;
        let limits = profile.protocol.rate_limits();
        let framing = Framing::CarriageReturns;
        let limits = VehicleRates::turning(limits.pan, limits.tilt).zooming(profile.largest_rates().zoom);
        let settings = GuardedLinkSettings {
            guard: guard_program(guard)?,
            protocol: ByteProtocol { protocol, framing, baud: url.baud() },
            url,
            vehicle: GuardedVehicle::Camera { limits, protocol, framing },
            lock: None,
            clock,
        };
        Ok(MeasuredLink::Guarded(GuardedLink::open(settings, tell)?))
    }
}

fn guard_program(guard: Option<&Path>) -> Result<PathBuf> {
    let guard = match guard {
        Some(guard) => guard.to_owned(),
        None => std::env::current_exe()?.with_file_name("barrelman-guard"),
    };
    ensure!(
        guard.exists(),
        "the guard {} is not there: build it (`cargo build --release -p barrelman`)",
        guard.display()
    );
    Ok(guard)
}

/// The link that is measured.
pub(super) enum MeasuredLink {
    Guarded(GuardedLink),
    /// Of a vehicle whose commands expire: a thread of the program.
    OfProgram(LinkHandle),
}

impl MeasuredLink {
    pub(super) fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        match self {
            Self::Guarded(link) => link.send(rates, renew_by),
            Self::OfProgram(link) => link.send(rates, renew_by),
        }
    }

    /// Ends the link. Returns whether the shut-down was completed.
    pub(super) fn close(self) -> bool {
        match self {
            Self::Guarded(link) => link.close(),
            Self::OfProgram(link) => link.close(),
        }
    }

    /// How the link is named beside the bare write.
    pub(super) const fn name(&self) -> &'static str {
        match self {
            Self::Guarded(_) => "link and guard",
            Self::OfProgram(_) => "link",
        }
    }
}
