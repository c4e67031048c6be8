//! What is printed: tables of plain text, and the requirements with what was measured.

use std::fmt;

use serde_json::{Value, json};

use crate::say;

/// Rows of cells: the first column to the left, the others to the right.
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these headings.
    pub(crate) fn new(headings: &[&str]) -> Self {
        Self { rows: vec![headings.iter().map(|&heading| heading.to_owned()).collect()] }
    }

    /// One more row.
    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// Prints it below a title.
    pub(crate) fn say(&self, title: &str) {
        say(&format!("\n{title}\n{self}"));
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows
                .iter()
                .filter_map(|row| row.get(column))
                .map(|cell| cell.chars().count())
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for (index, row) in self.rows.iter().enumerate() {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                if column == 0 {
                    line.push_str(&format!("{cell:<width$}"));
                } else {
                    line.push_str(&format!("  {cell:>width$}"));
                }
            }
            writeln!(f, "{}", line.trim_end())?;
            if index == 0 {
                let total = widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1);
                writeln!(f, "{}", "-".repeat(total))?;
            }
        }
        Ok(())
    }
}

/// Requirements with what was measured, printed as they come.
#[derive(Default)]
pub(crate) struct Requirements {
    rows: Vec<Value>,
    missed: usize,
}

impl Requirements {
    /// A figure that may be no less than `wanted`.
    pub(crate) fn at_least(&mut self, name: &str, measured: f64, wanted: f64) {
        self.add(name, measured, &format!("at least {wanted}"), measured >= wanted);
    }

    /// A figure that may be no more than `wanted`.
    pub(crate) fn at_most(&mut self, name: &str, measured: f64, wanted: f64) {
        self.add(name, measured, &format!("at most {wanted}"), measured <= wanted);
    }

    /// A figure and whether it is as wanted.
    pub(crate) fn add(&mut self, name: &str, measured: f64, wanted: &str, holds: bool) {
        let mark = if holds { "ok    " } else { "MISSED" };
        say(&format!("{mark}  {name:<62}  {measured:>8.3}  {wanted}"));
        self.missed += usize::from(!holds);
        self.rows.push(json!({ "name": name, "measured": measured, "wanted": wanted, "holds": holds }));
    }

    /// Says how many hold, if any were judged; whether all do.
    pub(crate) fn finish(&self) -> bool {
        if !self.rows.is_empty() {
            say(&format!("\n{} of {} requirements hold", self.rows.len() - self.missed, self.rows.len()));
        }
        self.missed == 0
    }

    /// All of them, for a file.
    pub(crate) fn to_json(&self) -> Value {
        Value::Array(self.rows.clone())
    }
}

/// A cell of a table: so many decimals, or a dash where there is nothing.
pub(crate) fn cell(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { "-".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_stand_below_each_other() {
        let mut table = Table::new(&["clip", "AUC"]);
        table.row(vec!["orange_taxi".to_owned(), cell(0.5, 3)]);
        table.row(vec!["raft".to_owned(), cell(f64::NAN, 3)]);
        assert_eq!(
            table.to_string(),
            "clip           AUC\n------------------\norange_taxi  0.500\nraft             -\n"
        );
    }

    #[test]
    fn what_is_not_a_number_is_missed() {
        let mut requirements = Requirements::default();
        requirements.at_least("a", f64::NAN, 0.0);
        requirements.at_most("b", f64::NAN, 0.0);
        assert_eq!(requirements.missed, 2);
    }
}
