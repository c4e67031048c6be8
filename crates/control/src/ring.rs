//! A ring buffer of values in the order of their times.
//!
//! What must not be here: the meaning of the values, and the interval at which they are kept. Work: O(1) per
//! value; the only allocation is that of the buffer.

/// The newest `CAPACITY` values.
#[derive(Debug, Clone)]
pub(crate) struct Ring<T, const CAPACITY: usize> {
    values: Box<[T; CAPACITY]>,
    newest: usize,
    len: usize,
}

impl<T: Copy, const CAPACITY: usize> Ring<T, CAPACITY> {
    /// A ring with one value.
    pub(crate) fn new(first: T) -> Self {
        Self { values: Box::new([first; CAPACITY]), newest: 0, len: 1 }
    }

    /// Adds a value. The value replaces the newest one unless `is_apart(previous, newest)` holds.
    pub(crate) fn push(&mut self, value: T, is_apart: impl FnOnce(&T, &T) -> bool) {
        let previous = &self.values[(self.newest + CAPACITY - 1) % CAPACITY];
        if self.len < 2 || is_apart(previous, &self.values[self.newest]) {
            self.newest = (self.newest + 1) % CAPACITY;
            self.len = (self.len + 1).min(CAPACITY);
        }
        self.values[self.newest] = value;
    }

    pub(crate) const fn newest(&self) -> &T {
        &self.values[self.newest]
    }

    /// The values before the newest one, newest first.
    pub(crate) fn earlier(&self) -> impl Iterator<Item = &T> {
        (1..self.len).map(|back| &self.values[(self.newest + CAPACITY - back) % CAPACITY])
    }

    /// Changes all values.
    pub(crate) fn for_each_mut(&mut self, change: impl FnMut(&mut T)) {
        self.values.iter_mut().for_each(change);
    }
}
