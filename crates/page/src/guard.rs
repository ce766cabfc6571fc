//! Who may ask: requests that know the token and come from the page itself.
//!
//! A page of another site can send requests to 127.0.0.1, and can make its own name point there (DNS
//! rebinding). It does not know the token, and its requests carry its own `Host` and `Origin`.

use std::io;
use std::net::SocketAddr;
use tiny_http::Request;

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
    pub(crate) fn path<'r>(&self, request: &'r Request) -> Result<&'r str, Refusal> {
        let header = |name: &'static str| {
            request.headers().iter().find(|h| h.field.equiv(name)).map(|h| h.value.as_str())
        };
        self.admitted(request.url(), header("Host"), header("Origin"), header("Sec-Fetch-Site"))
    }

    fn admitted<'r>(
        &self,
        url: &'r str,
        host: Option<&str>,
        origin: Option<&str>,
        site: Option<&str>,
    ) -> Result<&'r str, Refusal> {
        if !host.is_some_and(|host| self.hosts.iter().any(|own| own == host)) {
            return Err(Refusal::Host);
        }
        let own =
            |origin: &str| origin.strip_prefix("http://").is_some_and(|o| self.hosts.iter().any(|h| h == o));
        if origin.is_some_and(|origin| !own(origin)) || site == Some("cross-site") {
            return Err(Refusal::Origin);
        }
        let (token, path) =
            url.strip_prefix('/').and_then(|rest| rest.split_once('/')).ok_or(Refusal::Token)?;
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
        let url = format!("/{}/api/state", guard.token);
        let asked =
            |url: &str, host, origin, site| guard.admitted(url, host, origin, site).map(str::to_owned);
        let own = Some("127.0.0.1:4000");
        assert_eq!(asked(&url, own, None, None), Ok("api/state".to_owned()));
        assert_eq!(
            asked(&url, Some("localhost:4000"), Some("http://localhost:4000"), None),
            Ok("api/state".to_owned())
        );
        for host in
            [None, Some("evil.example"), Some("127.0.0.1"), Some("127.0.0.1:4001"), Some("evil.example:4000")]
        {
            assert_eq!(asked(&url, host, None, None), Err(Refusal::Host));
        }
        for origin in
            ["null", "http://evil.example", "https://127.0.0.1:4000", "http://127.0.0.1:4000.evil.example"]
        {
            assert_eq!(asked(&url, own, Some(origin), None), Err(Refusal::Origin));
        }
        assert_eq!(asked(&url, own, None, Some("cross-site")), Err(Refusal::Origin));
        let wrong = format!("/{}/", "0".repeat(2 * TOKEN));
        for url in ["/", "", "/api/state", wrong.as_str(), "//api/state", &url[..20]] {
            assert_eq!(asked(url, own, None, None), Err(Refusal::Token));
        }
    }

    #[test]
    fn tokens_differ() {
        let address = SocketAddr::from(([127, 0, 0, 1], 4000));
        let (a, b) = (Guard::new(address).unwrap(), Guard::new(address).unwrap());
        assert!(a.token != b.token && a.token.len() == 32);
    }
}
