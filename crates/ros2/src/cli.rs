//! The command line.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use ros2_client::ServiceMapping;

/// The highest number of a DDS domain: the ports of a further one would not exist.
const MAX_DOMAIN: i64 = 232;

/// Publishes what Barrelman sees and does in ROS 2, and takes `engage` and `stop` as services.
///
/// The program is a client of the console of `barrelman run` or `barrelman demo`. DDS proves nobody's
/// identity: with the control token, whoever reaches the DDS domain may engage the camera. The watch token
/// permits `stop` alone.
#[derive(Debug, Clone, Parser)]
#[command(name = "barrelman-ros2", version)]
pub struct Cli {
    /// The address of the console. Off loopback: https:// alone.
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8480")]
    pub console: String,

    /// The file whose first line is the token: the watch token to publish and stop, the control token to
    /// engage, too. Without: a console that asks for no token.
    #[arg(long, value_name = "FILE")]
    pub token_file: Option<PathBuf>,

    /// The certificate authority of the console (PEM), for https://: `authority.pem` of the console, or that
    /// of the network.
    #[arg(long, value_name = "FILE")]
    pub ca: Option<PathBuf>,

    /// The name of the node, with its namespace: topics and services lie below it.
    #[arg(long, value_name = "NAME", default_value = "barrelman")]
    pub namespace: String,

    /// The DDS domain (`ROS_DOMAIN_ID` of the other nodes).
    #[arg(long, value_name = "NUMBER", default_value_t = 0,
          value_parser = clap::value_parser!(u16).range(0..=MAX_DOMAIN))]
    pub domain: u16,

    /// An address of this machine by which DDS is spoken; may be repeated. 127.0.0.1: with this machine
    /// alone. Without: all.
    #[arg(long, value_name = "ADDRESS")]
    pub dds_address: Vec<IpAddr>,

    /// The middleware of the nodes that call the services (their `RMW_IMPLEMENTATION`): each has its own form
    /// of calls. Topics are the same.
    #[arg(long, value_enum, default_value_t = Rmw::FastRtps)]
    pub rmw: Rmw,
}

/// A middleware of ROS 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Rmw {
    /// Fast DDS, the default of ROS 2. Connext, too.
    #[value(name = "rmw_fastrtps_cpp")]
    FastRtps,
    /// Cyclone DDS.
    #[value(name = "rmw_cyclonedds_cpp")]
    Cyclone,
}

impl Rmw {
    /// How this middleware maps a service to topics.
    pub const fn service_mapping(self) -> ServiceMapping {
        match self {
            Self::FastRtps => ServiceMapping::Enhanced,
            Self::Cyclone => ServiceMapping::Cyclone,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
        let cli = Cli::parse_from(["barrelman-ros2", "--rmw", "rmw_cyclonedds_cpp", "--domain", "232"]);
        assert_eq!((cli.rmw.service_mapping(), cli.domain), (ServiceMapping::Cyclone, 232));
        assert!(Cli::try_parse_from(["barrelman-ros2", "--domain", "233"]).is_err());
    }
}
