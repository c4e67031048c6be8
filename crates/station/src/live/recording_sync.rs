//! Makes the disk keep a recording: content that a file system keeps in memory is lost in a power cut. A
//! thread of its own waits for the disk, as a card or a stick may take seconds; the recorder goes on.

use std::io;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use barrelman_host::output::OutputSync;

use super::event::Event;
use super::threads;

/// What the disk has to have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// What was written so far.
    Content,
    /// The same, and the name of the file.
    ContentAndName,
}

/// Brings what was written to the disk.
pub trait DiskSync: Send {
    /// Waits until the disk has it.
    ///
    /// # Errors
    /// The disk's.
    fn wait_for(&self, wanted: Wanted) -> io::Result<()>;
}

impl DiskSync for OutputSync {
    fn wait_for(&self, wanted: Wanted) -> io::Result<()> {
        match wanted {
            Wanted::Content => self.content(),
            Wanted::ContentAndName => self.content_and_name(),
        }
    }
}

/// The thread that waits for the disk.
pub(super) struct SyncThread {
    wanted: SyncSender<Wanted>,
    failed: Receiver<io::Error>,
    thread: JoinHandle<()>,
}

impl SyncThread {
    pub(super) fn start(sync: Box<dyn DiskSync>, events: SyncSender<Event>) -> io::Result<Self> {
        let (wanted, asked) = sync_channel(1);
        let (failure, failed) = channel();
        let thread = threads::spawn("recorder-sync", events, move || {
            for wanted in asked {
                if let Err(error) = sync.wait_for(wanted) {
                    // Without a receiver, the recording has ended.
                    let _ = failure.send(error);
                    return;
                }
            }
        })?;
        Ok(Self { wanted, failed, thread })
    }

    /// Asks for a wait, unless one is asked for already.
    ///
    /// # Errors
    /// That of an earlier wait.
    pub(super) fn ask(&self, wanted: Wanted) -> io::Result<()> {
        // A thread that has panicked has told the run.
        let _ = self.wanted.try_send(wanted);
        Self::failure_of(&self.failed)
    }

    fn failure_of(failed: &Receiver<io::Error>) -> io::Result<()> {
        failed.try_recv().map_or(Ok(()), Err)
    }

    /// Waits until the disk has the whole recording and its name.
    ///
    /// # Errors
    /// The disk's.
    pub(super) fn finish(self) -> io::Result<()> {
        let _ = self.wanted.send(Wanted::ContentAndName);
        drop(self.wanted);
        let _ = self.thread.join();
        Self::failure_of(&self.failed)
    }
}
