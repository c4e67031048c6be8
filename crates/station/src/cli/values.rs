//! Parsers of option values. Each error says what form or range the value must have.

use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{PictureSize, PixelBox};

/// A part of a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1.
    pub index: usize,
    /// Number of parts.
    pub count: usize,
}

/// Parses exactly `N` finite numbers. `form` is named in the error.
fn numbers<const N: usize>(text: &str, separator: char, form: &str) -> Result<[f64; N], String> {
    let wrong = || format!("expected {form}");
    let mut parts = text.split(separator);
    let mut values = [0.0; N];
    for value in &mut values {
        let part = parts.next().ok_or_else(wrong)?;
        *value = part.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(wrong)?;
    }
    if parts.next().is_some() { Err(wrong()) } else { Ok(values) }
}

pub(super) fn parse_box(text: &str) -> Result<PixelBox, String> {
    let [u, v, w, h] = numbers(text, ',', "X,Y,W,H in pixels, as in 600,300,80,60")?;
    if w <= 0.0 || h <= 0.0 {
        return Err(format!("the box is {w} wide and {h} high: width and height must be above zero"));
    }
    Ok(PixelBox { u, v, w, h })
}

pub(super) fn parse_size(text: &str) -> Result<PictureSize, String> {
    let [width, height] = numbers(text, 'x', "WIDTHxHEIGHT, as in 640x480")?;
    let side = |value: f64| (1.0..=65_536.0).contains(&value) && value.fract() == 0.0;
    if side(width) && side(height) {
        Ok(PictureSize::new(width as u32, height as u32))
    } else {
        Err("width and height must be whole numbers from 1 to 65536".to_owned())
    }
}

/// The size of a picture of a simulated world.
pub(super) fn parse_world_size(text: &str) -> Result<PictureSize, String> {
    let size = parse_size(text)?;
    if [size.width, size.height].iter().all(|side| (64..=4096).contains(side) && side.is_multiple_of(2)) {
        Ok(size)
    } else {
        Err("width and height of a simulated picture must be even numbers from 64 to 4096".to_owned())
    }
}

/// The address and port of a server.
pub(super) fn parse_listen(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| {
        "expected ADDRESS:PORT with an IP address, not a name, and a port up to 65535, as in 127.0.0.1:8480 (0.0.0.0:8480: for \
         other devices, too)"
            .to_owned()
    })
}

/// The name of a film that is written.
pub(super) fn parse_mp4_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4")) {
        Ok(path)
    } else {
        Err("the film is an MP4: its name must end in .mp4".to_owned())
    }
}

pub(super) fn parse_region(text: &str) -> Result<RegionShares, String> {
    let [half_width, half_height] = numbers(text, ',', "A,B, as in 0.6,0.5")?;
    let share = |value: f64| value > 0.0 && value <= 1.0;
    if share(half_width) && share(half_height) {
        Ok(RegionShares { half_width, half_height })
    } else {
        Err("both shares must be above 0 and at most 1".to_owned())
    }
}

pub(super) fn parse_positive(text: &str) -> Result<f64, String> {
    let [value] = numbers(text, '\0', "a number")?;
    if value > 0.0 { Ok(value) } else { Err("must be above zero".to_owned()) }
}

pub(super) fn parse_percent(text: &str) -> Result<f64, String> {
    let [value] = numbers(text, '\0', "a number")?;
    if (0.0..=100.0).contains(&value) { Ok(value) } else { Err("must be from 0 to 100".to_owned()) }
}

pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = parse_positive(text)?;
    if seconds <= 1.0e6 { Ok(seconds) } else { Err("must be at most a million seconds".to_owned()) }
}

pub(super) fn parse_hours(text: &str) -> Result<f64, String> {
    let [hours] = numbers(text, '\0', "a number")?;
    if (0.001..=100_000.0).contains(&hours) {
        Ok(hours)
    } else {
        Err("must be from 0.001 to 100000 hours".to_owned())
    }
}

pub(super) fn parse_clip_length(text: &str) -> Result<f64, String> {
    let seconds = parse_positive(text)?;
    if seconds <= 3600.0 { Ok(seconds) } else { Err("a clip may be at most 3600 s long".to_owned()) }
}

pub(super) fn parse_not_negative(text: &str) -> Result<f64, String> {
    let [value] = numbers(text, '\0', "a number")?;
    if value >= 0.0 { Ok(value) } else { Err("must not be negative".to_owned()) }
}

pub(super) fn parse_sea_state(text: &str) -> Result<u8, String> {
    text.parse()
        .ok()
        .filter(|state| *state <= 4)
        .ok_or_else(|| "a sea state must be a whole number from 0 (glassy) to 4 (moderate)".to_owned())
}

pub(super) fn parse_count(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|count| (1..=1024).contains(count))
        .ok_or_else(|| "must be a whole number from 1 to 1024".to_owned())
}

pub(super) fn parse_shard(text: &str) -> Result<Shard, String> {
    let wrong = || "expected I/N with I from 1 to N, as in 3/10".to_owned();
    let (index, count) = text.split_once('/').ok_or_else(wrong)?;
    let (index, count) = (index.parse().map_err(|_| wrong())?, count.parse().map_err(|_| wrong())?);
    if (1..=count).contains(&index) { Ok(Shard { index, count }) } else { Err(wrong()) }
}

pub(super) fn parse_rate(text: &str) -> Result<f64, String> {
    let [rate] = numbers(text, '\0', "a rate in rad/s, as in 0.3")?;
    if rate > 0.0 && rate <= 3.0 {
        Ok(rate)
    } else {
        Err("a rate must be above 0 and at most 3 rad/s".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each text parses, or is refused with an error that contains the words.
    #[track_caller]
    fn check<T>(parse: fn(&str) -> Result<T, String>, accepted: &[&str], refused: &[&str], words: &str) {
        for text in accepted {
            assert!(parse(text).is_ok(), "{text}");
        }
        for text in refused {
            let error = parse(text).err().unwrap_or_else(|| panic!("{text} is accepted"));
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    #[test]
    fn values_in_their_form_and_range_are_accepted_and_others_refused() {
        check(
            parse_box,
            &["600,300,80,60", "-4.5, 0, 1, 1"],
            &["1,2,3", "1,2,3,4,5", "a,2,3,4", "NaN,2,3,4"],
            "X,Y,W,H",
        );
        check(parse_box, &[], &["1,2,0,5", "1,2,5,-1"], "above zero");
        check(parse_size, &["640x480", "1x65536"], &["640", "640,480", "640x480x3"], "WIDTHxHEIGHT");
        check(parse_size, &[], &["0x480", "640.5x480", "65537x1"], "whole numbers");
        check(parse_world_size, &["64x64", "4096x2048"], &["10x10", "640x361", "4098x64"], "from 64 to 4096");
        check(
            parse_listen,
            &["127.0.0.1:8480", "[::1]:0"],
            &["localhost:8480", "127.0.0.1", "127.0.0.1:80000"],
            "127.0.0.1:8480",
        );
        check(parse_region, &["0.6,0.5", "1,1"], &["0,0.5", "0.6,1.1"], "at most 1");
        check(parse_positive, &["0.1", "7"], &["0", "-1"], "above zero");
        check(parse_seconds, &["0.5", "1e6"], &["1000001"], "million");
        check(parse_clip_length, &["20", "3600"], &["3601"], "3600");
        check(parse_not_negative, &["0", "12.5"], &["-0.1"], "negative");
        check(parse_sea_state, &["0", "4"], &["5", "-1", "1.5"], "sea state");
        check(parse_count, &["1", "1024"], &["0", "1025", "two"], "1 to 1024");
        check(parse_shard, &["1/1", "3/10"], &["0/10", "11/10", "3", "3/", "x/y"], "I/N");
        check(parse_rate, &["0.3", "3"], &["0", "3.1", "-1"], "at most 3");
    }

    #[test]
    fn a_film_s_name_ends_as_what_it_is() {
        check(parse_mp4_path, &["a.mp4", "films/B.MP4"], &["a.avi", "a", "mp4", ""], "must end in .mp4");
    }

    #[test]
    fn parsed_values_are_the_written_ones() {
        assert_eq!(parse_box("600,300,80,60").unwrap(), PixelBox { u: 600.0, v: 300.0, w: 80.0, h: 60.0 });
        assert_eq!(parse_size("640x480").unwrap(), PictureSize::new(640, 480));
        assert_eq!(parse_shard("3/10").unwrap(), Shard { index: 3, count: 10 });
        assert_eq!(parse_region("0.6,0.5").unwrap(), RegionShares { half_width: 0.6, half_height: 0.5 });
    }
}
