use super::*;

const RATE: u32 = 90_000;

fn ms(millis: f64) -> Timestamp {
    Timestamp::from_nanos((millis * 1e6) as u64)
}

/// A sender of 25 pictures a second, and the way to this program.
struct Sender {
    clock: SenderClock,
    /// Time of the sender's RTP clock at true time 0, s.
    rtp_start_s: f64,
    /// Seconds of the RTP clock for each second.
    rtp_rate: f64,
    /// True time of the next picture, s.
    at_s: f64,
    pictures: u64,
}

/// A picture: when it was taken, and what the clock made of it.
#[derive(Debug, Clone, Copy)]
struct Seen {
    taken_s: f64,
    capture: Capture,
    timing: VideoTiming,
}

impl Seen {
    /// The shown age less the true one, s: negative where the picture looks fresher than it is.
    fn age_error_s(&self, delay_s: f64) -> f64 {
        let arrival_s = self.taken_s + delay_s;
        arrival_s - self.capture.at.as_secs_f64() - delay_s
    }
}

impl Sender {
    fn new() -> Self {
        let clock = SenderClock::new(RATE, TimingSettings::default());
        Self { clock, rtp_start_s: 1234.5, rtp_rate: 1.0, at_s: 10.0, pictures: 0 }
    }

    fn rtp(&self, at_s: f64) -> u32 {
        (((self.rtp_start_s + at_s * self.rtp_rate) * f64::from(RATE)).round() as i64) as u32
    }

    /// Pictures for `seconds`, each with this delay at its true time.
    fn run(&mut self, seconds: f64, delay_s: impl Fn(f64) -> f64) -> Vec<Seen> {
        let end_s = self.at_s + seconds;
        let mut seen = Vec::new();
        while self.at_s < end_s - 1e-6 {
            let taken_s = self.at_s;
            // Every twelfth picture is a key frame.
            let bytes = if self.pictures.is_multiple_of(12) { 30_000 } else { 4_000 };
            let arrival = ms((taken_s + delay_s(taken_s)) * 1e3);
            let capture = self.clock.capture(ArrivedPicture { rtp: self.rtp(taken_s), bytes, arrival });
            seen.push(Seen { taken_s, capture, timing: self.clock.timing() });
            self.at_s += 0.04;
            self.pictures += 1;
        }
        seen
    }

    /// A sender report, with the sender's wall clock ahead of ours by `ahead_s`, which takes `delay_s`.
    fn report(&mut self, ahead_s: f64, delay_s: f64) {
        let (sent_s, arrival_s) = (self.at_s, self.at_s + delay_s);
        let ns = |seconds: f64| (seconds * 1e9) as i128;
        self.clock.on_sender_report(SenderReport {
            rtp: self.rtp(sent_s),
            sender_wall_ns: Some(ns(3e9 + sent_s + ahead_s)),
            arrival: ms(arrival_s * 1e3),
            wall_ns: ns(3e9 + arrival_s),
        });
    }

    /// The source connects again.
    fn reconnect(&mut self, gap_s: f64) {
        self.at_s += gap_s;
        self.clock.on_connected();
    }
}

fn last(seen: &[Seen]) -> Seen {
    *seen.last().unwrap()
}

fn is_late(seen: Seen) -> bool {
    matches!(seen.timing, VideoTiming::Late { .. })
}

/// A small delay that differs from picture to picture, s.
fn jitter_s(at_s: f64) -> f64 {
    0.005 + 0.02 * (at_s * 7.3).sin().abs()
}

#[test]
fn a_picture_was_taken_when_the_quickest_one_says() {
    let mut sender = Sender::new();
    sender.run(20.0, jitter_s);
    for seen in sender.run(10.0, jitter_s) {
        let error_s = seen.age_error_s(jitter_s(seen.taken_s));
        // 5 ms is the smallest delay, which the stream does not tell; 200 ppm of a second are 0.2 ms.
        assert!((error_s + 0.005).abs() < 0.002, "{seen:?}: {error_s}");
        assert_eq!(seen.capture.quality, CaptureQuality::Sender);
        assert_eq!(seen.timing, VideoTiming::InTime);
    }
}

#[test]
fn times_of_capture_never_run_backwards_at_a_start() {
    let mut sender = Sender::new();
    let start = |at_s: f64| (0.4 - (at_s - 10.0) * 0.9).max(0.005);
    let seen = sender.run(3.0, start);
    for pair in seen.windows(2) {
        assert!(pair[0].capture.at <= pair[1].capture.at, "{pair:?}");
    }
}

#[test]
fn a_delay_that_stays_is_never_forgotten() {
    let mut sender = Sender::new();
    sender.run(8.0, jitter_s);
    let begun_s = sender.at_s;
    let delay_s = |at_s: f64| 3.0 * ((at_s - begun_s) / 8.0).min(1.0);
    for seen in sender.run(3600.0, delay_s) {
        let delay_s = delay_s(seen.taken_s);
        // A quartz may drift by 0.72 s in an hour.
        let drift_s = 200e-6 * (seen.taken_s - begun_s) + 0.03;
        let error_s = seen.age_error_s(delay_s);
        assert!(error_s > -drift_s && error_s < 0.03, "{seen:?}: {error_s}");
        assert_eq!(is_late(seen), delay_s > 0.95 || (is_late(seen) && delay_s > 0.5), "{seen:?}");
    }
    // The delay ends.
    assert_eq!(last(&sender.run(1.0, |_| 0.005)).timing, VideoTiming::InTime);
}

#[test]
fn a_delay_that_creeps_is_seen() {
    for per_second in [0.001, 0.005, 0.02, 0.09] {
        let mut sender = Sender::new();
        sender.run(8.0, jitter_s);
        let begun_s = sender.at_s;
        let delay_s = |at_s: f64| jitter_s(at_s) + per_second * (at_s - begun_s);
        let seen = sender.run(3.0 / per_second, delay_s);
        let told_s = seen.iter().find(|seen| is_late(**seen)).map(|seen| delay_s(seen.taken_s));
        let told_s = told_s.unwrap_or_else(|| panic!("{per_second}: {:?}", last(&seen)));
        // Drift hides a fifth of a delay of 1000 ppm.
        assert!(told_s < 0.8, "{per_second}: told at {told_s} s");
        assert!(is_late(last(&seen)));
    }
}

#[test]
fn the_drift_of_a_quartz_is_no_delay() {
    for drift in [-150e-6, -50e-6, 50e-6, 150e-6] {
        let mut sender = Sender { rtp_rate: 1.0 + drift, ..Sender::new() };
        for seen in sender.run(4000.0, jitter_s) {
            let error_s = seen.age_error_s(jitter_s(seen.taken_s));
            assert!(error_s.abs() < 0.03 && !is_late(seen), "{drift}: {seen:?}, {error_s}");
        }
    }
}

#[test]
fn a_burst_after_a_gap_keeps_its_times_of_capture() {
    let mut sender = Sender::new();
    sender.run(5.0, |_| 0.005);
    let end_s = sender.at_s + 2.0;
    for seen in sender.run(2.0, |at_s| end_s - at_s) {
        assert!(seen.age_error_s(end_s - seen.taken_s).abs() < 0.01, "{seen:?}");
    }
}

#[test]
fn the_counter_may_wrap() {
    let mut sender = Sender { rtp_start_s: f64::from(u32::MAX) / f64::from(RATE) - 12.0, ..Sender::new() };
    for seen in sender.run(10.0, |_| 0.005) {
        assert!((seen.age_error_s(0.005) + 0.005).abs() < 0.001, "{seen:?}");
    }
}

#[test]
fn reordered_pictures_are_no_jump() {
    let mut sender = Sender::new();
    sender.run(5.0, |_| 0.005);
    let arrival = ms((sender.at_s + 0.12) * 1e3);
    let mut capture = |at_s: f64| {
        let rtp = sender.rtp(at_s);
        sender.clock.capture(ArrivedPicture { rtp, bytes: 1, arrival }).at.as_secs_f64()
    };
    let taken_s = 15.0;
    assert!((capture(taken_s + 0.12) - taken_s - 0.125).abs() < 0.01);
    assert!((capture(taken_s + 0.08) - taken_s - 0.085).abs() < 0.01);
}

#[test]
fn a_jump_of_the_senders_clock_keeps_the_delay() {
    for jump_s in [-20.0, -1.5, 20.0] {
        for delay_s in [0.005, 2.0] {
            let mut sender = Sender::new();
            sender.run(5.0, |_| 0.005);
            sender.run(5.0, |_| delay_s);
            sender.rtp_start_s += jump_s;
            for seen in sender.run(5.0, |_| delay_s) {
                assert!(seen.age_error_s(delay_s).abs() < 0.05, "{jump_s} s, {delay_s} s: {seen:?}");
            }
        }
    }
}

#[test]
fn a_clock_that_is_set_back_by_less_than_a_second_keeps_the_delay() {
    for back_s in [0.3, 0.8, 0.99] {
        let mut sender = Sender::new();
        sender.run(60.0, |at_s| if at_s > 40.0 { 0.25 } else { 0.05 });
        sender.rtp_start_s -= back_s;
        let seen = sender.run(20.0, |_| 0.25);
        // Until no reordering explains it, the pictures look older than they are.
        assert!(seen.iter().all(|seen| seen.age_error_s(0.25) > -0.06), "{back_s}");
        assert!(seen[20..].iter().all(|seen| seen.age_error_s(0.25).abs() < 0.06), "{back_s}");
        assert!(!seen.iter().any(|seen| is_late(*seen)), "{back_s}");
    }
}

#[test]
fn a_queue_that_grows_between_reordered_pictures_is_no_clock_that_is_set_back() {
    // Ten pictures a second, in the order of decoding: an anchor, and three before it in a pyramid.
    let mut clock = Sender::new().clock;
    let (mut worst_s, mut was_late) = (f64::INFINITY, false);
    for picture in 0..600_u32 {
        let (group, place) = (picture / 4, picture % 4);
        let taken_s = 0.1 * f64::from(4 * group + [4, 2, 1, 3][place as usize]);
        // Sent when the anchor is there, and then late by a queue that grows between two of them.
        let queue_s = if picture >= 302 { 1.5 } else { 0.05 };
        let sent_s = 0.1 * f64::from(picture + 4);
        let rtp = (taken_s * f64::from(RATE)).round() as u32;
        let arrival = ms((10.0 + sent_s + queue_s) * 1e3);
        let capture = clock.capture(ArrivedPicture { rtp, bytes: 4_000, arrival });
        if picture > 340 {
            worst_s = worst_s.min(arrival.since(capture.at).as_secs_f64());
            was_late |= matches!(clock.timing(), VideoTiming::Late { .. });
        }
    }
    assert!(worst_s > 1.3 && was_late, "{worst_s}");
}

#[test]
fn a_suspension_of_the_machine_keeps_the_delay() {
    for gap_s in [0.5, 3.0, 60.0] {
        let mut sender = Sender::new();
        sender.run(5.0, |_| 0.005);
        sender.run(5.0, |_| 2.0);
        // The program's clock stands still, the sender's does not.
        sender.clock.on_suspension(Duration::from_secs_f64(gap_s));
        sender.rtp_start_s += gap_s;
        for seen in sender.run(5.0, |_| 2.0) {
            assert!(seen.age_error_s(2.0).abs() < 0.05, "{gap_s} s: {seen:?}");
        }
    }
}

#[test]
fn a_new_connection_to_the_same_clock_keeps_the_delay_of_a_queue() {
    let mut sender = Sender::new();
    sender.run(5.0, |_| 0.005);
    sender.run(5.0, |_| 3.0);
    sender.reconnect(1.0);
    let seen = last(&sender.run(2.0, |_| 3.0));
    assert!(is_late(seen) && seen.age_error_s(3.0).abs() < 0.05, "{seen:?}");
    // The next one drops the queue.
    sender.reconnect(1.0);
    assert_eq!(last(&sender.run(2.0, |_| 0.005)).timing, VideoTiming::InTime);
}

#[test]
fn a_new_connection_to_a_clock_that_begins_anew_is_in_time() {
    for start_s in [0.0, 7.0, 40_000.0] {
        let mut sender = Sender::new();
        sender.run(30.0, |_| 0.005);
        sender.reconnect(1.0);
        sender.rtp_start_s = start_s - sender.at_s;
        assert_eq!(last(&sender.run(5.0, |_| 0.005)).timing, VideoTiming::InTime, "{start_s}");
    }
}

/// A slow clock, on two connections in turn; returns the last picture of each.
fn on_two_connections(rtp_rate: f64, delay_s: impl Fn(f64, f64) -> f64) -> [Seen; 2] {
    let mut sender = Sender { rtp_rate, ..Sender::new() };
    [0.0, 1000.0].map(|start_s| {
        sender.rtp_start_s = start_s;
        sender.reconnect(0.5);
        let begun_s = sender.at_s;
        last(&sender.run(8.0, |at_s| delay_s(at_s, begun_s)))
    })
}

#[test]
fn a_clock_that_is_slow_on_two_connections_is_wrong() {
    for rate in [0.01, 0.5, 0.75, 0.85] {
        let [first, second] = on_two_connections(rate, |at_s, _| jitter_s(at_s));
        assert!(is_late(first), "{rate}: {first:?}");
        let VideoTiming::ClockWrong(ClockFault::Rate(found)) = second.timing else {
            panic!("{rate}: {second:?}")
        };
        assert!((found - rate).abs() < 0.03, "{rate}: {found}");
        assert_eq!(second.capture.quality, CaptureQuality::Arrival);
        let age_s = jitter_s(second.taken_s) + second.taken_s - second.capture.at.as_secs_f64();
        assert!((0.0..0.05).contains(&age_s), "the age is the jitter: {age_s}");
    }
}

#[test]
fn a_saturated_link_is_no_slow_clock() {
    // Each picture waits for the bytes of those before it: 30 kB take twelve times as long as 2.5 kB.
    let saturated = |at_s: f64, begun_s: f64| {
        let picture = ((at_s - begun_s) / 0.04).round();
        let bytes = 4_000.0 * picture + 26_000.0 * (picture / 12.0).ceil();
        bytes / 110_000.0 - (at_s - begun_s)
    };
    let [first, second] = on_two_connections(1.0, saturated);
    assert!(is_late(first) && is_late(second), "{first:?} {second:?}");
}

#[test]
fn a_delay_that_grows_slowly_on_each_connection_is_no_slow_clock() {
    let [first, second] = on_two_connections(1.0, |at_s, begun_s| 0.09 * (at_s - begun_s));
    assert!(is_late(first) && is_late(second), "{first:?} {second:?}");
    let [first, second] =
        on_two_connections(1.0, |at_s, begun_s| 1.5 * ((at_s - begun_s) / 8.0 - 0.5).max(0.0));
    assert!(is_late(first) && is_late(second), "{first:?} {second:?}");
}

#[test]
fn a_slow_clock_that_becomes_right_was_a_delay() {
    let mut sender = Sender::new();
    for _ in 0..2 {
        sender.reconnect(0.5);
        sender.rtp_start_s += 1000.0;
        let begun_s = sender.at_s;
        sender.run(8.0, |at_s| 0.25 * (at_s - begun_s));
    }
    assert!(matches!(sender.clock.timing(), VideoTiming::ClockWrong(_)));
    assert!(is_late(last(&sender.run(6.0, |_| 2.0))));
}

#[test]
fn sender_reports_show_that_a_clock_is_right() {
    let mut sender = Sender::new();
    let mut timings = Vec::new();
    for _ in 0..3 {
        sender.reconnect(0.5);
        sender.rtp_start_s += 1000.0;
        let begun_s = sender.at_s;
        for _ in 0..8 {
            sender.run(1.0, |at_s| 0.25 * (at_s - begun_s));
            sender.report(77.0, 0.25 * (sender.at_s - begun_s));
        }
        timings.push(sender.clock.timing());
    }
    assert!(timings.iter().all(|timing| matches!(timing, VideoTiming::Late { .. })), "{timings:?}");
}

#[test]
fn a_fast_clock_is_wrong() {
    for rate in [1.2, 3.0, 11.0] {
        let mut sender = Sender { rtp_rate: rate, ..Sender::new() };
        let seen = last(&sender.run(10.0, jitter_s));
        assert!(matches!(seen.timing, VideoTiming::ClockWrong(ClockFault::Rate(_))), "{rate}: {seen:?}");
    }
}

#[test]
fn a_queue_that_drains_is_no_fast_clock() {
    let mut sender = Sender::new();
    sender.run(5.0, |_| 0.005);
    let begun_s = sender.at_s;
    let seen = sender.run(60.0, |at_s| (10.0 - 0.2 * (at_s - begun_s)).max(0.005));
    assert!(seen.iter().all(|seen| !matches!(seen.timing, VideoTiming::ClockWrong(_))));
    assert_eq!(last(&seen).timing, VideoTiming::InTime);
}

#[test]
fn a_coarse_clock_is_wrong() {
    for resolution_s in [0.1, 1.0] {
        let mut sender = Sender::new();
        let mut timing = VideoTiming::InTime;
        for _ in 0..150 {
            let shown_s = (sender.at_s / resolution_s).floor() * resolution_s;
            let picture =
                ArrivedPicture { rtp: sender.rtp(shown_s), bytes: 1000, arrival: ms(sender.at_s * 1e3) };
            sender.clock.capture(picture);
            timing = sender.clock.timing();
            sender.at_s += 0.04;
        }
        assert_eq!(timing, VideoTiming::ClockWrong(ClockFault::Resolution), "{resolution_s}");
    }
}

#[test]
fn a_clock_that_jumps_again_and_again_is_wrong() {
    let mut sender = Sender::new();
    for jump_s in [3.0, -3.0, 3.0, -3.0] {
        sender.run(2.0, jitter_s);
        sender.rtp_start_s += jump_s;
    }
    let seen = last(&sender.run(1.0, jitter_s));
    assert_eq!(seen.timing, VideoTiming::ClockWrong(ClockFault::Jumps));
}

#[test]
fn times_of_arrival_are_used_where_they_are_chosen() {
    let settings = TimingSettings { clock: ClockChoice::Arrival, ..TimingSettings::default() };
    let mut sender = Sender { clock: SenderClock::new(RATE, settings), rtp_rate: 0.7, ..Sender::new() };
    let seen = last(&sender.run(20.0, |_| 0.005));
    assert_eq!((seen.timing, seen.capture.quality), (VideoTiming::InTime, CaptureQuality::Arrival));
    assert!(seen.age_error_s(0.005).abs() < 0.01);
}

#[test]
fn a_sender_report_brings_the_time_nearer_to_the_sensor() {
    let mut sender = Sender::new();
    sender.run(5.0, |_| 0.05);
    sender.report(0.0, 0.002);
    let seen = last(&sender.run(0.2, |_| 0.05));
    assert!((seen.age_error_s(0.05) + 0.002).abs() < 0.001, "{seen:?}");
}

#[test]
fn a_sender_report_that_fits_no_picture_is_ignored() {
    let mut sender = Sender::new();
    sender.run(5.0, |_| 0.05);
    for shift_s in [-30.0, 5.0] {
        sender.rtp_start_s += shift_s;
        sender.report(0.0, 0.002);
        sender.rtp_start_s -= shift_s;
    }
    let seen = last(&sender.run(0.04, |_| 0.05));
    assert!((seen.age_error_s(0.05) + 0.05).abs() < 0.001, "{seen:?}");
}

#[test]
fn the_senders_wall_clock_tells_the_delay_of_a_new_connection() {
    let mut sender = Sender::new();
    for _ in 0..4 {
        sender.run(5.0, jitter_s);
        sender.report(-4000.0, 0.01);
    }
    sender.reconnect(1.0);
    sender.rtp_start_s += 5000.0;
    // The queue outlasts the connection, and the report waits in it.
    sender.run(1.0, |_| 2.0);
    sender.report(-4000.0, 2.0);
    let seen = last(&sender.run(3.0, |_| 2.0));
    assert!(is_late(seen) && seen.age_error_s(2.0).abs() < 0.05, "{seen:?}");
}

#[test]
fn a_sender_that_restarts_with_another_wall_clock_is_in_time() {
    for ahead_s in [-5000.0, -3e9] {
        let mut sender = Sender::new();
        for _ in 0..4 {
            sender.run(5.0, jitter_s);
            sender.report(-4000.0, 0.01);
        }
        sender.reconnect(30.0);
        sender.rtp_start_s += 5000.0;
        sender.run(1.0, jitter_s);
        for _ in 0..4 {
            sender.report(ahead_s, 0.01);
            let seen = last(&sender.run(5.0, jitter_s));
            assert_eq!(seen.timing, VideoTiming::InTime, "{ahead_s}: {seen:?}");
        }
        // Its own delay is seen on the next connection.
        sender.reconnect(1.0);
        sender.rtp_start_s += 5000.0;
        sender.run(1.0, |_| 2.0);
        sender.report(ahead_s, 2.0);
        let seen = last(&sender.run(3.0, |_| 2.0));
        assert!(is_late(seen), "{ahead_s}: {seen:?}");
    }
}

#[test]
fn where_the_wall_clocks_agree_a_delay_from_the_start_is_seen() {
    for (ahead_s, expected) in [(0.0, true), (-20.0, false)] {
        let mut sender = Sender::new();
        for _ in 0..4 {
            sender.run(5.0, |_| 2.5);
            // The reports pass the queue of the pictures.
            sender.report(ahead_s, 0.01);
        }
        let seen = last(&sender.run(2.0, |_| 2.5));
        assert_eq!(is_late(seen), expected, "{ahead_s}: {seen:?}");
    }
}

#[test]
fn a_wall_clock_of_whole_seconds_tells_nothing() {
    let mut sender = Sender::new();
    for step in 0..20 {
        let seen = last(&sender.run(1.3, jitter_s));
        assert_eq!(seen.timing, VideoTiming::InTime);
        let fraction_s = (sender.at_s + 0.37 * f64::from(step)).fract();
        sender.report(-fraction_s, 0.01);
    }
}
