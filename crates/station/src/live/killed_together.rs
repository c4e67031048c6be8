//! What would kill the guard together with the program, so that nothing is left that could send zeros: a PID
//! namespace (a container), and a unit of systemd that is killed as a whole.

use std::fs;
use std::process::{Command, Stdio};

/// The PID namespace of the machine itself (`PROC_PID_INIT_INO` of the kernel).
const PID_NAMESPACE_OF_MACHINE: &str = "pid:[4026531836]";

/// Warns, on a thread of its own, of what would kill the guard together with the program.
pub(super) fn warn() {
    // A run goes on without the warning where there are no more threads.
    let _ = std::thread::Builder::new().name("surroundings".to_owned()).spawn(|| {
        for warning in own_warnings() {
            tracing::warn!("{warning}");
        }
    });
}

/// What would kill a guard together with this process, in words.
pub fn own_warnings() -> Vec<String> {
    warnings(&Surroundings::read())
}

/// What the system says of the processes around.
#[derive(Debug, Default)]
struct Surroundings {
    /// The PID namespace of this process.
    pid_namespace: Option<String>,
    /// The unit of systemd, where this process belongs to one.
    unit: Option<String>,
    /// What systemd kills when the unit is stopped or fails.
    kill_mode: Option<String>,
    /// Whether a lack of memory kills the whole control group.
    is_killed_for_memory: bool,
}

impl Surroundings {
    fn read() -> Self {
        let cgroups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
        let group = cgroups.lines().find_map(|line| line.strip_prefix("0::")).unwrap_or_default();
        let unit = unit_of(group);
        let limit = fs::read_to_string(format!("/sys/fs/cgroup{group}/memory.oom.group"));
        Self {
            pid_namespace: fs::read_link("/proc/self/ns/pid").ok().map(|link| link.display().to_string()),
            kill_mode: unit.as_ref().and_then(|unit| kill_mode(unit, group.contains("/user@"))),
            is_killed_for_memory: limit.is_ok_and(|text| text.trim() == "1"),
            unit,
        }
    }
}

/// The unit of a control group: a service.
fn unit_of(group: &str) -> Option<String> {
    let last = group.rsplit('/').next()?;
    last.ends_with(".service").then(|| last.to_owned())
}

fn kill_mode(unit: &str, is_of_user: bool) -> Option<String> {
    let scope = if is_of_user { "--user" } else { "--system" };
    let asked = Command::new("systemctl")
        .args([scope, "show", "--property=KillMode", "--value", "--", unit])
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output();
    Some(String::from_utf8(asked.ok()?.stdout).ok()?.trim().to_owned())
}

fn warnings(around: &Surroundings) -> Vec<String> {
    let mut warnings = Vec::new();
    if around.pid_namespace.as_deref().is_some_and(|namespace| namespace != PID_NAMESPACE_OF_MACHINE) {
        warnings.push(
            "the program runs in a PID namespace (a container): if its first process ends or the container is killed, the guard \
             is killed, too, and camera or boat go on as they were last commanded; run it on the machine itself, or with a first \
             process that outlives barrelman and its guard (that of the Dockerfile does), and a long time to stop"
                .to_owned(),
        );
    }
    if let (Some(unit), Some("control-group" | "mixed")) = (&around.unit, around.kill_mode.as_deref()) {
        warnings.push(format!(
            "the unit {unit} kills all its processes together: set KillMode=process and OOMPolicy=continue in it, as \
             config/systemd/barrelman.service does, or the guard is killed before it has sent its zeros"
        ));
    }
    if around.is_killed_for_memory {
        warnings.push(
            "a lack of memory kills the whole control group (memory.oom.group), the guard, too: set OOMPolicy=continue in the unit"
                .to_owned(),
        );
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_kills_the_guard_together_with_the_program_is_named() {
        let own = || Surroundings {
            pid_namespace: Some(PID_NAMESPACE_OF_MACHINE.to_owned()),
            unit: Some("barrelman.service".to_owned()),
            kill_mode: Some("process".to_owned()),
            is_killed_for_memory: false,
        };
        assert_eq!(warnings(&own()), Vec::<String>::new());
        assert_eq!(warnings(&Surroundings::default()), Vec::<String>::new());
        let container = Surroundings { pid_namespace: Some("pid:[4026532201]".to_owned()), ..own() };
        let unit = Surroundings { kill_mode: Some("control-group".to_owned()), ..own() };
        let memory = Surroundings { is_killed_for_memory: true, ..own() };
        for (around, part) in
            [(container, "PID namespace"), (unit, "KillMode=process"), (memory, "OOMPolicy=continue")]
        {
            let warnings = warnings(&around);
            assert!(warnings.len() == 1 && warnings[0].contains(part), "{warnings:?}");
        }
    }

    #[test]
    fn a_service_is_found_in_the_name_of_its_control_group() {
        assert_eq!(unit_of("/system.slice/barrelman.service").as_deref(), Some("barrelman.service"));
        assert_eq!(unit_of("/user.slice/user-1000.slice/session-2.scope"), None);
        assert_eq!(unit_of("/"), None);
    }
}
