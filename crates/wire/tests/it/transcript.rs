//! Reads the transcripts.

use barrelman_vocab::{AngularRate, VehicleRates};

/// A case of a transcript.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) options: Vec<String>,
    pub(crate) events: Vec<(u64, Event)>,
}

/// An event of a case; events have times in milliseconds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Event {
    ClientSends(Vec<u8>),
    StationSends(Vec<u8>),
    Asked(VehicleRates),
    AskedToEnd,
    Reopens,
    Holds(Vec<String>),
    Ends,
}

impl Case {
    pub(crate) fn has(&self, option: &str) -> bool {
        self.options.iter().any(|found| found == option)
    }

    pub(crate) fn value(&self, key: &str) -> Option<&str> {
        self.options.iter().find_map(|option| option.strip_prefix(key)?.strip_prefix('='))
    }
}

pub(crate) fn fixture(name: &str) -> String {
    let path = format!("{}/../../fixtures/fotokite-pro/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The lines without empty lines and comments.
pub(crate) fn meaningful(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'))
}

/// A text with escapes, as bytes.
pub(crate) fn unescaped(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text;
    while let Some((plain, escape)) = rest.split_once('\\') {
        bytes.extend_from_slice(plain.as_bytes());
        let (byte, length) = match &escape[..1] {
            "r" => (b'\r', 1),
            "n" => (b'\n', 1),
            "s" => (b' ', 1),
            "x" => (u8::from_str_radix(&escape[1..3], 16).expect("two hexadecimal digits"), 3),
            other => panic!("unknown escape {other:?} in {text:?}"),
        };
        bytes.push(byte);
        rest = &escape[length..];
    }
    bytes.extend_from_slice(rest.as_bytes());
    bytes
}

pub(crate) fn rate(text: &str) -> AngularRate {
    AngularRate::from_radians_per_second(text.parse().expect("a rate"))
}

pub(crate) fn cases(name: &str) -> Vec<Case> {
    let text = fixture(name);
    let mut cases: Vec<Case> = Vec::new();
    for line in meaningful(&text) {
        if let Some(header) = line.strip_prefix("case ") {
            let mut words = header.split(' ').map(str::to_owned);
            let name = words.next().expect("a case has a name");
            cases.push(Case { name, options: words.collect(), events: Vec::new() });
            continue;
        }
        let digits = line.bytes().take_while(u8::is_ascii_digit).count();
        let time = line[..digits].parse().expect("a time in milliseconds");
        let (mark, text) = line[digits..].split_at(1);
        let text = text.strip_prefix(' ').unwrap_or(text);
        let event = match (mark, text) {
            (">", _) => Event::ClientSends(unescaped(text)),
            ("<", _) => Event::StationSends(unescaped(text)),
            ("?", "end") => Event::AskedToEnd,
            ("?", _) => {
                let words: Vec<&str> = text.split(' ').collect();
                let ["yaw", yaw, "pitch", pitch] = words[..] else { panic!("{line}") };
                Event::Asked(VehicleRates::turning(rate(yaw), rate(pitch)))
            }
            ("!", "reopen") => Event::Reopens,
            ("=", _) => Event::Holds(text.split(' ').map(str::to_owned).collect()),
            (".", "") => Event::Ends,
            _ => panic!("{name}: what is {line:?}?"),
        };
        cases.last_mut().expect("a case begins first").events.push((time, event));
    }
    assert!(!cases.is_empty(), "{name} has no cases");
    cases
}

/// The lines in some bytes, without their ends.
pub(crate) fn words(bytes: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes);
    text.split(['\r', '\n']).filter(|line| !line.is_empty()).map(str::to_owned).collect()
}
