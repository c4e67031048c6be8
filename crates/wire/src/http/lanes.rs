//! The requests that are under way: at most one of each lane.

use barrelman_vocab::Timestamp;

use super::request::{HttpCall, Lane, Request};

/// The requests that are under way.
#[derive(Debug, Clone)]
pub struct Lanes<C> {
    under_way: Vec<(Request<C>, Timestamp)>,
    next_id: u64,
}

impl<C> Default for Lanes<C> {
    fn default() -> Self {
        Self { under_way: Vec::new(), next_id: 0 }
    }
}

impl<C: HttpCall> Lanes<C> {
    /// Whether no request of the lane is under way.
    pub fn is_free(&self, lane: Lane) -> bool {
        self.under_way.iter().all(|(request, _)| request.lane != lane)
    }

    /// Sends a call on a lane, which must be free.
    pub fn send(&mut self, lane: Lane, call: C, now: Timestamp, out: &mut Vec<Request<C>>) {
        self.next_id += 1;
        let request = Request { id: self.next_id, lane, call };
        self.under_way.push((request.clone(), now));
        out.push(request);
    }

    /// The call that an answer belongs to, whose lane is free again. `None`: an answer that came too late.
    pub fn take(&mut self, id: u64) -> Option<C> {
        let at = self.under_way.iter().position(|(request, _)| request.id == id)?;
        Some(self.under_way.swap_remove(at).0.call)
    }

    /// The numbers of the requests whose time is over.
    pub fn overdue(&self, now: Timestamp) -> Vec<u64> {
        let is_over = |(request, at): &&(Request<C>, Timestamp)| now.since(*at) >= C::timeout(request.lane);
        self.under_way.iter().filter(is_over).map(|(request, _)| request.id).collect()
    }

    /// When the next request is overdue.
    pub fn next_overdue(&self) -> Option<Timestamp> {
        self.under_way.iter().map(|(request, at)| at.plus(C::timeout(request.lane))).min()
    }
}
