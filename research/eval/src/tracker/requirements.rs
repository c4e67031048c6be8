//! The requirements that are judged, with the measured figures.

use serde_json::{Value, json};

use crate::output::print_line;

/// The judged requirements. Each is printed when it is added.
#[derive(Default)]
pub(crate) struct Requirements {
    rows: Vec<Value>,
    missed: usize,
}

impl Requirements {
    /// Judges a figure that must be at least `wanted`.
    pub(crate) fn at_least(&mut self, name: &str, measured: f64, wanted: f64) {
        self.add(name, measured, &format!("at least {wanted}"), measured >= wanted);
    }

    /// Judges a figure that must be at most `wanted`.
    pub(crate) fn at_most(&mut self, name: &str, measured: f64, wanted: f64) {
        self.add(name, measured, &format!("at most {wanted}"), measured <= wanted);
    }

    /// Adds a figure with its requirement in words, and whether the requirement holds.
    pub(crate) fn add(&mut self, name: &str, measured: f64, wanted: &str, is_met: bool) {
        let mark = if is_met { "ok    " } else { "MISSED" };
        print_line(&format!("{mark}  {name:<62}  {measured:>8.3}  {wanted}"));
        self.missed += usize::from(!is_met);
        self.rows.push(json!({ "name": name, "measured": measured, "wanted": wanted, "holds": is_met }));
    }

    /// Prints how many requirements hold, if any were judged. Returns whether all hold.
    pub(crate) fn finish(&self) -> bool {
        if !self.rows.is_empty() {
            print_line(&format!(
                "\n{} of {} requirements hold",
                self.rows.len() - self.missed,
                self.rows.len()
            ));
        }
        self.missed == 0
    }

    /// All requirements, for a file.
    pub(crate) fn to_json(&self) -> Value {
        Value::Array(self.rows.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_is_nan_is_missed() {
        let mut requirements = Requirements::default();
        requirements.at_least("a", f64::NAN, 0.0);
        requirements.at_most("b", f64::NAN, 0.0);
        assert_eq!(requirements.missed, 2);
    }
}
