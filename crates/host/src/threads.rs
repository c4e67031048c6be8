//! Threads whose panics are reported.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::JoinHandle;

/// Starts a named thread. A panic in the thread ends in a call of `on_panic` with the thread's name.
///
/// # Errors
/// If the system has no more threads.
pub fn spawn(
    name: &str,
    on_panic: impl FnOnce(String) + Send + 'static,
    work: impl FnOnce() + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    let thread = name.to_owned();
    std::thread::Builder::new().name(name.to_owned()).spawn(move || {
        if catch_unwind(AssertUnwindSafe(work)).is_err() {
            on_panic(thread);
        }
    })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn a_panic_is_reported_with_the_name_of_its_thread() {
        for (panics, expected) in [(true, Some("worker".to_owned())), (false, None)] {
            let (reports, reported) = channel();
            let on_panic = move |thread| reports.send(thread).unwrap();
            spawn("worker", on_panic, move || assert!(!panics)).unwrap().join().unwrap();
            assert_eq!(reported.try_recv().ok(), expected);
        }
    }
}
