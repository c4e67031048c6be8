//! Delays and losses of the video link.

use barrelman_sim::video_link::{Delivery, VideoLink, VideoLinkModel};

#[test]
fn a_steady_link_delays_every_picture_alike() {
    let mut link = VideoLink::new(VideoLinkModel::steady(0.1), 1);
    for tick in (0..1200).step_by(4) {
        assert_eq!(link.send(tick), Delivery::Arrives { at: tick + 12 });
    }
}

#[test]
fn a_poor_link_spoils_its_share_in_bursts_and_never_lets_pictures_overtake() {
    let script = VideoLinkModel {
        latency_s: 0.18,
        jitter_s: 0.005,
        good_to_bad: 0.02,
        bad_to_good: 0.15,
        impaired_share: 0.7,
        frozen_share: 0.3,
    };
    let mut link = VideoLink::new(script, 1);
    let (mut lost, mut frozen, mut last, mut delay) = (0, 0, 0, 0);
    let pictures = 40_000;
    for picture in 0..pictures {
        let tick = 4 * picture;
        match link.send(tick) {
            Delivery::Lost => lost += 1,
            Delivery::Arrives { at } | Delivery::Frozen { at } if at < last => panic!("{at} after {last}"),
            Delivery::Arrives { at } => {
                delay += at - tick;
                last = at;
            }
            Delivery::Frozen { at } => {
                frozen += 1;
                last = at;
            }
        }
    }
    let share = |count: u64| count as f64 / pictures as f64;
    // In the bad state 0.02 / (0.02 + 0.15) of the time.
    assert!((share(lost + frozen) - 0.1176 * 0.7).abs() < 0.01, "{lost} lost, {frozen} frozen");
    assert!((share(frozen) / share(lost + frozen) - 0.3).abs() < 0.05, "{lost} lost, {frozen} frozen");
    let mean_s = delay as f64 / (pictures - lost - frozen) as f64 / 120.0;
    assert!((0.186..0.196).contains(&mean_s), "0.18 s and twice 0.005 s: {mean_s}");
}
