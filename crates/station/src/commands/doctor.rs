//! `barrelman doctor`: looks at the machine that `run` would use, without any address: ports, cameras,
//! decoders, clock, disk, sleep. Each lack has its remedy.
//!
//! Nothing is opened but for reading, and nothing is changed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use anyhow::Result;
use barrelman_host::program;
use barrelman_link::guarded::GUARD_NAME;
use rustix::fs::Access;

use super::check::{UDEV_RULES, check_decoders, check_modem_manager, check_udev_rule};
use super::check_result::{CheckResult, Verdict, print};
use crate::cli::DoctorArgs;
use crate::config::RecordingConfig;
use crate::live::{killed_together, sleep_inhibitor};

/// Below this much free space a sortie may end without a recording.
const LITTLE_SPACE_GB: f64 = 5.0;
/// What a recording of 720p needs, GB an hour: 4 Mbit/s of video, and the outcomes.
const GB_PER_HOUR: f64 = 2.0;

/// Runs the command.
///
/// # Errors
/// If the output cannot be written. What is wrong with the machine is a result, not an error.
pub fn run(args: &DoctorArgs) -> Result<ExitCode> {
    let machine = Machine::own();
    let mut results = vec![
        machine.guard(),
        machine.serial_ports(),
        check_modem_manager(&machine.rules()),
        check_udev_rule(&machine.rules()),
        machine.cameras(),
        check_decoders(),
        clock(),
        machine.disk(),
        machine.sleep(),
    ];
    let around = killed_together::own_warnings();
    results.extend(around.into_iter().map(|text| CheckResult::new("guard", Verdict::Warning, text)));
    print(&results, args.json)
}

/// Where the parts of a machine are.
struct Machine {
    devices: PathBuf,
    /// The folder of the program: the guard is beside it.
    programs: Option<PathBuf>,
    udev_rules: [PathBuf; 2],
    recordings: PathBuf,
    lid: PathBuf,
    power_supplies: PathBuf,
    /// Whether a run can keep the machine awake.
    inhibits: fn() -> bool,
}

impl Machine {
    fn own() -> Self {
        let program = std::env::current_exe().ok();
        Self {
            devices: PathBuf::from("/dev"),
            programs: program.as_deref().and_then(Path::parent).map(Path::to_owned),
            udev_rules: UDEV_RULES.map(PathBuf::from),
            recordings: RecordingConfig::default().folder,
            lid: PathBuf::from("/proc/acpi/button/lid"),
            power_supplies: PathBuf::from("/sys/class/power_supply"),
            inhibits: sleep_inhibitor::is_possible,
        }
    }

    /// Where the udev rule of serial ports may be.
    fn rules(&self) -> [&Path; 2] {
        self.udev_rules.each_ref().map(PathBuf::as_path)
    }

    fn guard(&self) -> CheckResult {
        let path = self.programs.as_ref().map(|folder| folder.join(GUARD_NAME));
        match path.filter(|path| rustix::fs::access(path, Access::EXEC_OK).is_ok()) {
            Some(path) => CheckResult::new("guard", Verdict::Ok, path.display().to_string()),
            None => CheckResult::new(
                "guard",
                Verdict::Failed,
                format!(
                    "{GUARD_NAME} is not beside barrelman {}: install both programs together, or name it (link.guard)",
                    program::identity()
                ),
            ),
        }
    }

    fn serial_ports(&self) -> CheckResult {
        let ports = self.devices_named(&["ttyACM", "ttyUSB"]);
        if ports.is_empty() {
            let text = "none: plug in the ground station's USB cable, and switch it on";
            return CheckResult::new("serial ports", Verdict::Warning, text);
        }
        usable("serial ports", &ports, "dialout")
    }

    fn cameras(&self) -> CheckResult {
        let cameras = self.devices_named(&["video"]);
        if cameras.is_empty() {
            return CheckResult::new(
                "cameras",
                Verdict::Ok,
                "no USB camera or grabber; network video needs none",
            );
        }
        usable("cameras", &cameras, "video")
    }

    /// The devices whose names begin in one of these ways, sorted.
    fn devices_named(&self, beginnings: &[&str]) -> Vec<PathBuf> {
        let entries = fs::read_dir(&self.devices).into_iter().flatten().flatten();
        let mut found: Vec<_> = entries
            .filter(|entry| {
                let name = entry.file_name();
                beginnings.iter().any(|beginning| name.to_string_lossy().starts_with(beginning))
            })
            .map(|entry| entry.path())
            .collect();
        found.sort();
        found
    }

    fn disk(&self) -> CheckResult {
        let folder = &self.recordings;
        // The folder is made by the first recording: its disk is that of the next folder above that exists.
        let disk = folder.ancestors().find_map(|folder| {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            rustix::fs::statvfs(folder).ok()
        });
        let Some(disk) = disk else {
            return CheckResult::new(
                "recordings",
                Verdict::Warning,
                format!("{}: the disk does not answer", folder.display()),
            );
        };
        let free_gb = disk.f_bavail.saturating_mul(disk.f_frsize) as f64 / 1e9;
        let details = format!(
            "{}: {free_gb:.1} GB are free, about {:.0} hours of 720p",
            folder.display(),
            free_gb / GB_PER_HOUR
        );
        if free_gb >= LITTLE_SPACE_GB {
            return CheckResult::new("recordings", Verdict::Ok, details);
        }
        let remedy = "delete recordings on the page /library, or name another disk (recording.folder)";
        CheckResult::new("recordings", Verdict::Warning, format!("{details}: {remedy}"))
    }

    /// Whether the machine would go to sleep in mid-run: it has a lid or a battery.
    fn sleep(&self) -> CheckResult {
        let has_entries = |path: &Path| fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some());
        let has_battery = fs::read_dir(&self.power_supplies).into_iter().flatten().flatten().any(|supply| {
            fs::read_to_string(supply.path().join("type")).is_ok_and(|kind| kind.trim() == "Battery")
        });
        if !has_entries(&self.lid) && !has_battery {
            return CheckResult::new("sleep", Verdict::Ok, "no lid and no battery");
        }
        if (self.inhibits)() {
            let text = "a laptop: a run with a vehicle keeps it awake, with its lid closed, too";
            return CheckResult::new("sleep", Verdict::Ok, text);
        }
        CheckResult::new(
            "sleep",
            Verdict::Warning,
            "a laptop that systemd-inhibit does not keep awake: while it sleeps, nothing stops the camera. Run: sudo \
             systemctl mask sleep.target suspend.target",
        )
    }
}

/// Whether this user may read and write devices; `group`: who may.
fn usable(subject: &str, devices: &[PathBuf], group: &str) -> CheckResult {
    let names = |devices: &[&PathBuf]| {
        devices.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
    };
    let is_locked =
        |path: &&PathBuf| rustix::fs::access(path.as_path(), Access::READ_OK | Access::WRITE_OK).is_err();
    let locked: Vec<_> = devices.iter().filter(is_locked).collect();
    if locked.is_empty() {
        return CheckResult::new(subject, Verdict::Ok, names(&devices.iter().collect::<Vec<_>>()));
    }
    CheckResult::new(
        subject,
        Verdict::Failed,
        format!(
            "{}: this user may not use it. Run: sudo usermod -aG {group} $USER, then log out and in again",
            names(&locked)
        ),
    )
}

/// Whether the clock is set by others: recordings and marks on a map have its time.
fn clock() -> CheckResult {
    let asked = Command::new("timedatectl")
        .args(["show", "--property=NTPSynchronized", "--value"])
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output();
    let said = asked.ok().filter(|output| output.status.success());
    match said.as_ref().map(|output| output.stdout.trim_ascii()) {
        Some(b"yes") => CheckResult::new("clock", Verdict::Ok, "set by a time server"),
        Some(b"no") => CheckResult::new(
            "clock",
            Verdict::Warning,
            "not set by a time server: recordings have this machine's own time. With a network: sudo timedatectl set-ntp true",
        ),
        _ => CheckResult::new(
            "clock",
            Verdict::Warning,
            "not known, as timedatectl does not answer: compare `date` with a watch",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine in a folder of its own.
    struct Scene {
        folder: PathBuf,
        machine: Machine,
    }

    impl Scene {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("barrelman-doctor-{}-{name}", std::process::id()));
            fs::create_dir_all(folder.join("dev")).unwrap();
            let machine = Machine {
                devices: folder.join("dev"),
                programs: Some(folder.clone()),
                udev_rules: [folder.join("a.rules"), folder.join("b.rules")],
                recordings: folder.join("recordings"),
                lid: folder.join("lid"),
                power_supplies: folder.join("power"),
                inhibits: || false,
            };
            Self { folder, machine }
        }
    }

    impl Drop for Scene {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.folder);
        }
    }

    #[test]
    fn an_empty_machine_lacks_guard_ports_and_rule_and_needs_no_camera() {
        let scene = Scene::new("empty");
        let machine = &scene.machine;
        let verdicts = [
            machine.guard(),
            machine.serial_ports(),
            check_udev_rule(&machine.rules()),
            machine.cameras(),
            machine.sleep(),
        ]
        .map(|result| result.verdict);
        use Verdict::{Failed, Ok, Warning};
        assert_eq!(verdicts, [Failed, Warning, Warning, Ok, Ok]);
    }

    #[test]
    fn ports_that_may_be_used_are_listed_in_order() {
        let scene = Scene::new("ports");
        let machine = &scene.machine;
        for name in ["ttyUSB0", "ttyACM1", "ttyS0", "ttyACM0"] {
            fs::write(machine.devices.join(name), "").unwrap();
        }
        let CheckResult { verdict, details, .. } = machine.serial_ports();
        let names: Vec<_> = details.split(", ").filter_map(|path| path.rsplit('/').next()).collect();
        assert_eq!((verdict, names), (Verdict::Ok, vec!["ttyACM0", "ttyACM1", "ttyUSB0"]));
    }

    #[test]
    fn a_laptop_that_nothing_keeps_awake_is_named() {
        let mut scene = Scene::new("laptop");
        fs::create_dir_all(scene.machine.power_supplies.join("BAT0")).unwrap();
        fs::write(scene.machine.power_supplies.join("BAT0/type"), "Battery\n").unwrap();
        let result = scene.machine.sleep();
        assert_eq!(result.verdict, Verdict::Warning);
        assert!(result.details.contains("sleep.target"), "{}", result.details);
        scene.machine.inhibits = || true;
        assert_eq!(scene.machine.sleep().verdict, Verdict::Ok);
    }

    #[test]
    fn the_disk_of_a_folder_that_does_not_exist_yet_is_that_above() {
        let scene = Scene::new("disk");
        let machine = &scene.machine;
        let details = machine.disk().details;
        assert!(details.contains("GB are free, about"), "{details}");
    }
}
