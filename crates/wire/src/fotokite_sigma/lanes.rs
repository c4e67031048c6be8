//! The requests that are under way: at most one of each lane.

use barrelman_vocab::Timestamp;

use super::call::{Call, Lane, Request};

/// The requests that are under way.
#[derive(Debug, Clone, Default)]
pub struct Lanes {
    under_way: Vec<(Request, Timestamp)>,
    next_id: u64,
}

impl Lanes {
    /// Whether no request of the lane is under way.
    pub fn is_free(&self, lane: Lane) -> bool {
        self.under_way.iter().all(|(request, _)| request.lane != lane)
    }

    /// Sends a call on a lane, which must be free.
    pub fn send(&mut self, lane: Lane, call: Call, now: Timestamp, out: &mut Vec<Request>) {
        self.next_id += 1;
        let request = Request { id: self.next_id, lane, call };
        self.under_way.push((request.clone(), now));
        out.push(request);
    }

    /// The call that an answer belongs to, whose lane is free again. `None`: an answer that came too late.
    pub fn take(&mut self, id: u64) -> Option<Call> {
        let at = self.under_way.iter().position(|(request, _)| request.id == id)?;
        Some(self.under_way.swap_remove(at).0.call)
    }

    /// The numbers of the requests whose time is over.
    pub fn overdue(&self, now: Timestamp) -> Vec<u64> {
        let is_over = |(request, at): &&(Request, Timestamp)| now.since(*at) >= request.lane.timeout();
        self.under_way.iter().filter(is_over).map(|(request, _)| request.id).collect()
    }

    /// When the next request is overdue.
    pub fn next_overdue(&self) -> Option<Timestamp> {
        self.under_way.iter().map(|(request, at)| at.plus(request.lane.timeout())).min()
    }
}
