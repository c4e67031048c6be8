//! The faults of the campaign, and which of them a run has.

use barrelman_vocab::rng::SplitMix64;

/// What goes wrong. Times are those of the world, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FaultKind {
    VideoStalls,
    VideoLate,
    VideoDelayStands,
    VideoDelayCreeps,
    VideoClockJumps,
    MediaProgramGone,
    TrackLost,
    TrackCoasts,
    PilotHangs,
    ProgramKilled,
    ProgramStopped,
    ProgramEnds,
    GuardKilled,
    GuardHangs,
    Suspension,
    LineCut,
    LineSilent,
    LineLosesPackets,
    LineDamagesBytes,
    LineDelays,
    LineRepeats,
    StationReboots,
    ControlTaken,
    Emergency,
    BatteryLow,
    OperatorStops,
    InformationWithheld,
    StatusWithheld,
    ClaimsDenied,
    ClaimsLost,
    TokenExpired,
    ServerNotReady,
    ServerHangs,
    WebSocketMissing,
    StopsIgnored,
    ClockJumps,
    MarkRemoved,
    TargetDeselected,
    OperatorStopsBoat,
    BoatReleased,
    ConsoleClosed,
    ConsoleSilent,
    BoatDisarmed,
    CommandsLost,
}

impl FaultKind {
    /// Every kind.
    pub(super) const ALL: [Self; 44] = [
        Self::VideoStalls,
        Self::VideoLate,
        Self::VideoDelayStands,
        Self::VideoDelayCreeps,
        Self::VideoClockJumps,
        Self::MediaProgramGone,
        Self::TrackLost,
        Self::TrackCoasts,
        Self::PilotHangs,
        Self::ProgramKilled,
        Self::ProgramStopped,
        Self::ProgramEnds,
        Self::GuardKilled,
        Self::GuardHangs,
        Self::Suspension,
        Self::LineCut,
        Self::LineSilent,
        Self::LineLosesPackets,
        Self::LineDamagesBytes,
        Self::LineDelays,
        Self::LineRepeats,
        Self::StationReboots,
        Self::ControlTaken,
        Self::Emergency,
        Self::BatteryLow,
        Self::OperatorStops,
        Self::InformationWithheld,
        Self::StatusWithheld,
        Self::ClaimsDenied,
        Self::ClaimsLost,
        Self::TokenExpired,
        Self::ServerNotReady,
        Self::ServerHangs,
        Self::WebSocketMissing,
        Self::StopsIgnored,
        Self::ClockJumps,
        Self::MarkRemoved,
        Self::TargetDeselected,
        Self::OperatorStopsBoat,
        Self::BoatReleased,
        Self::ConsoleClosed,
        Self::ConsoleSilent,
        Self::BoatDisarmed,
        Self::CommandsLost,
    ];

    /// The fault in words.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::VideoStalls => "video stalls",
            Self::VideoLate => "video late",
            Self::VideoDelayStands => "video delay stands (3 s)",
            Self::VideoDelayCreeps => "video delay creeps",
            Self::VideoClockJumps => "video clock jumps",
            Self::MediaProgramGone => "media program gone",
            Self::TrackLost => "track lost",
            Self::TrackCoasts => "track coasts",
            Self::PilotHangs => "pilot hangs",
            Self::ProgramKilled => "program killed",
            Self::ProgramStopped => "program stopped (5 s)",
            Self::ProgramEnds => "program ends",
            Self::GuardKilled => "guard killed",
            Self::GuardHangs => "guard hangs",
            Self::Suspension => "machine suspended",
            Self::LineCut => "line cut",
            Self::LineSilent => "line silent",
            Self::LineLosesPackets => "line loses packets",
            Self::LineDamagesBytes => "line damages bytes",
            Self::LineDelays => "line delays",
            Self::LineRepeats => "line repeats",
            Self::StationReboots => "station reboots",
            Self::ControlTaken => "control taken away",
            Self::Emergency => "emergency",
            Self::BatteryLow => "battery low",
            Self::OperatorStops => "operator stops",
            Self::InformationWithheld => "information withheld",
            Self::StatusWithheld => "status withheld",
            Self::ClaimsDenied => "claims denied",
            Self::ClaimsLost => "claims lost",
            Self::TokenExpired => "token or login refused",
            Self::ServerNotReady => "server not ready (503)",
            Self::ServerHangs => "server hangs",
            Self::WebSocketMissing => "no WebSocket",
            Self::StopsIgnored => "Stop ignored",
            Self::ClockJumps => "camera's clock jumps",
            Self::MarkRemoved => "mark removed",
            Self::TargetDeselected => "boat deselected",
            Self::OperatorStopsBoat => "operator stops boat",
            Self::BoatReleased => "boat released",
            Self::ConsoleClosed => "console closed",
            Self::ConsoleSilent => "console silent",
            Self::BoatDisarmed => "boat disarmed",
            Self::CommandsLost => "Stop lost on the way",
        }
    }

    /// Whether the fault is one of the beginning of a session. Half of such faults are there from the start
    /// of the run.
    const fn is_of_beginning(self) -> bool {
        matches!(
            self,
            Self::InformationWithheld | Self::StatusWithheld | Self::ClaimsDenied | Self::ClaimsLost
        )
    }

    /// Whether only a boat can have the fault.
    pub(super) const fn is_of_boats(self) -> bool {
        matches!(
            self,
            Self::MarkRemoved
                | Self::TargetDeselected
                | Self::OperatorStopsBoat
                | Self::BoatReleased
                | Self::ConsoleClosed
                | Self::ConsoleSilent
                | Self::BoatDisarmed
        )
    }

    /// Whether the fault is one of the line, or of a server that carries out later what arrives: the time to
    /// rest counts from the end of the fault.
    pub(super) const fn is_of_line(self) -> bool {
        matches!(
            self,
            Self::LineCut
                | Self::LineSilent
                | Self::LineLosesPackets
                | Self::LineDamagesBytes
                | Self::LineDelays
                | Self::LineRepeats
                | Self::ServerHangs
                | Self::CommandsLost
        )
    }
}

/// A fault with its times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) kind: FaultKind,
    pub(super) from_ms: u64,
    pub(super) until_ms: u64,
}

impl Fault {
    pub(super) fn begins(&self, kind: FaultKind, at_ms: u64) -> bool {
        self.kind == kind && self.from_ms == at_ms
    }

    pub(super) fn ends(&self, kind: FaultKind, at_ms: u64) -> bool {
        self.kind == kind && self.until_ms == at_ms
    }

    pub(super) const fn is_active(&self, at_ms: u64) -> bool {
        self.from_ms <= at_ms && at_ms < self.until_ms
    }
}

/// The first fault of a kind that is active.
pub(super) fn active(faults: &[Fault], kind: FaultKind, at_ms: u64) -> Option<&Fault> {
    faults.iter().find(|fault| fault.kind == kind && fault.is_active(at_ms))
}

/// When the last fault ends, ms; 0 without faults.
pub(super) fn last_end_ms(faults: &[Fault]) -> u64 {
    faults.iter().map(|fault| fault.until_ms).max().unwrap_or(0)
}

/// The faults of the run with this number, of these kinds: each kind alone first, then every pair, over and
/// over, with times from the seed.
pub(super) fn draw(number: u64, kinds: &[FaultKind], rng: &mut SplitMix64) -> Vec<Fault> {
    let count = kinds.len();
    let pairs = count * (count + 1) / 2;
    // Each kind is paired with itself, too: twice the same fault.
    let mut index = number as usize % (count + pairs);
    let mut fault = |kind: FaultKind| {
        let is_from_start = kind.is_of_beginning() && rng.uniform() < 0.5;
        let from_ms = if is_from_start { 0 } else { rng.between(4_500.0, 7_000.0) as u64 };
        let lasts_ms = match kind {
            FaultKind::ProgramStopped => 5_000,
            // Long enough to see that the operator is told.
            FaultKind::CommandsLost => rng.between(2_500.0, 4_000.0) as u64,
            _ => rng.between(50.0, 4_000.0) as u64,
        };
        Fault { kind, from_ms, until_ms: from_ms + lasts_ms }
    };
    if index < count {
        return vec![fault(kinds[index])];
    }
    index -= count;
    for (first, kind) in kinds.iter().enumerate() {
        if index < count - first {
            return vec![fault(*kind), fault(kinds[first + index])];
        }
        index -= count - first;
    }
    Vec::new()
}
