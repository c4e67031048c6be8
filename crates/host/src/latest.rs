//! A slot for the newest value: a value that was not taken in time is replaced, and counted.
//!
//! The writer never waits. A reader takes the value without waiting ([`Latest::take`]) or waits for one
//! ([`Latest::wait`]).

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A slot for the newest value.
#[derive(Debug)]
pub struct Latest<T> {
    slot: Mutex<Slot<T>>,
    changed: Condvar,
}

#[derive(Debug)]
struct Slot<T> {
    value: Option<T>,
    replaced: u64,
    closed: bool,
}

impl<T> Default for Latest<T> {
    fn default() -> Self {
        let slot = Slot { value: None, replaced: 0, closed: false };
        Self { slot: Mutex::new(slot), changed: Condvar::new() }
    }
}

impl<T> Latest<T> {
    /// Stores a value. Returns whether the slot was empty, that is, whether the reader must be notified.
    pub fn put(&self, value: T) -> bool {
        let mut slot = self.slot();
        let replaced = slot.value.replace(value).is_some();
        slot.replaced += u64::from(replaced);
        self.changed.notify_all();
        !replaced
    }

    /// Takes the value, if there is one. Does not wait.
    pub fn take(&self) -> Option<T> {
        self.slot().value.take()
    }

    /// Waits for a value and takes it. Returns `None` once the slot is closed and empty.
    pub fn wait(&self) -> Option<T> {
        let is_pending = |slot: &mut Slot<T>| slot.value.is_none() && !slot.closed;
        let slot = self.changed.wait_while(self.slot(), is_pending);
        slot.unwrap_or_else(PoisonError::into_inner).value.take()
    }

    /// Waits for a value while `is_wanted` is false, which is asked again after each `interval`, and takes
    /// the newest one. Returns `None` as soon as the slot is closed.
    pub fn wait_until_wanted(&self, interval: Duration, is_wanted: impl Fn() -> bool) -> Option<T> {
        let mut slot = self.slot();
        loop {
            if slot.closed {
                return None;
            }
            if slot.value.is_some() && is_wanted() {
                return slot.value.take();
            }
            slot = self.changed.wait_timeout(slot, interval).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Waits at most so long for a value and takes it. Returns `None` at once where the slot is closed.
    pub fn wait_for(&self, most: Duration) -> Option<T> {
        let is_pending = |slot: &mut Slot<T>| slot.value.is_none() && !slot.closed;
        let waited = self.changed.wait_timeout_while(self.slot(), most, is_pending);
        waited.unwrap_or_else(PoisonError::into_inner).0.value.take()
    }

    /// The number of values that were replaced before they were taken.
    pub fn replaced(&self) -> u64 {
        self.slot().replaced
    }

    /// Closes the slot: no further value will come.
    pub fn close(&self) {
        self.slot().closed = true;
        self.changed.notify_all();
    }

    /// Whether the slot is closed.
    pub fn is_closed(&self) -> bool {
        self.slot().closed
    }

    fn slot(&self) -> MutexGuard<'_, Slot<T>> {
        // Plain data, whole at any time: a panic elsewhere does not spoil the slot.
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_value_wins_and_the_others_are_counted() {
        let latest = Latest::default();
        assert_eq!([latest.put(0), latest.put(1), latest.put(2)], [true, false, false]);
        assert_eq!((latest.take(), latest.replaced()), (Some(2), 2));
        assert_eq!(latest.take(), None);
        assert!(latest.put(3));
    }

    #[test]
    fn a_closed_slot_hands_out_its_last_value_and_then_none() {
        let latest = Latest::default();
        latest.put(1);
        latest.close();
        assert_eq!([latest.wait(), latest.wait()], [Some(1), None]);
        assert_eq!(latest.wait_for(Duration::MAX), None, "a closed slot is not waited for");
        latest.put(2);
        assert_eq!(latest.wait_until_wanted(Duration::ZERO, || true), None, "a closed slot wants nothing");
    }
}
