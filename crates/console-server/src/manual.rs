//! The operator's manual, `/help`: `docs/console.md` with its pictures, embedded in the program.
//!
//! Every heading has an anchor, as on a page of the repository; so has the first cell of each row of a table,
//! and the row of an alarm also `alarm-KEY`. Links to other documents are left as their text: they are not in
//! the program.

use std::fmt::Write as _;
use std::sync::LazyLock;

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use barrelman_vocab::Named as _;
use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};

use crate::snapshot::Alarm;

const TEXT: &str = include_str!("../../../docs/console.md");

macro_rules! pictures {
    ($($name:literal),+ $(,)?) => {
        /// Name and content of each picture.
        const PICTURES: &[(&str, &[u8])] = &[$(($name, include_bytes!(concat!("../../../docs/pictures/", $name)))),+];
    };
}

pictures![
    "console-expert.jpg",
    "console-large.jpg",
    "console-phone.jpg",
    "console-sideways.jpg",
    "console-tablet.jpg",
    "console.jpg",
];

const HEAD: &str = r#"<!doctype html>
<html lang="en" data-theme="day">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Barrelman: manual</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/console/style.css">
<link rel="stylesheet" href="/console/help.css">
<script type="module" src="/console/help.js"></script>
</head>
<body>
"#;

/// The page.
static PAGE: LazyLock<String> = LazyLock::new(|| page_of(TEXT));

/// The answer with the manual.
pub(super) fn response() -> Response {
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], PAGE.as_str()).into_response()
}

/// The answer with a picture of the manual.
pub(super) fn picture(name: &str) -> Response {
    match PICTURES.iter().find(|(own, _)| *own == name) {
        Some((_, jpeg)) => ([(header::CONTENT_TYPE, "image/jpeg")], *jpeg).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such picture\n").into_response(),
    }
}

fn page_of(markdown: &str) -> String {
    let mut events: Vec<Event<'_>> =
        Parser::new_ext(markdown, Options::ENABLE_TABLES).filter(|event| !is_foreign_link(event)).collect();
    let contents = add_anchors(&mut events);
    let mut page = HEAD.to_owned();
    let _ = write!(
        page,
        "<header><a href=\"/\">Console</a><a href=\"/library\">Library</a></header>\n\
         <div id=\"manual\">\n<nav aria-label=\"Contents\"><ol>{contents}</ol></nav>\n<main>\n"
    );
    html::push_html(&mut page, events.into_iter().map(with_own_addresses));
    page.push_str("</main>\n</div>\n</body>\n</html>\n");
    page
}

/// Whether an event begins a link to another document. The ends of links are left out with those of
/// [`own_ends`].
fn is_foreign_link(event: &Event<'_>) -> bool {
    matches!(event, Event::Start(Tag::Link { dest_url, .. }) if !is_own(dest_url))
}

/// Whether an address leads to a part of the manual.
fn is_own(address: &str) -> bool {
    address.starts_with('#') || address.starts_with("pictures/")
}

/// Adds an anchor to each heading and to each row of a table. Returns the list of contents.
fn add_anchors(events: &mut Vec<Event<'_>>) -> String {
    let mut contents = String::new();
    let mut added = Vec::with_capacity(events.len());
    let mut own_links = 0_usize;
    let mut is_first_cell = false;
    for index in 0..events.len() {
        let mut event = events[index].clone();
        match &mut event {
            Event::Start(Tag::Heading { level, id, .. }) => {
                let text = text_until(&events[index..], |end| matches!(end, TagEnd::Heading(_)));
                let anchor = slug(&text);
                if *level == HeadingLevel::H2 {
                    let _ = write!(contents, "<li><a href=\"#{anchor}\">{}</a></li>", escaped(&text));
                }
                *id = Some(anchor.into());
            }
            Event::Start(Tag::TableRow) => is_first_cell = true,
            Event::Start(Tag::Link { .. }) => own_links += 1,
            // The beginning of this link was left out.
            Event::End(TagEnd::Link) if own_links == 0 => continue,
            Event::End(TagEnd::Link) => own_links -= 1,
            _ => {}
        }
        let begins_row = matches!(event, Event::Start(Tag::TableCell)) && std::mem::take(&mut is_first_cell);
        added.push(event);
        if begins_row {
            let text = text_until(&events[index..], |end| matches!(end, TagEnd::TableCell));
            added.push(Event::InlineHtml(row_anchors(&text).into()));
        }
    }
    *events = added;
    contents
}

/// The anchors of a row that begins with this text.
fn row_anchors(text: &str) -> String {
    let alarm = Alarm::ALL.iter().find(|alarm| slug(shown(alarm.text())) == slug(text));
    let alarm = alarm.map_or_else(String::new, |alarm| format!("<span id=\"alarm-{}\"></span>", alarm.key()));
    match slug(text) {
        anchor if anchor.is_empty() => alarm,
        anchor => format!("<span id=\"{anchor}\"></span>{alarm}"),
    }
}

/// The part of an alarm's text that the console shows as the alarm: what to do about it follows a colon.
fn shown(text: &str) -> &str {
    text.split(':').next().unwrap_or(text)
}

/// The text of the events up to this end.
fn text_until(events: &[Event<'_>], is_end: impl Fn(&TagEnd) -> bool) -> String {
    let until = events.iter().take_while(|event| !matches!(event, Event::End(end) if is_end(end)));
    until
        .filter_map(|event| match event {
            Event::Text(text) | Event::Code(text) => Some(text.as_ref()),
            _ => None,
        })
        .collect()
}

/// The anchor of a text: lower case, with hyphens for blanks.
fn slug(text: &str) -> String {
    let kept = text.chars().filter(|c| c.is_alphanumeric() || *c == ' ' || *c == '-');
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Pictures have their address in the program.
fn with_own_addresses(event: Event<'_>) -> Event<'_> {
    let own = |address: CowStr<'_>| match address.strip_prefix("pictures/") {
        Some(name) => CowStr::from(format!("/help/{name}")),
        None => address.into_string().into(),
    };
    match event {
        Event::Start(Tag::Image { link_type, dest_url, title, id }) => {
            Event::Start(Tag::Image { link_type, dest_url: own(dest_url), title, id })
        }
        Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
            Event::Start(Tag::Link { link_type, dest_url: own(dest_url), title, id })
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// What stands between `before` and the next quotation mark, each time.
    fn all_after<'a>(text: &'a str, before: &'a str) -> Vec<&'a str> {
        text.split(before).skip(1).filter_map(|rest| rest.split('"').next()).collect()
    }

    #[test]
    fn every_picture_and_every_anchor_that_the_page_names_is_there() {
        let ids = all_after(&PAGE, "id=\"");
        let unique: BTreeSet<_> = ids.iter().collect();
        assert_eq!(unique.len(), ids.len(), "{ids:?}");
        for anchor in all_after(&PAGE, "href=\"#") {
            assert!(unique.contains(&anchor), "{anchor}");
        }
        let pictures: BTreeSet<_> =
            all_after(&PAGE, "=\"/help/").into_iter().map(|name| (name, picture(name).status())).collect();
        assert_eq!(pictures, PICTURES.iter().map(|(name, _)| (*name, StatusCode::OK)).collect());
        for address in all_after(&PAGE, "href=\"").into_iter().chain(all_after(&PAGE, "src=\"")) {
            assert!(address.starts_with('#') || address.starts_with('/') || address == "data:,", "{address}");
        }
    }

    #[test]
    fn every_alarm_and_every_mode_has_its_row() {
        let ids: BTreeSet<_> = all_after(&PAGE, "id=\"").into_iter().collect();
        for alarm in Alarm::ALL {
            assert!(ids.contains(format!("alarm-{}", alarm.key()).as_str()), "{}", alarm.key());
        }
        let script = include_str!("../../../console/help_place.js");
        let modes: Vec<_> = all_after(script, ": \"");
        assert_eq!(modes.len(), 7, "{modes:?}");
        for mode in modes {
            assert!(ids.contains(mode), "{mode}");
        }
    }

    #[test]
    fn the_page_obeys_its_content_security_policy_and_links_no_other_document() {
        for word in ["style=", "<style", "onload=", "onerror=", "onclick=", "javascript:", "<iframe", ".md\""]
        {
            let found = PAGE.split('<').skip(1).any(|tag| {
                let tag = tag.split('>').next().unwrap_or_default();
                format!("<{tag}").contains(word)
            });
            assert!(!found, "{word}");
        }
        let links = |page: &str| (page.matches("<a ").count(), page.matches("</a>").count());
        let page = page_of("[one](other.md) and [two](#part)\n\n## Part\n");
        assert_eq!(links(&page), (4, 4), "{page}");
        assert!(page.contains("<p>one and <a href=\"#part\">two</a></p>"), "{page}");
    }

    #[test]
    fn the_pictures_make_the_program_at_most_a_megabyte_larger() {
        assert!(PICTURES.iter().map(|(_, jpeg)| jpeg.len()).sum::<usize>() <= 1_000_000);
    }
}
