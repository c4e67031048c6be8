//! Gives up the rights that a role does not need.
//!
//! A video stream is a stranger's input to large C libraries. Where one of them is taken over, the process
//! can still do what its role needs, and no more:
//!
//! | | decoder | source | share |
//! |---|---|---|---|
//! | files (Landlock) | none | reading of `/usr`, `/lib`, `/etc` and of what the address names | none |
//! | sockets (seccomp) | none new | all | connections to a socket that it was given |
//! | other programs, other processes, the kernel's own interfaces (seccomp) | none | none | none |
//!
//! The seccomp filter is a list of what is denied, with everything else allowed: what GStreamer's elements
//! and a graphics driver call differs from version to version, and a list of what is allowed would end
//! streams that are in order. A denied call fails with `EPERM`. Files and devices that were opened before
//! stay usable.
//!
//! Landlock holds for the calling thread and for those that it starts later; seccomp for all threads. So
//! rights are given up before a pipeline starts.

use std::collections::BTreeMap;
use std::os::unix::fs::FileTypeExt as _;
use std::path::PathBuf;

use landlock::{
    ABI, Access as _, AccessFs, PathBeneath, PathFd, Ruleset, RulesetAttr as _, RulesetCreatedAttr as _,
    RulesetError, RulesetStatus, Scope,
};
use rustix::process::{DumpableBehavior, Resource, Rlimit};
use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter, SeccompRule,
    apply_filter_all_threads,
};

/// The version of Landlock whose rights are known here. An older kernel restricts what it knows.
const LANDLOCK: ABI = ABI::V6;

/// What a role keeps.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    /// Files and folders that may be read.
    pub readable: Vec<PathBuf>,
    /// Devices that may be read, written and controlled.
    pub devices: Vec<PathBuf>,
    /// Which sockets may be opened.
    pub network: Network,
}

/// The sockets that a role may open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Network {
    /// None.
    #[default]
    None,
    /// Connections to a socket that is open already.
    Accepted,
    /// All.
    All,
}

/// No dump of the memory, which may hold a password: not at a crash, and not for another process of the user.
pub(crate) fn keep_memory_private() {
    let _ = rustix::process::set_dumpable_behavior(DumpableBehavior::NotDumpable);
    let _ = rustix::process::setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) });
}

/// Gives up all rights but those in `kept`. Where the kernel cannot do it, the log says so and the process
/// goes on.
pub(crate) fn give_up(kept: &Kept) {
    let _ = rustix::thread::set_no_new_privs(true);
    match restrict_files(kept) {
        Ok(RulesetStatus::FullyEnforced | RulesetStatus::PartiallyEnforced) => {}
        Ok(RulesetStatus::NotEnforced) => {
            crate::log::print_line("this kernel has no Landlock: the files of the user stay readable");
        }
        Err(error) => crate::log::print_line(&format!("the files of the user stay readable: {error}")),
    }
    if let Err(error) = restrict_calls(kept.network) {
        crate::log::print_line(&format!("the system calls of this process stay unrestricted: {error}"));
    }
}

fn restrict_files(kept: &Kept) -> Result<RulesetStatus, RulesetError> {
    let mut ruleset = Ruleset::default()
        .handle_access(AccessFs::from_all(LANDLOCK))?
        .scope(Scope::from_all(LANDLOCK))?
        .create()?;
    let file_only = AccessFs::from_file(LANDLOCK);
    let read = AccessFs::from_read(LANDLOCK);
    let control = AccessFs::ReadFile | AccessFs::WriteFile | AccessFs::IoctlDev;
    let readable = kept.readable.iter().map(|path| (path, read));
    let devices = kept.devices.iter().map(|path| (path, control | AccessFs::ReadDir));
    for (path, access) in readable.chain(devices) {
        // What does not exist needs no right: opening it fails either way, with the better reason. A pipe is
        // open already, and that of another process can have none.
        let Ok(opened) = PathFd::new(path) else { continue };
        if path.metadata().is_ok_and(|metadata| metadata.file_type().is_fifo()) {
            continue;
        }
        let access = if path.is_dir() { access } else { access & file_only };
        ruleset = ruleset.add_rule(PathBeneath::new(opened, access))?;
    }
    Ok(ruleset.restrict_self()?.ruleset)
}

/// Calls that no role needs: other programs and processes, the machine's set-up, and large interfaces of the
/// kernel.
const DENIED: &[libc::c_long] = &[
    libc::SYS_execve,
    libc::SYS_execveat,
    libc::SYS_ptrace,
    libc::SYS_process_vm_readv,
    libc::SYS_process_vm_writev,
    libc::SYS_pidfd_open,
    libc::SYS_pidfd_getfd,
    libc::SYS_pidfd_send_signal,
    libc::SYS_kill,
    libc::SYS_mount,
    libc::SYS_umount2,
    libc::SYS_pivot_root,
    libc::SYS_chroot,
    libc::SYS_move_mount,
    libc::SYS_open_tree,
    libc::SYS_fsopen,
    libc::SYS_fsmount,
    libc::SYS_unshare,
    libc::SYS_setns,
    libc::SYS_bpf,
    libc::SYS_perf_event_open,
    libc::SYS_userfaultfd,
    libc::SYS_io_uring_setup,
    libc::SYS_keyctl,
    libc::SYS_add_key,
    libc::SYS_request_key,
    libc::SYS_open_by_handle_at,
    libc::SYS_init_module,
    libc::SYS_finit_module,
    libc::SYS_delete_module,
    libc::SYS_kexec_load,
    libc::SYS_reboot,
    libc::SYS_swapon,
    libc::SYS_settimeofday,
    libc::SYS_clock_settime,
    libc::SYS_setuid,
    libc::SYS_setgid,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_fork,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_vfork,
];

/// Calls that open a socket.
const OPENED: &[libc::c_long] = &[libc::SYS_socket, libc::SYS_connect, libc::SYS_bind, libc::SYS_listen];

/// Calls that take a connection.
const ACCEPTED: &[libc::c_long] = &[libc::SYS_accept, libc::SYS_accept4];

fn restrict_calls(network: Network) -> Result<(), String> {
    let (opened, accepted) = match network {
        Network::None => (OPENED, ACCEPTED),
        Network::Accepted => (OPENED, [].as_slice()),
        Network::All => ([].as_slice(), [].as_slice()),
    };
    let mut denied: BTreeMap<libc::c_long, Vec<SeccompRule>> =
        DENIED.iter().chain(opened).chain(accepted).map(|&call| (call, Vec::new())).collect();
    // A new process. A new thread is allowed.
    let is_process = SeccompCondition::new(
        0,
        SeccompCmpArgLen::Qword,
        SeccompCmpOp::MaskedEq(libc::CLONE_THREAD as u64),
        0,
    );
    let is_process = is_process.and_then(|condition| SeccompRule::new(vec![condition]));
    denied.insert(libc::SYS_clone, vec![is_process.map_err(|error| error.to_string())?]);
    apply(denied, libc::EPERM)?;
    // The flags of `clone3` lie in memory, where a filter cannot look: the C library falls back on `clone`.
    apply(BTreeMap::from([(libc::SYS_clone3, Vec::new())]), libc::ENOSYS)
}

fn apply(denied: BTreeMap<libc::c_long, Vec<SeccompRule>>, errno: libc::c_int) -> Result<(), String> {
    let action = SeccompAction::Errno(errno as u32);
    let arch = std::env::consts::ARCH.try_into().map_err(|_| "unknown machine".to_owned())?;
    let filter = SeccompFilter::new(denied, SeccompAction::Allow, action, arch);
    let program: BpfProgram =
        filter.and_then(TryInto::try_into).map_err(|error: seccompiler::BackendError| error.to_string())?;
    apply_filter_all_threads(&program).map_err(|error| error.to_string())
}
