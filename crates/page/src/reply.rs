//! Answers: a status, a kind, a body, and the headers that keep a page to itself.

use serde_json::{Value, json};
use std::io::{self, Write};

/// What the page may do: its own script and style, requests to its own server.
const OWN: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; connect-src 'self'; \
                   frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
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
    /// Of a spec.
    version: Option<String>,
    policy: &'static str,
}

impl Reply {
    /// A part of the page, shown by the ending of its name.
    pub(crate) fn page(name: &str, text: &str) -> Reply {
        Reply { policy: OWN, ..Reply::file(name, text.into()) }
    }

    /// Data for the page.
    pub(crate) fn json(value: &Value) -> Reply {
        Reply::new(200, "application/json", value.to_string())
    }

    /// A file, shown by its ending.
    pub(crate) fn file(name: &str, body: Vec<u8>) -> Reply {
        let kind = match super::folder::ending(name).as_str() {
            "html" => "text/html; charset=utf-8",
            "js" => "text/javascript; charset=utf-8",
            "css" => "text/css; charset=utf-8",
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

    /// Of this version.
    pub(crate) fn of_version(self, version: &str) -> Reply {
        Reply { version: Some(version.to_owned()), ..self }
    }

    /// A mistake, in words.
    pub(crate) fn wrong(status: u16, why: &str) -> Reply {
        Reply { status, ..Reply::json(&json!({ "error": why })) }
    }

    fn new(status: u16, kind: &'static str, body: impl Into<Vec<u8>>) -> Reply {
        Reply { status, kind, body: body.into(), keep_as: None, version: None, policy: SANDBOX }
    }

    /// Sends it, and says that nothing follows.
    ///
    /// # Errors
    /// Nobody listens any more.
    pub(crate) fn send(&self, to: &mut dyn Write) -> io::Result<()> {
        let Reply { status, kind, body, policy, .. } = self;
        let mut head = format!(
            "HTTP/1.1 {status} \r\nContent-Type: {kind}\r\nContent-Length: {}\r\nContent-Security-Policy: {policy}\r\n",
            body.len()
        );
        if let Some(name) = &self.keep_as {
            let plain: String =
                name.chars().map(|c| if c.is_ascii_graphic() && c != '"' { c } else { '_' }).collect();
            head += &format!("Content-Disposition: attachment; filename=\"{plain}\"\r\n");
        }
        if let Some(version) = &self.version {
            head += &format!("ETag: {version}\r\n");
        }
        to.write_all((head + COMMON).as_bytes())?;
        to.write_all(body)?;
        to.flush()
    }
}

/// Headers of every answer, and the end of them.
const COMMON: &str = "Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
                      Cross-Origin-Resource-Policy: same-origin\r\nConnection: close\r\n\r\n";
