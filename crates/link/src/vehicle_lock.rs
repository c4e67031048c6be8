//! One run for each vehicle: a lock for the address of a vehicle on this machine.
//!
//! Two runs on one serial port are kept apart by the port's own lock. A network takes any number of
//! connections, and two runs would each command their own rates. The lock is a socket with an abstract name
//! (`unix(7)`): it is one for all users, ends with the last process that holds it, whatever ends that
//! process, and leaves no file that could be in the way or lead elsewhere.
//!
//! The program takes the lock, and its guard holds the same socket as its standard output. So the lock lasts
//! until the guard of a program that was killed has sent its zeros, and the next run waits for that.
//!
//! Addresses count as the same after names are looked up. Not seen: a vehicle with several addresses, and a
//! run in another network namespace (most containers).

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::net::{IpAddr, Ipv4Addr, ToSocketAddrs as _};
use std::os::fd::OwnedFd;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _};
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::Duration;

use rustix::time::ClockId;

use crate::url::{Endpoint, HttpAddress};

/// Longest wait for the guard of a run that is gone.
const GUARD_TIMEOUT: Duration = Duration::from_secs(3);
/// Interval between two attempts.
const ATTEMPT_INTERVAL: Duration = Duration::from_millis(50);
/// Longest part of a name that is used as it is, bytes.
const MAX_NAME_BYTES: usize = 80;
/// Ticks per second of the times in `/proc` (`proc_pid_stat(5)`), on every machine that Linux supports today.
const PROC_TICKS_PER_S: u64 = 100;

/// What a run commands at an address. A camera and a boat may be behind one address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VehicleRole {
    /// A vehicle with a camera.
    Camera,
    /// A boat.
    Boat,
}

/// The lock of a vehicle's address. It ends when the value and every guard that shares it are gone.
#[derive(Debug)]
pub struct VehicleLock(UnixDatagram);

/// Another run has the vehicle.
#[derive(Debug, thiserror::Error)]
pub enum VehicleLockError {
    /// Another program commands the vehicle.
    #[error(
        "{address} is commanded by another run ({holder}): end it first, or give the address of another vehicle"
    )]
    Held {
        /// The address.
        address: String,
        /// Who holds the lock.
        holder: String,
    },
    /// A guard whose program is gone still commands the vehicle.
    #[error(
        "the guard of an earlier run ({holder}) has not let go of {address} for {} s: it sends zeros until the vehicle is \
         reached, for a minute at most; start again then",
        GUARD_TIMEOUT.as_secs()
    )]
    GuardStays {
        /// The address.
        address: String,
        /// Who holds the lock.
        holder: String,
    },
    /// The system gives no lock.
    #[error("the lock of {address} cannot be taken")]
    System {
        /// The address.
        address: String,
        /// The error of the operating system.
        source: io::Error,
    },
}

impl VehicleLock {
    /// Takes the lock of an address. Waits for a guard whose program is gone, and tells `on_wait` once whom
    /// it waits for. `None`: the address is that of a simulated camera, which needs none.
    ///
    /// # Errors
    /// [`VehicleLockError`] says who holds it.
    pub fn take(
        endpoint: &Endpoint,
        role: VehicleRole,
        on_wait: impl Fn(&str),
    ) -> Result<Option<Self>, VehicleLockError> {
        let Some((key, address)) = key_of(endpoint) else { return Ok(None) };
        let role = match role {
            VehicleRole::Camera => "camera",
            VehicleRole::Boat => "boat",
        };
        let name = short(&format!("barrelman/{role}/{key}"));
        let system = |source| VehicleLockError::System { address: address.clone(), source };
        let place = SocketAddr::from_abstract_name(name.as_bytes()).map_err(system)?;
        let attempts = GUARD_TIMEOUT.as_millis() / ATTEMPT_INTERVAL.as_millis();
        let mut last = None;
        for attempt in 0..=attempts {
            match UnixDatagram::bind_addr(&place) {
                Ok(socket) => return Ok(Some(Self(socket))),
                Err(error) if error.kind() == io::ErrorKind::AddrInUse => {}
                Err(error) => return Err(system(error)),
            }
            let holders = holders_of(&name);
            if let Some(holder) = holders.iter().find(|holder| !holder.is_guard) {
                return Err(VehicleLockError::Held { address, holder: holder.text() });
            }
            if let (None, Some(guard)) = (&last, holders.first()) {
                on_wait(&guard.text());
            }
            last = holders.first().map(Holder::text).or(last);
            if attempt < attempts {
                std::thread::sleep(ATTEMPT_INTERVAL);
            }
        }
        Err(match last {
            Some(holder) => VehicleLockError::GuardStays { address, holder },
            None => {
                let holder = "of another user, or in another container".to_owned();
                VehicleLockError::Held { address, holder }
            }
        })
    }

    /// The lock for a guard, which holds it beside the program.
    ///
    /// # Errors
    /// If the system has no more file descriptors.
    pub fn share(&self) -> io::Result<OwnedFd> {
        Ok(self.0.try_clone()?.into())
    }
}

/// What an address is locked by, and the address in words.
fn key_of(endpoint: &Endpoint) -> Option<(String, String)> {
    Some(match endpoint {
        Endpoint::SimulatedCamera => return None,
        Endpoint::Serial { path, .. } => {
            let device = fs::metadata(path).ok().filter(|found| found.file_type().is_char_device());
            let shown = path.display().to_string();
            (
                device.map_or_else(|| format!("serial:{shown}"), |found| format!("device:{}", found.rdev())),
                shown,
            )
        }
        Endpoint::Tcp { address } => (format!("tcp:{}", resolved(address)), address.clone()),
        Endpoint::Udp { address } => (format!("udp:{}", resolved(address)), address.clone()),
        Endpoint::Http(http) => {
            (format!("tcp:{}", resolved(&HttpAddress::authority(http))), http.to_string())
        }
    })
}

/// `host:port` with the host's address in one form: the least of its addresses, and 127.0.0.1 for every name
/// of this machine's loopback.
fn resolved(authority: &str) -> String {
    let found = authority.to_socket_addrs().ok().into_iter().flatten();
    let in_one_form = |ip: IpAddr| match ip.to_canonical() {
        IpAddr::V6(ip) if ip.is_loopback() => IpAddr::V4(Ipv4Addr::LOCALHOST),
        ip if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
        ip => ip,
    };
    let least = found.map(|address| (in_one_form(address.ip()), address.port())).min();
    least.map_or_else(|| authority.to_ascii_lowercase(), |(ip, port)| format!("{ip}:{port}"))
}

/// A name of bounded length: a long one keeps its beginning, and a hash of the whole (FNV-1a).
fn short(name: &str) -> String {
    if name.len() <= MAX_NAME_BYTES {
        return name.to_owned();
    }
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let mut text: String = name.chars().take(MAX_NAME_BYTES / 4).collect();
    let _ = write!(text, "#{hash:016x}");
    text
}

/// A process that holds a lock.
struct Holder {
    pid: u32,
    /// Whether it holds the lock as its standard output, as guards do.
    is_guard: bool,
    age: Option<Duration>,
}

impl Holder {
    fn text(&self) -> String {
        let age = self.age.map_or_else(String::new, |age| format!(", for {} s", age.as_secs()));
        format!("process {}{age}", self.pid)
    }
}

/// The processes that hold the socket of a name, as far as this user may see them.
fn holders_of(name: &str) -> Vec<Holder> {
    let sockets = fs::read_to_string("/proc/net/unix").unwrap_or_default();
    let wanted = format!("@{name}");
    let inode = sockets.lines().find_map(|line| {
        let mut fields = line.split_ascii_whitespace().skip(6);
        let inode = fields.next()?;
        (fields.next()? == wanted).then(|| inode.to_owned())
    });
    let Some(inode) = inode else { return Vec::new() };
    let target = format!("socket:[{inode}]");
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    processes
        .filter_map(|process| {
            let pid: u32 = process.file_name().to_str()?.parse().ok()?;
            let files = fs::read_dir(process.path().join("fd")).ok()?;
            let held: Vec<_> = files
                .flatten()
                .filter(|file| fs::read_link(file.path()).is_ok_and(|to| to.as_os_str() == target.as_str()))
                .map(|file| file.file_name())
                .collect();
            let is_guard = held.iter().all(|number| number == "1");
            (!held.is_empty()).then(|| Holder { pid, is_guard, age: age_of(pid) })
        })
        .collect()
}

/// How long ago a process was started.
fn age_of(pid: u32) -> Option<Duration> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program, in parentheses, may hold anything.
    let started: u64 = stat.rsplit_once(')')?.1.split_ascii_whitespace().nth(19)?.parse().ok()?;
    let now = rustix::time::clock_gettime(ClockId::Boottime);
    let since_boot = Duration::new(now.tv_sec as u64, now.tv_nsec as u32);
    since_boot.checked_sub(Duration::from_millis(started * 1_000 / PROC_TICKS_PER_S))
}

#[cfg(test)]
mod tests {
    use std::process::{Command, Stdio};

    use super::*;
    use crate::url::LinkUrl;

    fn endpoint(text: &str) -> Endpoint {
        LinkUrl::parse(text).unwrap().endpoint
    }

    fn take(text: &str, role: VehicleRole) -> Result<Option<VehicleLock>, VehicleLockError> {
        VehicleLock::take(&endpoint(text), role, |_| {})
    }

    #[test]
    fn a_second_run_is_refused_by_whatever_name_it_knows_the_vehicle() {
        let _held = take("tcp://127.0.0.1:47011", VehicleRole::Camera).unwrap();
        for same in [
            "tcp://localhost:47011",
            "tcp://[::1]:47011",
            "tcp://[::ffff:127.0.0.1]:47011",
            "http://LOCALHOST:47011/api",
            "https://127.0.0.1:47011",
        ] {
            let error = take(same, VehicleRole::Camera).unwrap_err().to_string();
            assert!(error.contains(&format!("process {}, for ", std::process::id())), "{same}: {error}");
        }
        for other in ["tcp://127.0.0.1:47012", "tcp://127.0.0.2:47011", "udp://127.0.0.1:47011"] {
            assert!(take(other, VehicleRole::Camera).unwrap().is_some(), "{other}");
        }
        assert!(take("tcp://127.0.0.1:47011", VehicleRole::Boat).unwrap().is_some());
        assert!(take("sim:", VehicleRole::Camera).unwrap().is_none());
    }

    #[test]
    fn default_ports_are_named() {
        let key = |text: &str| key_of(&endpoint(text)).unwrap().0;
        assert_eq!(key("http://127.0.0.1/api"), key("tcp://127.0.0.1:80"));
        assert_eq!(key("https://127.0.0.1/api"), key("https://127.0.0.1:443"));
    }

    /// A process holds the lock as a guard does; the program that took the lock is gone.
    #[test]
    fn a_run_waits_for_the_guard_of_a_run_that_is_gone() {
        let lock = take("udp://127.0.0.1:47013", VehicleRole::Camera).unwrap().unwrap();
        let mut guard = Command::new("sleep")
            .arg("60")
            .stdin(Stdio::null())
            .stdout(Stdio::from(lock.share().unwrap()))
            .spawn()
            .unwrap();
        drop(lock);
        // What the run waits for ends when the run says that it waits.
        let guard_id = guard.id();
        let end = |told: &str| {
            assert!(told.contains(&format!("process {guard_id}")), "{told}");
            let pid = rustix::process::Pid::from_raw(guard_id as i32).unwrap();
            rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
        };
        let taken = VehicleLock::take(&endpoint("udp://127.0.0.1:47013"), VehicleRole::Camera, end);
        assert!(taken.unwrap().is_some());
        guard.wait().unwrap();
    }

    #[test]
    fn long_names_stay_apart() {
        let long = "x".repeat(300);
        assert_ne!(short(&format!("{long}a")), short(&format!("{long}b")));
        assert!(short(&long).len() <= MAX_NAME_BYTES);
        assert_eq!(short("camera"), "camera");
    }
}
