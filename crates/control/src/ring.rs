//! The last few values, each of a later time than the one before, in a ring.
//!
//! What must not be here: what the values mean, and how close two of them may lie. O(1), no allocation but the first.

/// The newest values, as many as are kept.
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

    /// Takes a value. It takes the newest one's place unless that is `apart` enough from the one before it.
    pub(crate) fn push(&mut self, value: T, apart: impl FnOnce(&T, &T) -> bool) {
        let before = &self.values[(self.newest + CAPACITY - 1) % CAPACITY];
        if self.len < 2 || apart(before, &self.values[self.newest]) {
            self.newest = (self.newest + 1) % CAPACITY;
            self.len = (self.len + 1).min(CAPACITY);
        }
        self.values[self.newest] = value;
    }

    pub(crate) const fn newest(&self) -> &T {
        &self.values[self.newest]
    }

    /// Those before the newest, back to the oldest.
    pub(crate) fn earlier(&self) -> impl Iterator<Item = &T> {
        (1..self.len).map(|back| &self.values[(self.newest + CAPACITY - back) % CAPACITY])
    }

    /// Changes all of them.
    pub(crate) fn for_each_mut(&mut self, change: impl FnMut(&mut T)) {
        self.values.iter_mut().for_each(change);
    }
}
