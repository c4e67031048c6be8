//! What the run loop and the thread of a guarded link share: the guard's pipe, and the command that was
//! requested last.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::dead_mans_switch::RequestedCommand;
use crate::guard::gate::GuardedCommand;
use crate::guard::message::{MessageCommand, ToGuard};
use crate::guard::pipe::Pipe;

/// The commands that a guarded link carries.
pub trait Commands: GuardedCommand + MessageCommand {}

impl<C: GuardedCommand + MessageCommand> Commands for C {}

/// What the run loop and the thread share.
#[derive(Debug, Default)]
pub(super) struct Client<C>(Mutex<ClientState<C>>);

#[derive(Debug, Default)]
pub(super) struct ClientState<C> {
    pub(super) pipe: Option<Arc<Pipe>>,
    pub(super) requested: RequestedCommand<C>,
    /// Whether the operator takes the control back, and the guard was not told so yet.
    pub(super) takes_control: bool,
    /// Whether another client has the control, as the guard said last, and the operator has not taken it back
    /// since.
    pub(super) is_anothers: bool,
    pub(super) is_closing: bool,
}

impl<C: Commands> ClientState<C> {
    /// Sends a message, if there is a guard with room for it, and returns whether it was sent. The lock of
    /// the state is held meanwhile, so that the last command that was requested is the last one that is sent.
    /// Does not block.
    pub(super) fn send(&self, message: &ToGuard<C>) -> bool {
        self.pipe.as_ref().is_some_and(|pipe| pipe.send(&message.encode()))
    }

    /// Tells the guard that the operator takes the control back, if that is still to be told.
    pub(super) fn pass_on_control(&mut self) {
        if self.takes_control && self.send(&ToGuard::TakeControl) {
            (self.takes_control, self.is_anothers) = (false, false);
        }
    }
}

impl<C: Commands> Client<C> {
    pub(super) fn state(&self) -> MutexGuard<'_, ClientState<C>> {
        // Plain data, whole at any time: a panic elsewhere must not silence the link.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
