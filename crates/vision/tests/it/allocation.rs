//! No allocation per frame once the buffers have their size.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use barrelman_vision::{CamShift, CamShiftConfig, Explanation, Tracker};

use crate::scenes::{BLUE, RED, frame, pixels};

/// Counts what this thread asks for, so that tests beside it are not counted.
struct Counting;

thread_local! {
    static REQUESTS: Cell<usize> = const { Cell::new(0) };
}

#[allow(unsafe_code, reason = "the trait of an allocator is unsafe; every call goes to the system's own")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTS.with(|requests| requests.set(requests.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn tracking_and_explaining_allocate_nothing_after_the_first_frames() {
    let boat = |left: usize| frame((640, 480), BLUE, &[(RED, [left, 100 + left / 2, 60, 30])]);
    let path: Vec<_> = (0..20).map(|step| boat(40 + 20 * step)).collect();
    let gone = frame((640, 480), BLUE, &[]);
    let mut tracker = CamShift::new(CamShiftConfig::default()).unwrap();
    let mut explanation = Explanation::default();
    tracker.select(&path[0], pixels(40.0, 120.0, 60.0, 30.0)).unwrap();
    for frame in [&gone; 70] {
        // Grows the window, and with it the explanation's buffer, to the whole picture.
        tracker.track(frame, None);
        tracker.explain(&mut explanation);
    }
    let before = REQUESTS.get();
    assert!(before > 0, "the allocator is not counted");
    for frame in path.iter().chain([&gone; 10]).chain(path.iter().rev()) {
        tracker.track(frame, None);
        tracker.explain(&mut explanation);
    }
    assert_eq!(REQUESTS.get(), before);
}
