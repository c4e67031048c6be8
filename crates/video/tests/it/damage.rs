//! Damaged files and damaged parameters: frames or an error, never a panic.

use crate::clips::{fixture, output, read};

/// SplitMix64, so that the same bytes are changed in each run.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb) >> 16
}

/// Reads a file `times` times with some bytes changed or cut off: the result is frames or an error.
fn check_survives_damage(file: &str, times: u64) {
    let whole = std::fs::read(fixture(file)).unwrap();
    let path = output(&format!("damaged_{}", file.replace('/', "_")));
    for seed in 0..times {
        let mut state = seed;
        let mut bytes = whole.clone();
        for _ in 0..=random(&mut state) % 8 {
            let at = random(&mut state) as usize % bytes.len();
            bytes[at] = match random(&mut state) % 3 {
                0 => 0,
                1 => 0xff,
                _ => random(&mut state) as u8,
            };
        }
        if seed % 4 == 0 {
            bytes.truncate(random(&mut state) as usize % bytes.len());
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
