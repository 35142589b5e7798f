//! Pages of the web that may connect, and names under which this server may be called.
//!
//! A browser lets any page open a WebSocket to this computer, and says which page it was in `Origin`; programs that
//! are no browsers do not. `Host` is what the address was called: a page whose name was made to point here
//! (DNS rebinding) gives itself away by it.

use std::net::IpAddr;

use tungstenite::http::{HeaderMap, header};

/// Viewers in the web; the last is that of viewers which are installed, whose pages are files.
const VIEWERS: [&str; 2] = ["https://app.foxglove.dev", "file://"];

/// Clients that may connect.
#[derive(Debug)]
pub(crate) struct Guests {
    /// Origins that are let in besides those on this computer and the known viewers; `*` for all.
    pub(crate) origins: Vec<String>,
    /// Whether only this computer is listened to.
    pub(crate) only_here: bool,
}

impl Guests {
    /// Refuses a handshake.
    ///
    /// # Errors
    ///
    /// The reason, for the client and the terminal.
    pub(crate) fn check(&self, headers: &HeaderMap) -> Result<(), String> {
        // A header that is no text is like one of nobody.
        let all = |name| (headers.get_all(name).iter()).map(|value| value.to_str().unwrap_or("?"));
        for origin in all(header::ORIGIN) {
            let allowed = |other: &String| other == "*" || other.trim_end_matches('/') == origin;
            let known = VIEWERS.contains(&origin) || is_here(host_of(origin));
            if !known && !self.origins.iter().any(allowed) {
                return Err(format!(
                    "pages of {origin:.200} may not connect: --allow-origin {origin:.200} lets them"
                ));
            }
        }
        match all(header::HOST).find(|host| self.only_here && !is_here(name_of(host))) {
            Some(host) => Err(format!(
                "expected localhost or a number as this computer's name, found {host:.200}"
            )),
            None => Ok(()),
        }
    }
}

/// Name and port in an origin such as `https://app.foxglove.dev:443`.
fn host_of(origin: &str) -> &str {
    let host = ["http://", "https://"].map(|scheme| origin.strip_prefix(scheme));
    name_of(host.into_iter().flatten().next().unwrap_or_default())
}

/// The name or number without a port.
fn name_of(host: &str) -> &str {
    match host.strip_prefix('[').and_then(|host| host.split_once(']')) {
        Some((number, _)) => number,
        None => host.split(':').next().unwrap_or_default(),
    }
}

/// Whether a name or number always means the computer that it is used on.
fn is_here(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name == "localhost"
        || name.ends_with(".localhost")
        || (name.parse::<IpAddr>()).is_ok_and(|number| number.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(only_here: bool, origins: &[&str], headers: &[(header::HeaderName, &str)]) -> bool {
        let origins = origins.iter().map(|&origin| origin.to_owned()).collect();
        let headers = headers.iter().cloned();
        let headers = headers.map(|(name, value)| (name, value.parse().expect("a header")));
        Guests { origins, only_here }
            .check(&headers.collect())
            .is_ok()
    }

    #[test]
    fn pages_of_others_are_refused_unless_they_are_allowed() {
        let from = |origin| [(header::ORIGIN, origin)];
        for own in [
            "http://localhost:8080",
            "https://app.localhost",
            "http://127.0.0.1",
            "http://[::1]:3000",
            "https://app.foxglove.dev",
            "file://",
        ] {
            assert!(check(true, &[], &from(own)), "{own}");
        }
        for other in [
            "https://evil.example",
            "null",
            "http://localhost.evil.example",
            "http://evil.example:80/localhost",
            "https://app.foxglove.dev.evil.example",
            "http://192.168.0.5:8080",
            "localhost",
        ] {
            assert!(!check(true, &[], &from(other)), "{other}");
            assert!(
                !check(false, &["https://viewer.example"], &from(other)),
                "{other}"
            );
            assert!(check(true, &[other], &from(other)), "{other}");
            assert!(check(true, &["*"], &from(other)), "{other}");
        }
        assert!(check(
            true,
            &["https://viewer.example/"],
            &from("https://viewer.example")
        ));
        assert!(
            check(true, &[], &[]),
            "programs do not say where they are from"
        );
    }

    #[test]
    fn names_that_may_point_anywhere_are_refused_where_only_this_computer_is_listened_to() {
        let to = |host| [(header::HOST, host)];
        for here in [
            "localhost:8765",
            "LOCALHOST",
            "127.0.0.1:8765",
            "[::1]:8765",
            "127.1.2.3",
        ] {
            assert!(check(true, &[], &to(here)), "{here}");
        }
        for other in [
            "evil.example:8765",
            "localhost.evil.example",
            "192.168.0.5:8765",
            "",
        ] {
            assert!(!check(true, &[], &to(other)), "{other}");
            assert!(check(false, &[], &to(other)), "{other}");
        }
    }
}
