//! The gimbal devices, cameras and video streams of a MAVLink vehicle: which of them are used, and what
//! chooses them.

use barrelman_host::redaction::without_logins;
use barrelman_vocab::ZoomAbility;
use barrelman_vocab::mavlink::ComponentId;
use barrelman_wire::mavlink::camera_information::{CameraInformation, StreamInformation};
use barrelman_wire::mavlink::gimbal_choice::Device;
use barrelman_wire::mavlink::probe::Findings;

use super::check_result::{CheckResult, Verdict};

/// The devices, where there are several; all cameras and streams. `chosen`: the component of the camera that
/// zooms.
pub(super) fn equipment_results(findings: &Findings, chosen: Option<ComponentId>) -> Vec<CheckResult> {
    let mut results = Vec::new();
    let devices = findings.choice.devices();
    if devices.len() > 1 {
        results.extend(devices.iter().map(|device| device_result(device, findings)));
    }
    let is_chosen = |camera: &CameraInformation| chosen == Some(camera.camera.component);
    results.extend(findings.cameras.iter().map(|camera| camera_result(camera, is_chosen(camera))));
    if let Some(chosen) = chosen.filter(|_| !findings.cameras.iter().any(is_chosen)) {
        let details =
            format!("component {} (vehicle.camera) does not say what it is: nothing is zoomed", chosen.0);
        results.push(CheckResult::new("camera", Verdict::Warning, details));
    }
    results.extend(findings.streams.iter().map(stream_result));
    results
}

const fn used(is_used: bool) -> &'static str {
    if is_used { "used" } else { "not used" }
}

fn device_result(device: &Device, findings: &Findings) -> CheckResult {
    let used = used(findings.gimbal == Some(device.gimbal));
    let number = device.gimbal.device;
    let details = format!("{device}: {used}; vehicle.gimbal_device = {number} chooses it");
    CheckResult::new("device", Verdict::Ok, details)
}

fn camera_result(camera: &CameraInformation, is_used: bool) -> CheckResult {
    let (verdict, zoom) = match camera.zoom {
        ZoomAbility::Present => (Verdict::Ok, "which zooms"),
        ZoomAbility::Absent | ZoomAbility::NotKnown if is_used => (Verdict::Warning, "which does not zoom"),
        ZoomAbility::Absent | ZoomAbility::NotKnown => (Verdict::Ok, "which does not zoom"),
    };
    let (name, used) = (camera.equipment.name, used(is_used));
    let key = camera.camera.component.0;
    CheckResult::new("camera", verdict, format!("{name}, {zoom}: {used}; vehicle.camera = {key} chooses it"))
}

fn stream_result(stream: &StreamInformation) -> CheckResult {
    let StreamInformation { camera, number, name, uri } = stream;
    let uri = without_logins(uri);
    let details = format!("stream {number} of {camera} ({name}): {uri}; video.url, or --video, chooses it");
    CheckResult::new("stream", Verdict::Ok, details)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::mavlink::Address;
    use barrelman_vocab::{Equipment, EquipmentKind};
    use barrelman_wire::mavlink::Gimbal;
    use barrelman_wire::mavlink::gimbal_reader::Information;

    use super::*;

    #[test]
    fn several_gimbals_are_listed_with_their_axes_and_with_which_one_is_used() {
        let manager = Address::new(1, 1);
        let describe = |device, has_yaw, has_pitch, has_roll| Information {
            gimbal: Gimbal { manager, device },
            has_pitch,
            has_yaw,
            has_roll,
            pitch_stops: None,
            yaw_stops: None,
        };
        let found = |devices: &[Information]| {
            let mut findings = Findings { components: vec![manager], ..Findings::default() };
            for _ in 0..2 {
                for information in devices {
                    let chosen = findings.choice.on_information(*information, 1.0);
                    findings.gimbal = findings.gimbal.or(chosen);
                }
            }
            findings
        };
        let (rolls, whole) = (describe(1, false, false, true), describe(2, true, true, false));
        let (two, none) = (found(&[rolls, whole]), found(&[rolls]));
        let details = |findings: &Findings| -> Vec<String> {
            equipment_results(findings, None).into_iter().map(|result| result.details).collect()
        };
        let first = "device 1 of 1/1 has roll: not used; vehicle.gimbal_device = 1 chooses it";
        let second = "device 2 of 1/1 has pan and tilt: used; vehicle.gimbal_device = 2 chooses it";
        assert_eq!(details(&two), [first, second]);
        assert_eq!(details(&none), [""; 0], "there is nothing to choose");
    }

    fn camera(component: u8, zoom: ZoomAbility) -> CameraInformation {
        let camera = Address::new(1, component);
        let equipment = Equipment::new(EquipmentKind::Camera, &format!("{camera} Acme"));
        CameraInformation { camera, equipment, zoom }
    }

    #[test]
    fn cameras_and_streams_are_listed_with_what_chooses_them() {
        let stream = StreamInformation {
            camera: Address::new(1, 100),
            number: 2,
            name: "thermal".to_owned(),
            uri: "rtsp://user:secret@192.0.2.7/two".to_owned(),
        };
        let findings = Findings {
            cameras: vec![camera(101, ZoomAbility::Absent), camera(100, ZoomAbility::Present)],
            streams: vec![stream],
            ..Findings::default()
        };
        let check = |chosen: Option<u8>, expected: &[(Verdict, &str)]| {
            let results = equipment_results(&findings, chosen.map(ComponentId));
            let found: Vec<_> =
                results.iter().map(|result| (result.verdict, result.details.as_str())).collect();
            assert_eq!(found, expected, "{chosen:?}");
        };
        let stream = (
            Verdict::Ok,
            "stream 2 of 1/100 (thermal): rtsp://***@192.0.2.7/two; video.url, or --video, chooses it",
        );
        let zooming = "1/100 Acme, which zooms: used; vehicle.camera = 100 chooses it";
        let fixed = "1/101 Acme, which does not zoom: not used; vehicle.camera = 101 chooses it";
        check(Some(100), &[(Verdict::Ok, fixed), (Verdict::Ok, zooming), stream]);
        let unused = "1/100 Acme, which zooms: not used; vehicle.camera = 100 chooses it";
        check(None, &[(Verdict::Ok, fixed), (Verdict::Ok, unused), stream]);
        let chosen = "1/101 Acme, which does not zoom: used; vehicle.camera = 101 chooses it";
        check(Some(101), &[(Verdict::Warning, chosen), (Verdict::Ok, unused), stream]);
        let silent = "component 102 (vehicle.camera) does not say what it is: nothing is zoomed";
        check(Some(102), &[(Verdict::Ok, fixed), (Verdict::Ok, unused), (Verdict::Warning, silent), stream]);
    }
}
