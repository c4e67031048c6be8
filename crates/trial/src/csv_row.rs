//! Rows of CSV (RFC 4180) without line ends in their cells: writing and reading of quoted cells.

use std::borrow::Cow;

/// Text as a cell: quoted where it holds a comma, a quote or a line end.
pub fn quoted(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

/// The cells of a row, without the quotes. A quote that is not closed lasts to the end of the row.
pub fn cells(row: &str) -> Vec<Cow<'_, str>> {
    let mut cells = Vec::new();
    let mut rest = Some(row);
    while let Some(text) = rest {
        let (cell, others) = first_cell(text);
        cells.push(cell);
        rest = others;
    }
    cells
}

/// The first cell, and what follows the comma behind it.
fn first_cell(text: &str) -> (Cow<'_, str>, Option<&str>) {
    let Some(mut rest) = text.strip_prefix('"') else {
        let (cell, others) = up_to_comma(text);
        return (Cow::Borrowed(cell), others);
    };
    let mut cell = String::new();
    while let Some((content, after)) = rest.split_once('"') {
        cell.push_str(content);
        let Some(more) = after.strip_prefix('"') else {
            let (content, others) = up_to_comma(after);
            return (Cow::Owned(cell + content), others);
        };
        cell.push('"');
        rest = more;
    }
    (Cow::Owned(cell + rest), None)
}

fn up_to_comma(text: &str) -> (&str, Option<&str>) {
    text.split_once(',').map_or((text, None), |(cell, others)| (cell, Some(others)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_read_as_it_was_written() {
        let check = |texts: &[&str], row: &str| {
            let written: Vec<_> = texts.iter().map(|text| quoted(text)).collect();
            assert_eq!(written.join(","), row);
            assert_eq!(cells(row), texts);
        };
        check(&["1", "", "-2.5"], "1,,-2.5");
        check(&[""], "");
        check(&["holding: dry run, nothing is sent", "3"], "\"holding: dry run, nothing is sent\",3");
        check(&["a", "say \"no\"", ""], "a,\"say \"\"no\"\"\",");
    }

    #[test]
    fn any_row_has_cells() {
        assert_eq!(cells("\"never closed, 1"), ["never closed, 1"]);
        assert_eq!(cells("\"closed\" early,1"), ["closed early", "1"]);
        assert_eq!(cells("in \"the\" middle,1"), ["in \"the\" middle", "1"]);
    }
}
