//! Who is counted by rate limits and connection limits.

use std::net::{IpAddr, Ipv6Addr};

use crate::jobs::Owner;

/// The sender of a request, as rate limits count it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Client {
    /// The owner of an API key.
    Key(Owner),
    /// A network, as [`client_network`] returns it.
    Address(IpAddr),
}

/// Returns the address that stands for all addresses one client can connect from: an IPv4 address
/// itself, the /64 network of an IPv6 address, since a subscriber gets a whole one.
pub fn client_network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let network = address.to_bits() >> 64 << 64;
            IpAddr::V6(Ipv6Addr::from_bits(network))
        }
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_in_one_ipv6_network_share() {
        let at = |text: &str| client_network(text.parse().unwrap());
        assert_eq!(at("2001:db8:0:1::1"), at("2001:db8:0:1:ffff::2"));
        assert_ne!(at("2001:db8:0:1::1"), at("2001:db8:0:2::1"));
        assert_ne!(at("192.0.2.1"), at("192.0.2.2"));
    }
}
