//! Stop as a latch: pressing it needs no room in a queue, and it stays pressed until the loop has taken it.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counts presses of Stop, and the presses that the pilot has taken.
#[derive(Debug, Default)]
pub struct StopLatch {
    pressed: AtomicU64,
    taken: AtomicU64,
}

impl StopLatch {
    /// Presses Stop. Returns the number of the press, from 1; it has been taken when [`Self::taken`] has
    /// reached it.
    pub fn press(&self) -> u64 {
        self.pressed.fetch_add(1, Ordering::SeqCst) + 1
    }

    /// The number of presses.
    pub fn pressed(&self) -> u64 {
        self.pressed.load(Ordering::SeqCst)
    }

    /// The newest press that the pilot has not taken.
    pub fn pending(&self) -> Option<u64> {
        let pressed = self.pressed();
        (pressed > self.taken()).then_some(pressed)
    }

    /// Notes that the pilot has taken the stop: all presses up to `press`.
    pub fn acknowledge(&self, press: u64) {
        self.taken.fetch_max(press, Ordering::SeqCst);
    }

    /// The number of presses that the pilot has taken.
    pub fn taken(&self) -> u64 {
        self.taken.load(Ordering::SeqCst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_is_pending_until_it_is_acknowledged() {
        let latch = StopLatch::default();
        assert_eq!(latch.pending(), None);
        assert_eq!([latch.press(), latch.press()], [1, 2]);
        assert_eq!(latch.pending(), Some(2));
        latch.acknowledge(2);
        assert_eq!((latch.pending(), latch.taken()), (None, 2));
    }

    #[test]
    fn a_press_during_the_acknowledgement_stays_pending() {
        let latch = StopLatch::default();
        let taken = latch.press();
        latch.press();
        latch.acknowledge(taken);
        assert_eq!(latch.pending(), Some(2));
    }

    #[test]
    fn an_acknowledgement_never_takes_another_one_back() {
        let latch = StopLatch::default();
        let presses = [latch.press(), latch.press(), latch.press()];
        latch.acknowledge(presses[2]);
        latch.acknowledge(presses[0]);
        assert_eq!((latch.pending(), latch.taken()), (None, 3));
        assert_eq!(latch.press(), 4);
        assert_eq!(latch.pending(), Some(4));
    }

    #[test]
    fn presses_from_many_threads_are_counted_once_each() {
        let latch = StopLatch::default();
        let mut presses: Vec<u64> = std::thread::scope(|scope| {
            let press = || (0..250).map(|_| latch.press()).collect::<Vec<_>>();
            let threads = [(); 4].map(|()| scope.spawn(press));
            threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
        });
        presses.sort_unstable();
        assert_eq!(presses, (1..=1000).collect::<Vec<_>>());
        assert_eq!(latch.pending(), Some(1000));
    }
}
