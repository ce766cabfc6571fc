//! Who may ask: requests that know the token and come from the page itself.
//!
//! A page of another site can send requests to 127.0.0.1, and can make its own name point there (DNS
//! rebinding). It does not know the token, and its requests carry its own `Host` and `Origin`.

use crate::request::Head;
use std::io;
use std::net::SocketAddr;

/// Bytes of the token.
const TOKEN: usize = 16;

/// The token and the address of the server.
pub(crate) struct Guard {
    token: String,
    /// What `Host` may be.
    hosts: [String; 2],
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// Its `Host` is not the address of this server.
    Host,
    /// It comes from another site.
    Origin,
    /// Its path does not begin with the token.
    Token,
}

impl Refusal {
    /// For people.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Refusal::Host => "refused: the address of this page is the one that `phisindy open` printed",
            Refusal::Origin => "refused: this request comes from another site",
            Refusal::Token => {
                "refused: the token is missing or old; open the address that `phisindy open` printed"
            }
        }
    }
}

impl Guard {
    /// With a token of its own.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub(crate) fn new(address: SocketAddr) -> io::Result<Guard> {
        let mut bytes = [0; TOKEN];
        getrandom::fill(&mut bytes).map_err(|why| io::Error::other(format!("no random numbers: {why}")))?;
        let token = bytes.iter().map(|b| format!("{b:02x}")).collect();
        let port = address.port();
        Ok(Guard { token, hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")] })
    }

    /// The address of the page.
    pub(crate) fn url(&self) -> String {
        format!("http://{}/{}/", self.hosts[0], self.token)
    }

    /// The path of a request behind the token, with its query.
    ///
    /// # Errors
    /// It may not ask.
    pub(crate) fn path<'r>(&self, head: &'r Head) -> Result<&'r str, Refusal> {
        if !head.header("host").is_some_and(|host| self.hosts.iter().any(|own| own == host)) {
            return Err(Refusal::Host);
        }
        let (token, path) =
            head.target.strip_prefix('/').and_then(|rest| rest.split_once('/')).ok_or(Refusal::Token)?;
        let own =
            |origin: &str| origin.strip_prefix("http://").is_some_and(|o| self.hosts.iter().any(|h| h == o));
        // The file that leads a browser here is a place of its own. It may show the page, and nothing else.
        let shown =
            path.is_empty() && head.method == "GET" && head.header("sec-fetch-mode") == Some("navigate");
        let elsewhere = head.header("sec-fetch-site") == Some("cross-site") && !shown;
        if head.header("origin").is_some_and(|origin| !own(origin)) || elsewhere {
            return Err(Refusal::Origin);
        }
        if same(token.as_bytes(), self.token.as_bytes()) { Ok(path) } else { Err(Refusal::Token) }
    }
}

/// Whether two texts are equal, in a time that does not tell where they differ.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |all, (x, y)| all | (x ^ y)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_page_itself_may_ask() {
        let guard = Guard::new(SocketAddr::from(([127, 0, 0, 1], 4000))).unwrap();
        let asked = |path: &str, host: &str, more: &str| {
            let text = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n");
            let head = Head::read(&mut text.as_bytes()).unwrap();
            guard.path(&head).map(str::to_owned)
        };
        let (url, own) = (format!("/{}/api/state", guard.token), "127.0.0.1:4000");
        assert_eq!(asked(&url, own, ""), Ok("api/state".to_owned()));
        let localhost = asked(&url, "localhost:4000", "Origin: http://localhost:4000\r\n");
        assert_eq!(localhost, Ok("api/state".to_owned()));
        for host in ["", "evil.example", "127.0.0.1", "127.0.0.1:4001", "evil.example:4000"] {
            assert_eq!(asked(&url, host, ""), Err(Refusal::Host));
        }
        for origin in
            ["null", "http://evil.example", "https://127.0.0.1:4000", "http://127.0.0.1:4000.evil.example"]
        {
            assert_eq!(asked(&url, own, &format!("Origin: {origin}\r\n")), Err(Refusal::Origin));
        }
        let wrong = format!("/{}/", "0".repeat(2 * TOKEN));
        for url in ["/", "/api/state", wrong.as_str(), "//api/state", &url[..20]] {
            assert_eq!(asked(url, own, ""), Err(Refusal::Token));
        }
        // A link from elsewhere that knows the token shows the page, and does nothing.
        let shown = "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: navigate\r\n";
        assert_eq!(asked(&format!("/{}/", guard.token), own, shown), Ok(String::new()));
        for more in [shown, "Sec-Fetch-Site: cross-site\r\n"] {
            assert_eq!(asked(&url, own, more), Err(Refusal::Origin));
        }
    }

    #[test]
    fn tokens_differ() {
        let address = SocketAddr::from(([127, 0, 0, 1], 4000));
        let (a, b) = (Guard::new(address).unwrap(), Guard::new(address).unwrap());
        assert!(a.token != b.token && a.token.len() == 32);
    }
}
