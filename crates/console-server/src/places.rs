//! Connections at a time. Who has shown no token gives way to anyone who comes, and who watches to the
//! operator, so that no other client keeps the operator out.
//!
//! ```text
//! one connects, and too many have shown no token -> the oldest of these closes
//! one shows its token, and too many have        -> the oldest that may only watch closes; without one, the one that came
//! ```

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use barrelman_host::clock::Clock;
use barrelman_vocab::Timestamp;
use tokio::sync::Notify;

use super::access::Role;
use super::limits::{
    MAX_CONNECTIONS, MAX_CONNECTIONS_OF_WATCHERS, MAX_STRANGERS, MAX_STRANGERS_OF_ADDRESS, REQUESTS,
    RateLimit,
};

/// The connections that are open.
#[derive(Debug)]
pub(super) struct Places {
    clock: Clock,
    open: Mutex<Open>,
}

#[derive(Debug, Default)]
struct Open {
    next: u64,
    /// By number: the oldest first.
    connections: BTreeMap<u64, Connection>,
}

#[derive(Debug)]
struct Connection {
    client: IpAddr,
    /// What the token permits that the connection has shown.
    shown: Option<Role>,
    gives_way: Arc<Notify>,
}

/// The place of a connection, until it is dropped.
#[derive(Debug)]
pub(super) struct Place {
    places: Arc<Places>,
    number: u64,
    gives_way: Arc<Notify>,
    /// Requests without a token.
    requests: Mutex<RateLimit>,
}

impl Places {
    /// No connection yet.
    pub(super) fn new(clock: Clock) -> Self {
        Self { clock, open: Mutex::default() }
    }

    /// A place for a connection from an address. Another connection may give way to it.
    pub(super) fn take(self: &Arc<Self>, address: IpAddr) -> Place {
        let client = client(address);
        let mut open = self.open();
        open.close_beyond(MAX_STRANGERS_OF_ADDRESS - 1, |one| one.shown.is_none() && one.client == client);
        open.close_beyond(MAX_STRANGERS - 1, |one| one.shown.is_none());
        let (number, gives_way) = (open.next, Arc::<Notify>::default());
        open.next += 1;
        open.connections
            .insert(number, Connection { client, shown: None, gives_way: Arc::clone(&gives_way) });
        let requests = Mutex::new(RateLimit::new(REQUESTS, self.clock.now()));
        Place { places: Arc::clone(self), number, gives_way, requests }
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Open {
    /// Closes the oldest connection of a kind, if there are more of them than `most`.
    fn close_beyond(&mut self, most: usize, is_one: impl Fn(&Connection) -> bool) {
        let mut found = self.connections.iter().filter(|(_, connection)| is_one(connection));
        let Some(oldest) = found.next().map(|(number, _)| *number) else { return };
        if found.count() + 1 > most {
            self.close(oldest);
        }
    }

    /// Closes a connection. Its place is free at once; its task ends with its next turn.
    fn close(&mut self, number: u64) {
        if let Some(connection) = self.connections.remove(&number) {
            connection.gives_way.notify_one();
        }
    }
}

impl Place {
    /// The connection has shown a token with this role.
    pub(super) fn show(&self, role: Role) {
        let mut open = self.places.open();
        let Some(connection) = open.connections.get_mut(&self.number) else { return };
        if connection.shown >= Some(role) {
            return;
        }
        connection.shown = Some(role);
        let is_watcher = |connection: &Connection| connection.shown == Some(Role::Watch);
        open.close_beyond(MAX_CONNECTIONS_OF_WATCHERS, is_watcher);
        let with_token = open.connections.values().filter(|connection| connection.shown.is_some()).count();
        if with_token > MAX_CONNECTIONS {
            let watcher = open.connections.iter().find(|(_, connection)| is_watcher(connection));
            let number = watcher.map_or(self.number, |(number, _)| *number);
            open.close(number);
        }
    }

    /// Whether a request without a token is within the limit of this connection.
    pub(super) fn permits_request(&self, now: Timestamp) -> bool {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner).takes(1.0, now)
    }

    /// Waits until the connection has to give way to another one.
    pub(super) async fn gives_way(&self) {
        self.gives_way.notified().await;
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.open().connections.remove(&self.number);
    }
}

/// What counts as one client: an address of IPv4, a network of 64 bits of IPv6, which one machine has all of.
fn client(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6(Ipv6Addr::from_bits(address.to_bits() >> 64 << 64)),
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> IpAddr {
        text.parse().expect("an address")
    }

    fn places() -> Arc<Places> {
        Arc::new(Places::new(Clock::start()))
    }

    /// Whether each connection stays.
    fn stay(places: &Places, taken: &[Place]) -> Vec<bool> {
        let open = places.open();
        taken.iter().map(|place| open.connections.contains_key(&place.number)).collect()
    }

    fn take(places: &Arc<Places>, count: usize, of: &str) -> Vec<Place> {
        (0..count).map(|_| places.take(address(of))).collect()
    }

    #[test]
    fn the_newest_comes_in_and_the_oldest_without_a_token_goes() {
        let places = places();
        let first = take(&places, 1, "192.168.2.1");
        let taken = take(&places, 500, "192.168.2.77");
        let stay = stay(&places, &taken);
        let newest = taken.len() - MAX_STRANGERS_OF_ADDRESS;
        assert!(stay[..newest].iter().all(|stays| !stays) && stay[newest..].iter().all(|stays| *stays));
        assert_eq!(super::tests::stay(&places, &first), [true], "one address leaves places for others");
        let _same = places.take(address("::ffff:192.168.2.77"));
        assert_eq!(places.open().connections.len(), MAX_STRANGERS_OF_ADDRESS + 1);
    }

    #[test]
    fn all_addresses_have_a_bound_together() {
        let places = places();
        let taken: Vec<_> =
            (0..1000_u16).map(|k| places.take(IpAddr::from([10, 0, (k >> 8) as u8, k as u8]))).collect();
        assert_eq!(places.open().connections.len(), MAX_STRANGERS);
        drop(taken);
        assert!(places.open().connections.is_empty(), "what is closed is forgotten");
    }

    #[test]
    fn a_network_of_ipv6_is_one_client() {
        let places = places();
        let _taken: Vec<Place> =
            (0..500).map(|k| places.take(address(&format!("fd00:1:2:3::{k:x}")))).collect();
        assert_eq!(places.open().connections.len(), MAX_STRANGERS_OF_ADDRESS);
    }

    #[test]
    fn who_has_shown_a_token_stays_while_strangers_come() {
        let places = places();
        let taken = take(&places, 3, "10.0.0.1");
        taken[0].show(Role::Watch);
        taken[1].show(Role::Control);
        let _more = take(&places, 1000, "10.0.0.1");
        assert_eq!(stay(&places, &taken), [true, true, false]);
    }

    #[test]
    fn watchers_leave_half_of_all_places_and_give_way_to_the_operator() {
        let places = places();
        let watchers = take(&places, MAX_CONNECTIONS_OF_WATCHERS + 2, "10.0.0.1");
        watchers.iter().for_each(|place| place.show(Role::Watch));
        let count = |stay: Vec<bool>| stay.iter().filter(|stays| **stays).count();
        assert_eq!(stay(&places, &watchers)[..3], [false, false, true], "the oldest go");
        assert_eq!(count(stay(&places, &watchers)), MAX_CONNECTIONS_OF_WATCHERS);
        let operators = take(&places, MAX_CONNECTIONS, "10.0.0.1");
        operators.iter().for_each(|place| place.show(Role::Control));
        assert_eq!((count(stay(&places, &watchers)), count(stay(&places, &operators))), (0, MAX_CONNECTIONS));
        // Where all have the control token, the one that came goes; a page that also shows the other token
        // stays what it is.
        let last = take(&places, 1, "10.0.0.2");
        operators[0].show(Role::Watch);
        last[0].show(Role::Control);
        assert_eq!(stay(&places, &last), [false]);
        assert_eq!(count(stay(&places, &operators)), MAX_CONNECTIONS);
    }
}
