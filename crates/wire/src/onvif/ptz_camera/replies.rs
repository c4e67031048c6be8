//! The messages that a camera answers with.

use core::time::Duration;

use jiff::Timestamp as UtcTime;
use jiff::tz::TimeZone;
use quick_xml::escape::escape;

use super::answer::Answer;
use crate::onvif::ask::{Media, Service};
use crate::onvif::velocity::FullSpeeds;

const GENERIC: &str = "http://www.onvif.org/ver10/tptz/PanTiltSpaces";
const ZOOM: &str = "http://www.onvif.org/ver10/tptz/ZoomSpaces";

fn answer(status: u16, body: &str) -> Answer {
    let body = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\
         <s:Envelope xmlns:s=\"http://www.w3.org/2003/05/soap-envelope\" \
         xmlns:ter=\"http://www.onvif.org/ver10/error\" \
         xmlns:tds=\"{}\" xmlns:trt=\"{}\" xmlns:tptz=\"{}\" xmlns:tt=\"http://www.onvif.org/ver10/schema\">\
         <s:Body>{body}</s:Body></s:Envelope>",
        Service::Device.namespace(),
        Media::One.namespace(),
        Service::Ptz.namespace(),
    );
    Answer { status, body }
}

/// A refusal, with its codes from the widest to the narrowest.
pub(super) fn fault(status: u16, codes: &[&str], words: &str) -> Answer {
    let (first, rest) = codes.split_first().unwrap_or((&"s:Receiver", &[]));
    let subcodes = rest.iter().rev().fold(String::new(), |within, code| {
        format!("<s:Subcode><s:Value>{code}</s:Value>{within}</s:Subcode>")
    });
    answer(
        status,
        &format!(
            "<s:Fault><s:Code><s:Value>{first}</s:Value>{subcodes}</s:Code><s:Reason>\
             <s:Text xml:lang=\"en\">{words}</s:Text></s:Reason></s:Fault>"
        ),
    )
}

/// The answer that something has been done.
pub(super) fn done(name: &str) -> Answer {
    answer(200, &format!("<tptz:{name}/>"))
}

/// The time.
pub(super) fn date_and_time(clock: UtcTime) -> Answer {
    let utc = clock.to_zoned(TimeZone::UTC);
    answer(
        200,
        &format!(
            "<tds:GetSystemDateAndTimeResponse><tds:SystemDateAndTime>\
             <tt:DateTimeType>Manual</tt:DateTimeType><tt:DaylightSavings>false</tt:DaylightSavings>\
             <tt:TimeZone><tt:TZ>UTC0</tt:TZ></tt:TimeZone><tt:UTCDateTime>\
             <tt:Time><tt:Hour>{}</tt:Hour><tt:Minute>{}</tt:Minute><tt:Second>{}</tt:Second></tt:Time>\
             <tt:Date><tt:Year>{}</tt:Year><tt:Month>{}</tt:Month><tt:Day>{}</tt:Day></tt:Date>\
             </tt:UTCDateTime></tds:SystemDateAndTime></tds:GetSystemDateAndTimeResponse>",
            utc.hour(),
            utc.minute(),
            utc.second(),
            utc.year(),
            utc.month(),
            utc.day(),
        ),
    )
}

/// Where the services are.
pub(super) fn services(base: &str) -> Answer {
    let services = [
        (Service::Device, "device_service"),
        (Service::Media(Media::One), "media_service"),
        (Service::Ptz, "ptz_service"),
    ];
    let listed: String = services
        .iter()
        .map(|(service, path)| {
            format!(
                "<tds:Service><tds:Namespace>{}</tds:Namespace><tds:XAddr>{}/onvif/{path}</tds:XAddr>\
                 <tds:Version><tt:Major>2</tt:Major><tt:Minor>60</tt:Minor></tds:Version></tds:Service>",
                service.namespace(),
                escape(base),
            )
        })
        .collect();
    answer(200, &format!("<tds:GetServicesResponse>{listed}</tds:GetServicesResponse>"))
}

/// The same in the older form.
pub(super) fn capabilities(base: &str) -> Answer {
    let base = escape(base);
    answer(
        200,
        &format!(
            "<tds:GetCapabilitiesResponse><tds:Capabilities>\
             <tt:Media><tt:XAddr>{base}/onvif/media_service</tt:XAddr><tt:StreamingCapabilities/></tt:Media>\
             <tt:PTZ><tt:XAddr>{base}/onvif/ptz_service</tt:XAddr></tt:PTZ>\
             </tds:Capabilities></tds:GetCapabilitiesResponse>"
        ),
    )
}

/// The media profiles, of one video source: the first one cannot be moved.
pub(super) fn profiles(moving: &[(String, String)], source: &str, configuration: &str) -> Answer {
    let moving: String = moving
        .iter()
        .map(|(token, name)| {
            format!(
                "<trt:Profiles token=\"{token}\" fixed=\"true\"><tt:Name>{name}</tt:Name>\
                 <tt:VideoSourceConfiguration token=\"Video_1\"><tt:Name>picture</tt:Name><tt:UseCount>2</tt:UseCount>\
                 <tt:SourceToken>{source}</tt:SourceToken><tt:Bounds x=\"0\" y=\"0\" width=\"1280\" height=\"720\"/>\
                 </tt:VideoSourceConfiguration>\
                 <tt:PTZConfiguration token=\"{configuration}\"><tt:Name>motion</tt:Name>\
                 <tt:UseCount>2</tt:UseCount><tt:NodeToken>Node_1</tt:NodeToken></tt:PTZConfiguration></trt:Profiles>"
            )
        })
        .collect();
    answer(
        200,
        &format!(
            "<trt:GetProfilesResponse>\
             <trt:Profiles token=\"Fixed\" fixed=\"true\"><tt:Name>fixed</tt:Name></trt:Profiles>\
             {moving}</trt:GetProfilesResponse>"
        ),
    )
}

/// The address of the video.
pub(super) fn stream_uri(video: &str) -> Answer {
    answer(
        200,
        &format!(
            "<trt:GetStreamUriResponse><trt:MediaUri><tt:Uri>{}</tt:Uri>\
             <tt:InvalidAfterConnect>false</tt:InvalidAfterConnect><tt:InvalidAfterReboot>false\
             </tt:InvalidAfterReboot><tt:Timeout>PT0S</tt:Timeout></trt:MediaUri></trt:GetStreamUriResponse>",
            escape(video),
        ),
    )
}

/// The limits of the motion.
pub(super) fn move_options(full: FullSpeeds, (least, most): (Duration, Duration)) -> Answer {
    let range = |name: &str, max: f64| {
        format!("<tt:{name}><tt:Min>{}</tt:Min><tt:Max>{max}</tt:Max></tt:{name}>", -max)
    };
    let zoom = full.zoom.map_or_else(String::new, |full| {
        format!(
            "<tt:ContinuousZoomVelocitySpace><tt:URI>{ZOOM}/VelocityGenericSpace</tt:URI>{}\
             </tt:ContinuousZoomVelocitySpace>",
            range("XRange", full)
        )
    });
    answer(
        200,
        &format!(
            "<tptz:GetConfigurationOptionsResponse><tptz:PTZConfigurationOptions><tt:Spaces>\
             <tt:ContinuousPanTiltVelocitySpace><tt:URI>{GENERIC}/VelocityGenericSpace</tt:URI>{}{}\
             </tt:ContinuousPanTiltVelocitySpace>{zoom}</tt:Spaces>\
             <tt:PTZTimeout><tt:Min>PT{}S</tt:Min><tt:Max>PT{}S</tt:Max></tt:PTZTimeout>\
             </tptz:PTZConfigurationOptions></tptz:GetConfigurationOptionsResponse>",
            range("XRange", full.pan),
            range("YRange", full.tilt),
            least.as_secs_f64(),
            most.as_secs_f64(),
        ),
    )
}

/// Where the camera points, where it tells that, and whether it moves.
pub(super) fn status(position: Option<(f64, f64)>, is_moving: bool, clock: UtcTime) -> Answer {
    let position = position.map_or_else(String::new, |(pan, tilt)| {
        format!(
            "<tt:Position><tt:PanTilt x=\"{pan:.5}\" y=\"{tilt:.5}\" \
             space=\"{GENERIC}/PositionGenericSpace\"/></tt:Position>"
        )
    });
    let moving = if is_moving { "MOVING" } else { "IDLE" };
    answer(
        200,
        &format!(
            "<tptz:GetStatusResponse><tptz:PTZStatus>{position}<tt:MoveStatus><tt:PanTilt>{moving}</tt:PanTilt>\
             </tt:MoveStatus><tt:UtcTime>{}</tt:UtcTime></tptz:PTZStatus></tptz:GetStatusResponse>",
            clock.strftime("%Y-%m-%dT%H:%M:%SZ"),
        ),
    )
}
