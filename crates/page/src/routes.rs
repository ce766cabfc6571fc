//! Which request is answered by what.

use crate::folder::{LARGEST_SPEC, Place, Unwritten, ending};
use crate::jobs::What;
use crate::live::Live;
use crate::reply::Reply;
use crate::request::Head;
use crate::site::Site;
use crate::{check, columns, edit, results};
use phisindy::files::spec_text;
use phisindy_import::{Answers, Rig};
use serde_json::{Value, json};
use std::io::Read;
use std::sync::{MutexGuard, PoisonError};

/// Largest data file that can be dropped (bytes); a larger one is put into the folder by hand.
const LARGEST_DATA: u64 = 4 << 30;
/// Endings of data files that a spec can be drafted from.
const DATA: &[&str] = &[
    "csv", "txt", "dat", "tsv", "asc", "xlsx", "xlsb", "xls", "ods", "mat", "npy", "npz", "tdms", "uff",
    "unv", "h5", "hdf5", "parquet",
];

/// A request that may ask: what stands behind its path, its head, its body.
struct Asked<'a> {
    site: &'a Site,
    query: &'a str,
    head: &'a Head,
    body: &'a mut dyn Read,
}

type Handler = fn(&mut Asked<'_>) -> Result<Reply, String>;

/// Method, path, the longest body, and what answers; a new request is a new row.
const ROUTES: &[(&str, &str, u64, Handler)] = &[
    ("GET", "", 0, |_| Ok(Reply::page("page.html", include_str!("page.html")))),
    ("GET", "page.css", 0, |_| {
        Ok(Reply::page("page.css", &(phisindy_report::sketch_style() + include_str!("page.css"))))
    }),
    ("GET", "page.js", 0, |_| Ok(Reply::page("page.js", include_str!("page.js")))),
    ("GET", "api/state", 0, state),
    ("GET", "api/now", 0, |asked| {
        let Site { folder, jobs, .. } = asked.site;
        let version = asked.spec().ok().and_then(|name| folder.version(&name));
        Ok(Reply::json(&json!({ "job": jobs.now(), "version": version })))
    }),
    ("POST", "api/data", LARGEST_DATA, |asked| asked.kept(LARGEST_DATA, &asked.word("name")?, Place::Beside)),
    ("POST", "api/look", LARGEST_SPEC, |asked| {
        let name = asked.word("name")?;
        let wishes = serde_json::from_str(&asked.text()?).unwrap_or(Value::Null);
        // Rows per second, where the user says it in place of times.
        let rate =
            asked.word("rate").ok().and_then(|word| word.parse().ok()).filter(|rate: &f64| rate.is_normal());
        let rig = asked.word("rig").ok().and_then(|word| Rig::parse(&word).ok());
        let answers = Answers { rate: rate.filter(|r| *r > 0.0), rig, ..Answers::default() };
        let _turn = asked.turn();
        Ok(Reply::json(&columns::look(&asked.site.folder.file(&name)?, &name, &wishes, &answers)))
    }),
    ("GET", "api/spec", 0, |asked| {
        let name = asked.spec()?;
        let path = asked.site.folder.file(&name)?;
        // A version that is older than the text is found to be so when the text is saved.
        let version = asked.site.folder.version(&name).unwrap_or_default();
        let text = spec_text(&path).map_err(|d| d.message)?;
        Ok(Reply::json(&json!({ "text": text, "version": version })).of_version(&version))
    }),
    ("POST", "api/spec", LARGEST_SPEC, |asked| {
        let known = asked.head.header("if-match").unwrap_or_default();
        // A page that closes cannot be asked.
        let beside = asked.word("beside").is_ok();
        let place = if beside { Place::OverOrBeside(known) } else { Place::Over(known) };
        asked.kept(LARGEST_SPEC, &asked.spec()?, place)
    }),
    ("POST", "api/new-spec", LARGEST_SPEC, |asked| asked.kept(LARGEST_SPEC, &asked.spec()?, Place::Beside)),
    ("POST", "api/check", LARGEST_SPEC, |asked| {
        let path = asked.site.folder.file(&asked.spec()?)?;
        let text = asked.text()?;
        let _turn = asked.turn();
        Ok(Reply::json(&check::check(&path, &text, &asked.site.request)))
    }),
    ("POST", "api/edit", 2 * LARGEST_SPEC, |asked| {
        let wish: Value = serde_json::from_str(&asked.text()?).map_err(|why| why.to_string())?;
        let _turn = asked.turn();
        let text = edit::edit(&wish)?;
        if wish["what"] == "record" {
            // Whether a file has these columns its data tell.
            let told = check::check(&asked.site.folder.file(&asked.spec()?)?, &text, &asked.site.request);
            let mut all = told["diagnostics"].as_array().into_iter().flatten();
            if let Some(d) = all.find(|d| d["error"] == true) {
                return Err(d["message"].as_str().unwrap_or_default().to_owned());
            }
        }
        Ok(Reply::json(&json!({ "text": text })))
    }),
    ("POST", "api/example", 0, |asked| {
        let mut example: &[u8] = include_bytes!("rig.csv");
        match asked.site.folder.write("rig.csv", &mut example, LARGEST_DATA, Place::Beside) {
            Ok((name, _)) => Ok(Reply::json(&json!({ "name": name }))),
            Err(Unwritten::Because(why)) => Err(why),
            Err(Unwritten::Changed) => Err("nothing is written".to_owned()),
        }
    }),
    ("POST", "api/start", 0, |asked| {
        let what = asked.word("what")?;
        let what = What::named(&what).ok_or_else(|| format!("`{what}` cannot be started"))?;
        let Site { jobs, folder, request, .. } = asked.site;
        jobs.start(folder, request, &asked.spec()?, what)?;
        Ok(Reply::json(&json!({ "started": true })))
    }),
    ("POST", "api/stop", 0, |asked| {
        asked.site.jobs.stop();
        Ok(Reply::json(&json!({ "stopped": true })))
    }),
    ("GET", "api/live", 0, |asked| Ok(Reply::json(&asked.site.live.as_ref().map_or(Value::Null, Live::now)))),
    ("POST", "api/live-stop", 0, |asked| {
        asked.site.live.iter().for_each(Live::stop);
        Ok(Reply::json(&json!({ "stopped": true })))
    }),
    ("GET", "api/export", 0, |asked| {
        let _turn = asked.turn();
        let (file, text) = results::exported(&asked.site.folder, &asked.word("result")?, &asked.word("to")?)?;
        Ok(Reply::file(file, text.into_bytes()).kept_as(file))
    }),
];

/// The answer to a request that may ask; `path` stands behind its token.
pub(crate) fn answer(site: &Site, head: &Head, path: &str, from: &mut dyn Read) -> Reply {
    let (path, query) = path.split_once('?').unwrap_or((path, ""));
    if let ("GET", Some(file)) = (head.method.as_str(), path.strip_prefix("results/")) {
        return result_file(site, file, query);
    }
    let Some((method, _, most, handler)) =
        ROUTES.iter().find(|(method, own, ..)| *method == head.method && *own == path)
    else {
        return Reply::wrong(404, "there is nothing here");
    };
    match head.length() {
        None if *method == "POST" => return Reply::wrong(411, "the length of what is sent must be said"),
        Some(length) if length > *most => {
            return Reply::wrong(413, &format!("this is too long: at most {most} bytes are taken"));
        }
        _ => {}
    }
    let mut asked = Asked { site, query, head, body: &mut head.body(from) };
    handler(&mut asked).unwrap_or_else(|why| Reply::wrong(400, &why))
}

impl<'a> Asked<'a> {
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

    /// The body as text.
    fn text(&mut self) -> Result<String, String> {
        let mut text = String::new();
        self.body.read_to_string(&mut text).map_err(|why| why.to_string())?;
        Ok(text)
    }

    /// Keeps the body as a file.
    fn kept(&mut self, most: u64, name: &str, place: Place<'_>) -> Result<Reply, String> {
        match self.site.folder.write(name, self.body, most, place) {
            Ok((name, version)) => {
                Ok(Reply::json(&json!({ "name": name, "version": version })).of_version(&version))
            }
            Err(Unwritten::Because(why)) => Err(why),
            Err(Unwritten::Changed) => {
                Ok(Reply::wrong(412, &format!("`{name}` was changed elsewhere: nothing is written")))
            }
        }
    }

    /// Waits for others whose answer takes much memory too.
    fn turn(&self) -> MutexGuard<'a, ()> {
        self.site.turn.lock().unwrap_or_else(PoisonError::into_inner)
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
