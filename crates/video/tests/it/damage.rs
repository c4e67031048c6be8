//! Damaged files and damaged parameters: frames or an error, never a panic.

use barrelman_vocab::rng::SplitMix64;

use crate::clips::{fixture, output, read};

/// Reads a file `times` times with some bytes changed or cut off: the result is frames or an error.
fn check_survives_damage(file: &str, times: u64) {
    let whole = std::fs::read(fixture(file)).unwrap();
    let path = output(&format!("damaged_{}", file.replace('/', "_")));
    for seed in 0..times {
        let mut rng = SplitMix64::new(seed);
        let mut bytes = whole.clone();
        for _ in 0..=rng.next_u64() % 8 {
            let at = rng.next_u64() as usize % bytes.len();
            bytes[at] = match rng.next_u64() % 3 {
                0 => 0,
                1 => 0xff,
                _ => rng.next_u64() as u8,
            };
        }
        if seed % 4 == 0 {
            bytes.truncate(rng.next_u64() as usize % bytes.len());
        }
        std::fs::write(&path, &bytes).unwrap();
        let _ = read(path.clone());
    }
}

#[test]
fn a_damaged_file_gives_frames_or_an_error_and_never_a_panic() {
    let times = 40;
    for file in ["baseline.mp4", "high_b.mp4", "edit_list.mp4", "fragmented.mp4", "size_changes.mp4"] {
        check_survives_damage(file, times);
    }
    for file in ["odd.y4m", "png/f1.png", "png/f10.png", "jpeg/1.jpg", "jpeg/2.jpg"] {
        check_survives_damage(file, times);
    }
}
