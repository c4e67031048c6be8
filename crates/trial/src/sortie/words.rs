//! A sortie in words.

use barrelman_vocab::{HoldCause, Named as _, StopCause};

use super::{Sortie, Spells};

impl Sortie {
    /// What happened, a line for each concern. Times of day are not in it.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("video {}; link {}", self.video, self.link_or_dry_run())];
        lines.push(if self.engaged_s > 0.0 {
            let share = 100.0 * self.followed_s / self.engaged_s;
            format!("engaged {}, the boat known for {share:.1} % of that", length(self.engaged_s))
        } else {
            "never engaged".to_owned()
        });
        lines.push(format!("boat lost: {}", spells(&self.losses)));
        lines.extend(self.holds.iter().map(|(key, held)| {
            let cause = HoldCause::ALL.iter().find(|cause| cause.key() == key);
            format!("camera held, {}: {}", cause.map_or("", |cause| cause.text()), spells(held))
        }));
        lines.extend(self.stops.iter().map(|(key, count)| {
            let cause = StopCause::ALL.iter().find(|cause| cause.key() == key);
            format!("stopped {}: {}", cause.map_or("", |cause| cause.text()), times(*count))
        }));
        let (camera, schema) = (self.camera, self.schema);
        let noun = if camera.moves == 1 { "movement" } else { "movements" };
        lines.push(format!(
            "camera: {} {noun}, {:.2} rad (the motor schema: about {}, {:.2} rad)",
            camera.moves, camera.travel_rad, schema.moves, schema.travel_rad
        ));
        lines
    }

    fn link_or_dry_run(&self) -> &str {
        if self.link.is_empty() { "dry run" } else { &self.link }
    }
}

/// A length of time, such as "3 min 12 s".
pub fn length(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, _) => format!("{seconds:.1} s"),
        (0, minutes, seconds) => format!("{minutes} min {seconds} s"),
        (hours, minutes, _) => format!("{hours} h {minutes} min"),
    }
}

fn spells(spells: &Spells) -> String {
    match spells.count {
        0 => "never".to_owned(),
        1 => format!("once, {}", length(spells.total_s)),
        count => {
            let (total, longest) = (length(spells.total_s), length(spells.longest_s));
            format!("{}, {total} in all, {longest} the longest", times(count))
        }
    }
}

fn times(count: u64) -> String {
    if count == 1 { "once".to_owned() } else { format!("{count} times") }
}
