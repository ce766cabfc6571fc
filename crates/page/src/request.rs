//! One request of HTTP/1.1: a head within limits, and a body that is there as a whole or not at all.
//!
//! A connection carries one request. Nothing is reserved for what a head claims: a body is read through
//! [`Body`], in pieces, and a body that breaks off is an error, not an end.

use std::io::{self, ErrorKind, Read};

/// Largest head (bytes), and most headers of it.
const HEAD: usize = 16 << 10;
const HEADERS: usize = 64;

/// What stands before the body.
#[derive(Clone, Debug)]
pub(crate) struct Head {
    /// `GET`, `POST`, or anything else.
    pub(crate) method: String,
    /// Path and query.
    pub(crate) target: String,
    headers: Vec<(String, String)>,
    /// What was read behind it, and belongs to the body.
    ahead: Vec<u8>,
}

/// Why there is no request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoRequest {
    /// The connection has ended, or nothing comes.
    Gone,
    /// It is larger than a browser makes it.
    TooLarge,
    /// It is no HTTP.
    Malformed,
}

impl Head {
    /// Reads a head.
    ///
    /// # Errors
    /// There is none, or none within the limits.
    pub(crate) fn read(from: &mut dyn Read) -> Result<Head, NoRequest> {
        let (mut bytes, mut piece) = (Vec::new(), [0; 4096]);
        loop {
            let n = from.read(&mut piece).map_err(|_| NoRequest::Gone)?;
            if n == 0 {
                return Err(NoRequest::Gone);
            }
            bytes.extend_from_slice(&piece[..n]);
            // A head that comes byte by byte is parsed once for each of its lines.
            if piece[..n].contains(&b'\n')
                && let Some(head) = Head::parsed(&bytes)?
            {
                return Ok(head);
            }
            if bytes.len() > HEAD {
                return Err(NoRequest::TooLarge);
            }
        }
    }

    /// The head at the start of these bytes; none if its end is still to come.
    fn parsed(bytes: &[u8]) -> Result<Option<Head>, NoRequest> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        let length = match request.parse(bytes) {
            Ok(httparse::Status::Complete(length)) if length > HEAD => return Err(NoRequest::TooLarge),
            Ok(httparse::Status::Complete(length)) => length,
            Ok(httparse::Status::Partial) => return Ok(None),
            Err(httparse::Error::TooManyHeaders) => return Err(NoRequest::TooLarge),
            Err(_) => return Err(NoRequest::Malformed),
        };
        let mut all: Vec<(String, String)> = Vec::new();
        for header in request.headers.iter() {
            let value = std::str::from_utf8(header.value).map_err(|_| NoRequest::Malformed)?;
            let name = header.name.to_ascii_lowercase();
            // No browser says a header twice, and two readers could take different ones.
            if all.iter().any(|(known, _)| *known == name) {
                return Err(NoRequest::Malformed);
            }
            all.push((name, value.to_owned()));
        }
        Ok(Some(Head {
            method: request.method.unwrap_or_default().to_owned(),
            target: request.path.unwrap_or_default().to_owned(),
            headers: all,
            ahead: bytes[length..].to_vec(),
        }))
    }

    /// The value of a header, whose name is written in lower case.
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// The length of the body that is claimed; none if it is not said. Chunks are not taken: browsers say the
    /// length of what they send.
    pub(crate) fn length(&self) -> Option<u64> {
        let digits = self.header("content-length").filter(|_| self.header("transfer-encoding").is_none())?;
        digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())?
    }

    /// The body.
    pub(crate) fn body<'a>(&'a self, from: &'a mut dyn Read) -> Body<'a> {
        Body { ahead: &self.ahead, from, left: self.length().unwrap_or(0) }
    }
}

/// A body: it ends where its length says, and nowhere before.
pub(crate) struct Body<'a> {
    ahead: &'a [u8],
    from: &'a mut dyn Read,
    left: u64,
}

impl Read for Body<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let most = to.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        let to = &mut to[..most];
        if to.is_empty() {
            return Ok(0);
        }
        let n = if self.ahead.is_empty() { self.from.read(to)? } else { self.ahead.read(to)? };
        if n == 0 {
            return Err(io::Error::new(ErrorKind::UnexpectedEof, "it broke off before its end"));
        }
        self.left -= n as u64;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Head, NoRequest> {
        Head::read(&mut text.as_bytes())
    }

    #[test]
    fn heads_have_limits() {
        let head = read("POST /t/a?b=c HTTP/1.1\r\nHost: h\r\nContent-Length: 2\r\n\r\nab").unwrap();
        assert_eq!((head.method.as_str(), head.target.as_str()), ("POST", "/t/a?b=c"));
        assert_eq!((head.header("host"), head.length()), (Some("h"), Some(2)));
        let long = |n: usize| format!("GET /{} HTTP/1.1\r\nHost: h\r\n\r\n", "a".repeat(n));
        assert!(read(&long(HEAD - 100)).is_ok());
        assert_eq!(read(&long(HEAD)).unwrap_err(), NoRequest::TooLarge);
        assert_eq!(Head::read(&mut io::repeat(b'a')).unwrap_err(), NoRequest::TooLarge);
        let many: String = (0..HEADERS + 1).map(|k| format!("h{k}: 1\r\n")).collect();
        assert_eq!(read(&format!("GET / HTTP/1.1\r\n{many}\r\n")).unwrap_err(), NoRequest::TooLarge);
        for wrong in [
            "nonsense\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
            "GET / HTTP/1.1\r\nContent-Length: 1\r\ncontent-length: 2\r\n\r\n",
        ] {
            assert_eq!(read(wrong).unwrap_err(), NoRequest::Malformed, "{wrong}");
        }
        assert_eq!(read("GET / HTTP/1.1\r\nHost: h\r\n").unwrap_err(), NoRequest::Gone);
    }

    #[test]
    fn a_length_is_a_number() {
        for (said, length) in [("7", Some(7)), ("+7", None), ("-7", None), ("7,7", None), ("", None)] {
            let head = read(&format!("POST / HTTP/1.1\r\nContent-Length: {said}\r\n\r\n")).unwrap();
            assert_eq!(head.length(), length, "{said}");
        }
        let chunks =
            read("POST / HTTP/1.1\r\nContent-Length: 7\r\nTransfer-Encoding: chunked\r\n\r\n").unwrap();
        assert_eq!(chunks.length(), None);
    }

    #[test]
    fn a_body_is_whole_or_an_error() {
        let text = "POST / HTTP/1.1\r\nContent-Length: 6\r\n\r\nabc";
        let body = |behind: &str| {
            let (head, mut got) = (read(text).unwrap(), String::new());
            head.body(&mut behind.as_bytes()).read_to_string(&mut got).map(|_| got)
        };
        assert_eq!(body("defghi").unwrap(), "abcdef");
        assert_eq!(body("de").unwrap_err().kind(), ErrorKind::UnexpectedEof);
    }
}
