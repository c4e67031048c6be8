//! The question to all cameras of a network, and their answers (WS-Discovery).

use serde::Deserialize;

use super::soap;

/// Where cameras listen for the question.
pub const MULTICAST: &str = "239.255.255.250:3702";

/// The question, with a number of its own, in the form of a UUID.
pub fn probe(id: [u8; 16]) -> String {
    const DISCOVERY: &str = "http://schemas.xmlsoap.org/ws/2005/04/discovery";
    const ADDRESSING: &str = "http://schemas.xmlsoap.org/ws/2004/08/addressing";
    let digits: String = id.iter().map(|byte| format!("{byte:02x}")).collect();
    let uuid = [&digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..]].join("-");
    let header = format!(
        "<a:Action xmlns:a=\"{ADDRESSING}\" s:mustUnderstand=\"1\">{DISCOVERY}/Probe</a:Action>\
         <a:MessageID xmlns:a=\"{ADDRESSING}\">uuid:{uuid}</a:MessageID>\
         <a:To xmlns:a=\"{ADDRESSING}\" s:mustUnderstand=\"1\">urn:schemas-xmlsoap-org:ws:2005:04:discovery</a:To>"
    );
    let body = format!(
        "<d:Probe xmlns:d=\"{DISCOVERY}\"><d:Types xmlns:n=\"http://www.onvif.org/ver10/network/wsdl\">\
         n:NetworkVideoTransmitter</d:Types></d:Probe>"
    );
    soap::envelope(&header, &body)
}

/// A camera that has answered.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct FoundCamera {
    /// Its name and its make, as far as it tells them; printable characters alone.
    pub name: String,
    /// The addresses of its first service: `http://HOST:PORT/onvif/device_service`.
    pub addresses: Vec<String>,
}

/// The cameras of an answer. What is no answer has none.
pub fn found(message: &[u8]) -> Vec<FoundCamera> {
    let matches = soap::read::<Body>(message).map(|body| body.matches.list).unwrap_or_default();
    matches
        .into_iter()
        .map(|one| FoundCamera {
            name: name_in(&one.scopes),
            addresses: one
                .addresses
                .split_whitespace()
                .filter(|text| is_plain(text))
                .map(str::to_owned)
                .collect(),
        })
        .filter(|camera| !camera.addresses.is_empty())
        .collect()
}

fn is_plain(text: &str) -> bool {
    text.len() <= 256 && text.bytes().all(|byte| byte.is_ascii_graphic())
}

/// Make and name from the scopes `onvif://www.onvif.org/hardware/...` and `.../name/...`.
fn name_in(scopes: &str) -> String {
    let value = |kind: &str| {
        let start = format!("onvif://www.onvif.org/{kind}/");
        let found = scopes.split_whitespace().find_map(|scope| scope.strip_prefix(&start));
        found.map(|text| text.replace("%20", " ").chars().filter(|c| !c.is_control()).take(64).collect())
    };
    let parts: Vec<String> = ["name", "hardware"].into_iter().filter_map(value).collect();
    parts.join(", ")
}

#[derive(Deserialize)]
struct Body {
    #[serde(rename = "ProbeMatches")]
    matches: Matches,
}

#[derive(Deserialize)]
struct Matches {
    #[serde(rename = "ProbeMatch", default)]
    list: Vec<Match>,
}

#[derive(Deserialize)]
struct Match {
    #[serde(rename = "Scopes", default)]
    scopes: String,
    #[serde(rename = "XAddrs", default)]
    addresses: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_names_its_camera_and_what_is_none_names_nothing() {
        let answer = "<e:Envelope xmlns:e=\"x\"><e:Body><d:ProbeMatches xmlns:d=\"y\"><d:ProbeMatch>\
            <d:Scopes>onvif://www.onvif.org/type/ptz onvif://www.onvif.org/name/Pier%20camera \
            onvif://www.onvif.org/hardware/P5</d:Scopes>\
            <d:XAddrs>http://192.0.2.9/onvif/device_service http://[fe80::1]/onvif/device_service</d:XAddrs>\
            </d:ProbeMatch><d:ProbeMatch><d:XAddrs></d:XAddrs></d:ProbeMatch></d:ProbeMatches></e:Body></e:Envelope>";
        let cameras = found(answer.as_bytes());
        assert_eq!(cameras.len(), 1);
        assert_eq!(cameras[0].name, "Pier camera, P5");
        assert_eq!(cameras[0].addresses[0], "http://192.0.2.9/onvif/device_service");
        assert!(found(b"lollipop").is_empty());
        assert!(found(probe([7; 16]).as_bytes()).is_empty());
    }
}
