//! Text of a page and of figures: escaping, and numbers as people read them.

/// Escapes text for the content and the quoted attributes of HTML and XML. Characters that XML does not have
/// become U+FFFD.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    escape_to(text, &mut escaped);
    escaped
}

fn escape_to(text: &str, out: &mut String) {
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\u{0}'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            character => out.push(character),
        }
    }
}

/// Text from outside (names of files and scenarios) in a template of the page, escaped by [`escape`]. The
/// template's own escaping does not replace the characters that XML does not have.
pub(super) struct Text<'a>(pub(super) &'a str);

impl maud::Render for Text<'_> {
    fn render_to(&self, buffer: &mut String) {
        escape_to(self.0, buffer);
    }
}

/// A number with the given number of decimals and a typographic minus sign; no negative zero.
pub(super) fn format_number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.contains(|digit: char| ('1'..='9').contains(&digit)) => {
            format!("\u{2212}{digits}")
        }
        Some(digits) => digits.to_owned(),
        None => text,
    }
}

/// A number, or a dash for `None`.
pub(super) fn number_or_dash(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "\u{2013}".to_owned(), |value| format_number(value, decimals))
}

/// A count with its noun: `1 trial`, `2 trials`.
pub(super) fn count_of(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Converts text to a portable file name: letters, digits, `-` and `_`; any other character becomes `-`. At
/// most 60 characters.
pub(super) fn to_file_name(text: &str) -> String {
    let portable = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    text.chars().map(portable).take(60).collect()
}
