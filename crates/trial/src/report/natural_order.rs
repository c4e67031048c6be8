//! The natural order of names: `lab2/2` before `lab2/10`.

use core::cmp::Ordering;

/// Compares two names: runs of digits by their number, everything else by its characters.
pub(super) fn compare(first: &str, second: &str) -> Ordering {
    // Names that differ in leading zeros alone have the order of their characters.
    compare_parts(first, second).then_with(|| first.cmp(second))
}

fn compare_parts(mut first: &str, mut second: &str) -> Ordering {
    loop {
        let (a, b) = (next_part(first), next_part(second));
        let order = match (number(a), number(b)) {
            (Some(a), Some(b)) => a.len().cmp(&b.len()).then_with(|| a.cmp(b)),
            _ => a.cmp(b),
        };
        if order != Ordering::Equal || a.is_empty() {
            return order;
        }
        (first, second) = (&first[a.len()..], &second[b.len()..]);
    }
}

/// The first run of digits, or of other characters.
fn next_part(name: &str) -> &str {
    let is_number = name.starts_with(|first: char| first.is_ascii_digit());
    let end = name.find(|next: char| next.is_ascii_digit() != is_number).unwrap_or(name.len());
    &name[..end]
}

/// The digits of a run without leading zeros; `None` for other characters.
fn number(part: &str) -> Option<&str> {
    part.starts_with(|first: char| first.is_ascii_digit()).then(|| part.trim_start_matches('0'))
}

#[cfg(test)]
mod tests {
    use super::compare;

    #[test]
    fn numbers_are_ordered_by_their_value() {
        let expected = [
            "arena1_02",
            "arena1_10",
            "lab2/1",
            "lab2/2",
            "lab2/10",
            "lab2/10b",
            "lab10/1",
            "x",
            "x07",
            "x7",
        ];
        let mut names = expected;
        names.reverse();
        names.sort_by(|a, b| compare(a, b));
        assert_eq!(names, expected);
    }
}
