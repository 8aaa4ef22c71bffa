//! Addresses that a browser can open.

use std::net::{IpAddr, SocketAddr};

use nix::ifaddrs::getifaddrs;
use nix::net::if_::InterfaceFlags;

/// Where a server that is bound to `bound` can be reached, best first: for an address that stands
/// for all (0.0.0.0, ::), that of each interface that is up, the network's before this machine's
/// own.
pub(super) fn reachable(bound: SocketAddr) -> Vec<SocketAddr> {
    if !bound.ip().is_unspecified() {
        return vec![bound];
    }
    let loopback: IpAddr = match bound {
        SocketAddr::V4(_) => [127, 0, 0, 1].into(),
        SocketAddr::V6(_) => [0, 0, 0, 0, 0, 0, 0, 1].into(),
    };
    let ips = of_interfaces().into_iter().filter(|ip| {
        // Bound to ::, IPv4 comes in too, as Linux has it.
        ip.is_ipv4() || bound.is_ipv6()
    });
    let ips = ips.chain([loopback]);
    ips.map(|ip| SocketAddr::new(ip, bound.port())).collect()
}

/// Addresses of interfaces that are up, IPv4 first. Those that need a zone to be told apart are
/// left out: browsers do not take them.
fn of_interfaces() -> Vec<IpAddr> {
    let Ok(interfaces) = getifaddrs() else {
        return Vec::new();
    };
    let up = interfaces.filter(|interface| {
        interface.flags.contains(InterfaceFlags::IFF_UP)
            && !interface.flags.contains(InterfaceFlags::IFF_LOOPBACK)
    });
    let mut ips: Vec<IpAddr> = up
        .filter_map(|interface| {
            let address = interface.address?;
            let v4 = address.as_sockaddr_in().map(|a| IpAddr::V4(a.ip()));
            let v6 = address.as_sockaddr_in6().map(|a| a.ip());
            let v6 = v6.filter(|ip| !ip.is_unicast_link_local());
            v4.or(v6.map(IpAddr::V6))
        })
        .collect();
    ips.sort();
    ips.dedup();
    ips
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_for_all_becomes_addresses_that_can_be_opened() {
        for bound in ["0.0.0.0:8088", "[::]:8088"] {
            let reachable = reachable(bound.parse().unwrap());
            assert!(!reachable.is_empty());
            for address in &reachable {
                assert!(!address.ip().is_unspecified(), "{address}");
                assert_eq!(address.port(), 8088);
            }
            assert!(reachable.last().unwrap().ip().is_loopback());
        }
        let one = "10.1.2.3:80".parse().unwrap();
        assert_eq!(reachable(one), [one]);
    }
}
