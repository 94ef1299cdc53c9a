//! Who may ask: nobody but the page that this process itself opened.
//!
//! Three locks. The address begins with a random token, so that neither other
//! users of the machine nor pages in other tabs can guess it. `Host` must be
//! loopback by name or number, so that no foreign name resolved to loopback (DNS
//! rebinding) reaches the server. `Origin` must be the server's own wherever a
//! browser states it, and must be stated to change anything.

use std::fmt::Write;

use super::http::Request;

/// Random bytes of a token: beyond any guessing.
const TOKEN_BYTES: usize = 16;

/// The locks of one server.
#[derive(Debug)]
pub(super) struct Guard {
    token: String,
    port: u16,
}

/// What is refused, as an HTTP status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// 403: a foreign name or page.
    Foreign,
    /// 404: not below the token, which says no more than that.
    Unknown,
}

impl Guard {
    pub(super) fn new(port: u16) -> Result<Guard, getrandom::Error> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        let token = bytes.iter().fold(String::new(), |mut text, byte| {
            // Writing to a String cannot fail.
            let _ = write!(text, "{byte:02x}");
            text
        });
        Ok(Guard { token, port })
    }

    /// The address of the page.
    pub(super) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Path and query below the token, if the request may be answered.
    pub(super) fn admit(&self, request: &Request) -> Result<String, Refusal> {
        let (host, origin) = (request.host.as_deref(), request.origin.as_deref());
        let changes = request.method != "GET";
        self.check(host, origin, changes, &request.target)
    }

    fn check(
        &self,
        host: Option<&str>,
        origin: Option<&str>,
        changes: bool,
        url: &str,
    ) -> Result<String, Refusal> {
        let hosts = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", self.port));
        let host = host.filter(|host| hosts.iter().any(|known| known == host));
        let host = host.ok_or(Refusal::Foreign)?;
        match origin {
            Some(origin) if origin.strip_prefix("http://") == Some(host) => {}
            None if !changes => {}
            _ => return Err(Refusal::Foreign),
        }
        let below = url.strip_prefix('/').ok_or(Refusal::Unknown)?;
        let (token, rest) = below.split_once('/').ok_or(Refusal::Unknown)?;
        if same(token.as_bytes(), self.token.as_bytes()) {
            Ok(rest.to_owned())
        } else {
            Err(Refusal::Unknown)
        }
    }
}

/// Equality that takes as long for a near miss as for a far one.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |all, (x, y)| all | (x ^ y)) == 0
}

#[cfg(test)]
mod tests {
    use super::{Guard, Refusal};

    #[test]
    fn only_the_own_page_gets_in() {
        let guard = Guard::new(8000).unwrap();
        let url = format!("/{}/part", guard.token);
        let host = Some("127.0.0.1:8000");
        let own = Some("http://127.0.0.1:8000");
        let check = |host, origin, changes| guard.check(host, origin, changes, &url);
        assert_eq!(check(host, None, false), Ok("part".to_owned()));
        assert_eq!(check(host, own, true), Ok("part".to_owned()));
        assert_eq!(
            check(Some("localhost:8000"), Some("http://localhost:8000"), true),
            Ok("part".to_owned())
        );
        for (host, origin, changes) in [
            (None, None, false),
            (Some("127.0.0.1"), None, false),
            (Some("midsurf.example:8000"), None, false),
            (Some("127.0.0.1:8001"), None, false),
            (host, None, true),
            (host, Some("null"), false),
            (host, Some("http://midsurf.example"), true),
            (host, Some("https://127.0.0.1:8000"), true),
            (host, Some("http://127.0.0.1:8001"), true),
            (host, Some("http://localhost:8000"), true),
        ] {
            let answer = check(host, origin, changes);
            assert_eq!(answer, Err(Refusal::Foreign), "{host:?} {origin:?}");
        }
    }

    #[test]
    fn every_server_has_its_own_token() {
        let (guard, other) = (Guard::new(8000).unwrap(), Guard::new(8000).unwrap());
        let host = Some("127.0.0.1:8000");
        for url in [
            "/".to_owned(),
            "/part".to_owned(),
            "//part".to_owned(),
            format!("/{}", guard.token),
            format!("/{}/part", other.token),
            format!("/{}x/part", guard.token),
            format!("{}/part", guard.token),
        ] {
            assert_eq!(
                guard.check(host, None, false, &url),
                Err(Refusal::Unknown),
                "{url}"
            );
        }
    }
}
