//! What a connection and a request pass before a route: the certificate, the names of the server, the tokens.

use std::sync::Arc;

use super::access::Access;
use super::guard::Hosts;
use super::https::Identity;
use super::issued_links::IssuedLinks;

/// How clients come in.
pub(super) struct Entrance {
    /// Tokens and cookies.
    pub(super) access: Access,
    /// The links with the tokens.
    pub(super) links: IssuedLinks,
    /// The names that the server answers to.
    pub(super) hosts: Hosts,
    /// The certificate; `None`: the connections are not encrypted.
    pub(super) https: Option<Arc<Identity>>,
}
