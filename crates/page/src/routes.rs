//! Which request is answered by what.

use crate::folder::{LARGEST_SPEC, ending};
use crate::jobs::What;
use crate::reply::{COMMON, Reply};
use crate::site::Site;
use crate::{check, columns, results};
use phisindy::files::spec_text;
use serde_json::{Value, json};
use std::io::{self, Read, Write};
use std::time::Duration;
use tiny_http::{Method, Request};

/// The page: one file, without anything from elsewhere.
const PAGE: &str = include_str!("page.html");
/// Largest data file that can be dropped (bytes); a larger one is put into the folder by hand.
const LARGEST_DATA: u64 = 4 << 30;
/// Endings of data files that a spec can be drafted from.
const DATA: &[&str] = &[
    "csv", "txt", "dat", "tsv", "asc", "xlsx", "xlsb", "xls", "ods", "mat", "npy", "npz", "tdms", "uff",
    "unv", "h5", "hdf5", "parquet",
];
/// Interval between events while nothing happens, so that a closed page is noticed.
const PULSE: Duration = Duration::from_secs(5);

/// A request that may ask: what stands behind its path, its query, its body.
struct Asked<'a> {
    site: &'a Site,
    query: &'a str,
    body: &'a mut dyn Read,
}

type Handler = fn(&mut Asked<'_>) -> Result<Reply, String>;

/// Method, path, and what answers; a new request is a new row.
const ROUTES: &[(Method, &str, Handler)] = &[
    (Method::Get, "", |_| Ok(Reply::page(PAGE))),
    (Method::Get, "api/state", state),
    (Method::Post, "api/data", |asked| {
        let name = asked.site.folder.add(&asked.word("name")?, asked.body, LARGEST_DATA)?;
        Ok(Reply::json(&json!({ "name": name })))
    }),
    (Method::Post, "api/look", |asked| {
        let name = asked.word("name")?;
        let wishes = serde_json::from_str(&asked.text()?).unwrap_or(Value::Null);
        // Rows per second, where the user says it in place of times.
        let rate =
            asked.word("rate").ok().and_then(|word| word.parse().ok()).filter(|rate: &f64| rate.is_normal());
        Ok(Reply::json(&columns::look(
            &asked.site.folder.file(&name)?,
            &name,
            &wishes,
            rate.filter(|r| *r > 0.0),
        )))
    }),
    (Method::Get, "api/spec", |asked| {
        let text = spec_text(&asked.site.folder.file(&asked.spec()?)?).map_err(|d| d.message)?;
        Ok(Reply::json(&json!({ "text": text })))
    }),
    (Method::Post, "api/spec", |asked| {
        let name = asked.spec()?;
        asked.site.folder.write(&name, asked.body, LARGEST_SPEC)?;
        Ok(Reply::json(&json!({ "name": name })))
    }),
    (Method::Post, "api/new-spec", |asked| {
        let name = asked.spec()?;
        Ok(Reply::json(&json!({ "name": asked.site.folder.add(&name, asked.body, LARGEST_SPEC)? })))
    }),
    (Method::Post, "api/check", |asked| {
        let path = asked.site.folder.file(&asked.spec()?)?;
        Ok(Reply::json(&check::check(&path, &asked.text()?, &asked.site.request)))
    }),
    (Method::Post, "api/start", |asked| {
        let what = asked.word("what")?;
        let what = What::named(&what).ok_or_else(|| format!("`{what}` cannot be started"))?;
        let Site { jobs, folder, request, .. } = asked.site;
        jobs.start(folder, request, &asked.spec()?, what)?;
        Ok(Reply::json(&json!({ "started": true })))
    }),
    (Method::Post, "api/stop", |asked| {
        asked.site.jobs.stop();
        Ok(Reply::json(&json!({ "stopped": true })))
    }),
    (Method::Get, "api/export", |asked| {
        let (file, text) = results::exported(&asked.site.folder, &asked.word("result")?, &asked.word("to")?)?;
        Ok(Reply::file(file, text.into_bytes()).kept_as(file))
    }),
];

/// Answers a request.
pub(crate) fn answer(site: &Site, mut request: Request) {
    let path = match site.guard.path(&request) {
        Ok(path) => path.to_owned(),
        Err(refusal) => {
            let _ = Reply::wrong(403, refusal.words()).send(request);
            return;
        }
    };
    let (path, query) = path.split_once('?').unwrap_or((&path, ""));
    if *request.method() == Method::Get && path == "api/events" {
        // It ends when the page is closed.
        let _ = events(site, request);
        return;
    }
    let reply = if let (Method::Get, Some(file)) = (request.method(), path.strip_prefix("results/")) {
        result_file(site, file, query)
    } else {
        let method = request.method().clone();
        let found = ROUTES.iter().find(|(m, p, _)| *m == method && *p == path);
        let mut asked = Asked { site, query, body: request.as_reader() };
        match found {
            Some((_, _, handler)) => handler(&mut asked).unwrap_or_else(|why| Reply::wrong(400, &why)),
            None => Reply::wrong(404, "there is nothing here"),
        }
    };
    // Nobody is left to tell if the browser has gone.
    let _ = reply.send(request);
}

impl Asked<'_> {
    /// A value of the query.
    fn word(&self, key: &str) -> Result<String, String> {
        value(self.query, key).ok_or_else(|| format!("`{key}` is missing"))
    }

    /// The name of a spec.
    fn spec(&self) -> Result<String, String> {
        let name = self.word("name")?;
        if ending(&name) == "ron" {
            Ok(name)
        } else {
            Err(format!("the name of a spec ends with .ron: `{name}`"))
        }
    }

    /// The body as text, no longer than a spec may be.
    fn text(&mut self) -> Result<String, String> {
        let (mut text, body) = (String::new(), &mut *self.body);
        let read = body.take(LARGEST_SPEC + 1).read_to_string(&mut text).map_err(|why| why.to_string())?;
        if read as u64 > LARGEST_SPEC { Err("this text is too long".to_owned()) } else { Ok(text) }
    }
}

fn state(asked: &mut Asked<'_>) -> Result<Reply, String> {
    let Site { folder, first, .. } = asked.site;
    Ok(Reply::json(&json!({
        "folder": folder.path().display().to_string(), "first": first, "data": folder.names(DATA),
        "specs": folder.names(&["ron"]), "results": results::list(folder), "languages": results::languages(),
        "version": env!("CARGO_PKG_VERSION"),
    })))
}

fn result_file(site: &Site, file: &str, query: &str) -> Reply {
    let decoded = decoded(file).unwrap_or_default();
    let read = results::file(&site.folder, &decoded)
        .and_then(|path| std::fs::read(path).map_err(|why| why.to_string()));
    match read {
        Ok(bytes) if value(query, "keep").is_some() => {
            Reply::file(&decoded, bytes).kept_as(&decoded.replace('/', "-"))
        }
        Ok(bytes) => Reply::file(&decoded, bytes),
        Err(why) => Reply::wrong(404, &why),
    }
}

/// Sends the state of the work whenever it changes, as server-sent events, until nobody listens.
fn events(site: &Site, request: Request) -> io::Result<()> {
    let mut out = request.into_writer();
    write!(out, "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\n")?;
    for (name, value) in COMMON {
        write!(out, "{name}: {value}\r\n")?;
    }
    write!(out, "\r\n")?;
    let mut version = None;
    loop {
        let (now, state) = site.jobs.after(version, PULSE);
        version = Some(now);
        write!(out, "data: {state}\n\n")?;
        out.flush()?;
    }
}

/// The value of a key of a query.
fn value(query: &str, key: &str) -> Option<String> {
    query
        .split('&')
        .filter_map(|pair| pair.split_once('='))
        .find(|(k, _)| *k == key)
        .and_then(|(_, v)| decoded(v))
}

/// A part of an address with `%41` as `A`.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first == b'%' {
            let (digits, after) = tail.split_at_checked(2)?;
            if !digits.iter().all(u8::is_ascii_hexdigit) {
                return None;
            }
            bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = after;
        } else {
            bytes.push(*first);
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_decoded() {
        assert_eq!(decoded("a%20b%C3%A4.csv").as_deref(), Some("a bä.csv"));
        for wrong in ["%", "%4", "%zz", "%ff", "%+1"] {
            assert_eq!(decoded(wrong), None, "{wrong}");
        }
        assert_eq!(value("a=1&name=x%2Fy", "name").as_deref(), Some("x/y"));
        assert_eq!(value("name", "name"), None);
    }
}
