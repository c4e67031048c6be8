//! The node of ROS 2.

mod topics;

mod services;

mod qos;

use std::net::{IpAddr, UdpSocket};

use anyhow::{Context as _, Result, anyhow};
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::{Context, Node, NodeName, NodeOptions, ServiceMapping, Spinner};

use crate::settings::{NodePath, Settings};

pub use services::{Calls, serve};
pub use topics::Topics;

/// The node with its topics and services.
pub struct RosNode {
    /// The topics.
    pub topics: Topics,
    /// The service `engage`.
    pub engage: Calls,
    /// The service `stop`.
    pub stop: Calls,
    node: Node,
}

impl RosNode {
    /// Joins the domain, and offers topics and services. The spinner's future keeps the book of subscribers.
    ///
    /// # Errors
    /// If DDS has no network, or no port is free.
    pub fn open(settings: &Settings, domain: u16, mapping: ServiceMapping) -> Result<(Self, Spinner)> {
        settings.dds_addresses.iter().try_for_each(check_address)?;
        let mut participant = DomainParticipantBuilder::new(domain);
        if !settings.dds_addresses.is_empty() {
            participant = participant.with_only_networks(settings.dds_addresses.iter().copied());
        }
        let participant = participant.build().map_err(|error| {
            anyhow!("DDS domain {domain} cannot be joined: {error}: check the network and --dds-address")
        })?;
        let context = Context::from_domain_participant(participant).context("DDS cannot be set up")?;
        let NodePath { namespace, name } = &settings.node;
        let node_name = NodeName::new(namespace, name).map_err(|error| anyhow!("--namespace: {error:?}"))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let mut node = context.new_node(node_name, options).context("the node cannot be made")?;
        let path = settings.node.absolute();
        let topics = Topics::advertise(&mut node, &path).context("a topic cannot be made")?;
        let engage =
            Calls::offer(&mut node, &path, "engage", mapping).context("the service engage cannot be made")?;
        let stop =
            Calls::offer(&mut node, &path, "stop", mapping).context("the service stop cannot be made")?;
        let spinner = node.spinner().context("the node cannot be run")?;
        Ok((Self { topics, engage, stop, node }, spinner))
    }

    /// Whether somebody subscribes to the pictures.
    pub fn wants_pictures(&self) -> bool {
        self.topics.pictures.has_subscribers(&self.node)
    }
}

/// DDS takes any address, and is silent with one that is another machine's.
fn check_address(address: &IpAddr) -> Result<()> {
    UdpSocket::bind((*address, 0)).with_context(|| {
        format!("--dds-address {address} is no address of this machine: `ip address` lists them")
    })?;
    Ok(())
}
