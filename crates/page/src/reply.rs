//! Answers: a status, a kind, a body, and the headers that keep a page to itself.

use serde_json::{Value, json};
use std::io;
use tiny_http::{Header, Request, Response};

/// What the page may do: its own script and style, requests to its own server.
const OWN: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data:; \
                   connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// What a file of a result may do: a report has a script of its own, which must not reach the server.
const SANDBOX: &str = "sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline'; \
                       style-src 'unsafe-inline'; img-src 'self' data:; base-uri 'none'; form-action 'none'";

/// An answer.
pub(crate) struct Reply {
    status: u16,
    kind: &'static str,
    body: Vec<u8>,
    /// The name under which a browser keeps it.
    keep_as: Option<String>,
    policy: &'static str,
}

impl Reply {
    /// The page.
    pub(crate) fn page(text: &str) -> Reply {
        Reply { policy: OWN, ..Reply::new(200, "text/html; charset=utf-8", text) }
    }

    /// Data for the page.
    pub(crate) fn json(value: &Value) -> Reply {
        Reply::new(200, "application/json", value.to_string())
    }

    /// A file, shown by its ending.
    pub(crate) fn file(name: &str, body: Vec<u8>) -> Reply {
        let kind = match super::folder::ending(name).as_str() {
            "html" => "text/html; charset=utf-8",
            "svg" => "image/svg+xml",
            "json" => "application/json",
            _ => "text/plain; charset=utf-8",
        };
        Reply::new(200, kind, body)
    }

    /// To be kept under this name.
    pub(crate) fn kept_as(self, name: &str) -> Reply {
        Reply { keep_as: Some(name.to_owned()), ..self }
    }

    /// A mistake, in words.
    pub(crate) fn wrong(status: u16, why: &str) -> Reply {
        Reply { status, ..Reply::json(&json!({ "error": why })) }
    }

    fn new(status: u16, kind: &'static str, body: impl Into<Vec<u8>>) -> Reply {
        Reply { status, kind, body: body.into(), keep_as: None, policy: SANDBOX }
    }

    /// Sends it.
    ///
    /// # Errors
    /// Nobody listens any more.
    pub(crate) fn send(self, request: Request) -> io::Result<()> {
        let mut response =
            Response::from_data(self.body).with_status_code(self.status).with_chunked_threshold(usize::MAX);
        let kept = self.keep_as.map(|name| {
            let plain: String =
                name.chars().map(|c| if c.is_ascii_graphic() && c != '"' { c } else { '_' }).collect();
            ("Content-Disposition", format!("attachment; filename=\"{plain}\""))
        });
        let headers =
            [("Content-Type", self.kind.to_owned()), ("Content-Security-Policy", self.policy.to_owned())];
        for (name, value) in headers.into_iter().chain(kept).chain(COMMON.map(|(n, v)| (n, v.to_owned()))) {
            if let Ok(header) = Header::from_bytes(name, value) {
                response.add_header(header);
            }
        }
        request.respond(response)
    }
}

/// Headers of every answer.
pub(crate) const COMMON: [(&str, &str); 4] = [
    ("Cache-Control", "no-store"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
];
