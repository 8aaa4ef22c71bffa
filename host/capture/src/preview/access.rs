//! Who may ask for what: names under which the preview may be opened, and the token without which
//! nothing can be changed.

use std::fs::File;
use std::io::{self, Read};
use std::net::IpAddr;

use hyper::header::{self, HeaderMap};
use hyper::{StatusCode, Uri};

/// Random bytes of a token.
const TOKEN_BYTES: usize = 16;
/// Header in which a page sends its token. A page of another origin cannot send it without asking
/// first, which is refused.
const TOKEN_HEADER: &str = "x-tectum-token";

/// Checks requests.
#[derive(Debug)]
pub(super) struct Access {
    token: String,
    own_names: Vec<String>,
}

impl Access {
    /// A new token, and this machine's names.
    ///
    /// # Errors
    /// What the system says if it has no random numbers.
    pub fn new() -> io::Result<Self> {
        let mut random = [0; TOKEN_BYTES];
        File::open("/dev/urandom")?.read_exact(&mut random)?;
        let token = random.iter().map(|byte| format!("{byte:02x}")).collect();
        let host = nix::unistd::gethostname().ok();
        let host = host.and_then(|name| name.into_string().ok());
        Ok(Self {
            token,
            own_names: own_names(host.as_deref()),
        })
    }

    /// What must be sent along to change anything.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Refuses requests that another site's name led here: with DNS rebinding a page of that site
    /// could read the cameras. An IP address is no name, so nobody else can make it lead here.
    pub fn check_name(&self, uri: &Uri, headers: &HeaderMap) -> Result<(), StatusCode> {
        let mut hosts = headers.get_all(header::HOST).iter();
        let (Some(host), None) = (hosts.next(), hosts.next()) else {
            return Err(StatusCode::BAD_REQUEST);
        };
        let host = host.to_str().unwrap_or_default();
        let in_uri = uri.authority().map(|authority| authority.as_str());
        let are_ours = [Some(host), in_uri].into_iter().flatten();
        if are_ours.into_iter().all(|host| self.is_ours(host)) {
            Ok(())
        } else {
            Err(StatusCode::FORBIDDEN)
        }
    }

    /// Whether a request may change something: it has the token, and if a browser says which page
    /// sent it, that page is this one.
    pub fn may_change(&self, headers: &HeaderMap) -> bool {
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
        let given = text(TOKEN_HEADER).unwrap_or_default();
        let host = text(header::HOST.as_str()).unwrap_or_default();
        let same_origin = text(header::ORIGIN.as_str())
            .is_none_or(|origin| origin.strip_prefix("http://") == Some(host));
        same_origin && is_equal(given.as_bytes(), self.token.as_bytes())
    }

    fn is_ours(&self, host: &str) -> bool {
        let name = match host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
            _ => host,
        };
        if let Some(literal) = name.strip_prefix('[') {
            // A zone (`%eth0`) says by which interface; it is no name.
            let literal = literal.strip_suffix(']').unwrap_or_default();
            let literal = literal.split('%').next().unwrap_or_default();
            return literal.parse::<std::net::Ipv6Addr>().is_ok();
        }
        let own = |own: &String| own.eq_ignore_ascii_case(name);
        name.parse::<IpAddr>().is_ok_and(|ip| ip.is_ipv4()) || self.own_names.iter().any(own)
    }
}

/// `localhost`, and what the machine is called on its network.
fn own_names(host: Option<&str>) -> Vec<String> {
    let mut names = vec!["localhost".to_owned()];
    if let Some(host) = host.filter(|host| !host.is_empty()) {
        names.push(host.to_owned());
        if !host.contains('.') {
            names.push(format!("{host}.local"));
        }
    }
    names
}

/// Compares in a time that does not tell where the difference is.
fn is_equal(a: &[u8], b: &[u8]) -> bool {
    let differences = a.iter().zip(b).fold(0, |sum, (a, b)| sum | (a ^ b));
    a.len() == b.len() && differences == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access() -> Access {
        Access {
            token: "secret".to_owned(),
            own_names: own_names(Some("fish")),
        }
    }

    #[test]
    fn addresses_and_own_names_are_ours_and_no_others() {
        for host in [
            "localhost",
            "LOCALHOST:8080",
            "127.0.0.1:1",
            "192.168.0.2",
            "[::1]:80",
            "[fe80::1%eth0]:80",
            "fish:8088",
            "Fish.local:8088",
        ] {
            assert!(access().is_ours(host), "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example:80",
            "fish.evil.example",
            "evil.local",
            "127.0.0.1.evil",
            "127.0.0.1@evil.example",
            "0x7f.1",
            "[evil.example]:80",
            "[::1",
            "::1",
            "",
            ":80",
        ] {
            assert!(!access().is_ours(host), "{host}");
        }
    }

    #[test]
    fn one_host_that_agrees_with_the_address_is_needed() {
        let check = |uri: &'static str, hosts: &[&'static str]| {
            let mut headers = HeaderMap::new();
            for host in hosts {
                headers.append(header::HOST, header::HeaderValue::from_static(host));
            }
            access().check_name(&Uri::from_static(uri), &headers)
        };
        assert_eq!(check("/left.jpg", &["127.0.0.1:8088"]), Ok(()));
        assert_eq!(check("/", &[]), Err(StatusCode::BAD_REQUEST));
        let two = ["localhost", "evil.example"];
        assert_eq!(check("/", &two), Err(StatusCode::BAD_REQUEST));
        let evil = Err(StatusCode::FORBIDDEN);
        assert_eq!(check("http://evil.example/", &["localhost"]), evil);
        assert_eq!(check("http://localhost/", &["evil.example"]), evil);
    }

    #[test]
    fn changes_need_the_token_and_come_from_this_page() {
        let may = |pairs: &[(&'static str, &'static str)]| {
            let mut headers = HeaderMap::new();
            for (name, value) in pairs {
                headers.append(*name, header::HeaderValue::from_static(value));
            }
            access().may_change(&headers)
        };
        let host = ("host", "10.0.0.1:8088");
        assert!(may(&[host, (TOKEN_HEADER, "secret")]));
        let origin = ("origin", "http://10.0.0.1:8088");
        assert!(may(&[host, origin, (TOKEN_HEADER, "secret")]));
        for pairs in [
            &[host][..],
            &[host, (TOKEN_HEADER, "")],
            &[host, (TOKEN_HEADER, "secre")],
            &[host, (TOKEN_HEADER, "secrets")],
            &[
                host,
                ("origin", "http://evil.example"),
                (TOKEN_HEADER, "secret"),
            ],
            &[host, ("origin", "null"), (TOKEN_HEADER, "secret")],
        ] {
            assert!(!may(pairs), "{pairs:?}");
        }
    }

    #[test]
    fn each_run_has_another_token() {
        let [a, b] = [(); 2].map(|()| Access::new().unwrap().token);
        assert_eq!(a.len(), 2 * TOKEN_BYTES);
        assert_ne!(a, b);
    }
}
