//! Connections at a time: of all clients, and of one address, so that no single machine locks the operator out.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, PoisonError};

use super::limits::{MAX_CONNECTIONS, MAX_CONNECTIONS_OF_ADDRESS};

/// The connections that are open.
#[derive(Debug, Default)]
pub(super) struct Slots {
    /// Number of connections of each address.
    open: Mutex<HashMap<IpAddr, usize>>,
}

/// The place of a connection, until it is dropped.
#[derive(Debug)]
pub(super) struct Slot {
    slots: Arc<Slots>,
    client: IpAddr,
}

impl Slots {
    /// A place for a connection from an address; `None` where it or all have as many as they may have.
    pub(super) fn take(self: &Arc<Self>, address: IpAddr) -> Option<Slot> {
        let client = client(address);
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let of_client = open.get(&client).copied().unwrap_or(0);
        if of_client >= MAX_CONNECTIONS_OF_ADDRESS || open.values().sum::<usize>() >= MAX_CONNECTIONS {
            return None;
        }
        open.insert(client, of_client + 1);
        Some(Slot { slots: Arc::clone(self), client })
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let mut open = self.slots.open.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = open.get_mut(&self.client) {
            *count -= 1;
            if *count == 0 {
                open.remove(&self.client);
            }
        }
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

    #[test]
    fn one_address_leaves_places_for_others() {
        let slots = Arc::new(Slots::default());
        let taken: Vec<Slot> = (0..200).filter_map(|_| slots.take(address("192.168.2.77"))).collect();
        assert_eq!(taken.len(), MAX_CONNECTIONS_OF_ADDRESS);
        assert!(slots.take(address("192.168.2.1")).is_some());
        assert!(slots.take(address("::ffff:192.168.2.77")).is_none(), "the same address");
    }

    #[test]
    fn all_addresses_have_a_bound_together() {
        let slots = Arc::new(Slots::default());
        let taken = (0..200_u8).filter_map(|k| slots.take(IpAddr::from([10, 0, 0, k]))).collect::<Vec<_>>();
        assert_eq!(taken.len(), MAX_CONNECTIONS);
        drop(taken);
        assert!(slots.take(address("10.0.0.7")).is_some());
        assert!(slots.open.lock().unwrap().is_empty(), "what is closed is forgotten");
    }

    #[test]
    fn a_network_of_ipv6_is_one_client() {
        let slots = Arc::new(Slots::default());
        let taken: Vec<Slot> =
            (0..200).filter_map(|k| slots.take(address(&format!("fd00:1:2:3::{k:x}")))).collect();
        assert_eq!(taken.len(), MAX_CONNECTIONS_OF_ADDRESS);
        assert!(slots.take(address("fd00:1:2:4::1")).is_some());
    }
}
