//! A request of the local page.

use phisindy::files::Request;
use phisindy_page::Page;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::sync::LazyLock;

/// What a file beside the folder of the page holds, which nobody may see or change.
const SECRET: &str = "only8the9owner";
/// The headers that an answer has.
const HEADERS: &[&str] = &[
    "Content-Type",
    "Content-Length",
    "Content-Security-Policy",
    "Content-Disposition",
    "ETag",
    "Cache-Control",
    "Referrer-Policy",
    "X-Content-Type-Options",
    "Cross-Origin-Resource-Policy",
    "Connection",
];
/// A mass on a spring, with a file beside it and one that is a link.
const SPEC: &str = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" },
    data: [Csv(path: "b.csv", time: "t", columns: { "x": "x" })])"#;

/// A page, what it knows and others do not, and its files as they were.
struct Place {
    page: Page,
    host: String,
    token: String,
    /// Holds the folder of the page and the secret.
    around: PathBuf,
    files: BTreeMap<&'static str, &'static str>,
}

static PLACE: LazyLock<Place> = LazyLock::new(|| {
    let around = std::env::temp_dir().join(format!("phisindy-fuzz-{}", std::process::id()));
    let work = around.join("work");
    fs::create_dir_all(work.join("results/a-gap-1")).expect("a folder");
    fs::write(around.join("secret.csv"), SECRET).expect("written");
    #[cfg(unix)]
    std::os::unix::fs::symlink(around.join("secret.csv"), work.join("link.csv")).expect("a link");
    let result = r#"{"verdict":"explained","title":"a","steps":[{"name":"Coulomb friction"}]}"#;
    let files = BTreeMap::from([
        ("a.ron", SPEC),
        ("b.csv", "t,x\n0,1\n0.1,0.995\n0.2,0.98\n0.3,0.955\n0.4,0.92\n"),
        ("results/a-gap-1/result.json", result),
        ("results/a-gap-1/report.html", "<p>"),
        ("results/a-gap-1/completed.ron", SPEC),
    ]);
    let page = Page::open(&work, None, 0, Request::default()).expect("a page");
    let url = page.url();
    let (host, token) =
        url.trim_start_matches("http://").trim_end_matches('/').split_once('/').expect("both");
    let (host, token) = (host.to_owned(), token.to_owned());
    let place = Place { page, host, token, around, files };
    place.restore();
    place
});

impl Place {
    /// Makes the folder what it was, and fails if more than plain files came to it.
    fn restore(&self) {
        let work = self.around.join("work");
        for entry in fs::read_dir(&work).expect("the folder").flatten() {
            let name = entry.file_name().into_string().expect("a name that is text");
            assert!(!name.starts_with('.'), "{name} is left");
            if name != "results" && name != "link.csv" && !self.files.contains_key(name.as_str()) {
                fs::remove_file(entry.path()).expect("a plain file");
            }
        }
        for (name, text) in &self.files {
            let path = work.join(name);
            if fs::read(&path).ok().as_deref() != Some(text.as_bytes()) {
                fs::write(path, text).expect("written");
            }
        }
    }

    /// Nothing outside of the folder has come, gone, or changed.
    fn untouched(&self) {
        assert_eq!(fs::read_dir(&self.around).expect("the folder").count(), 2);
        assert_eq!(fs::read_to_string(self.around.join("secret.csv")).ok().as_deref(), Some(SECRET));
        #[cfg(unix)]
        assert!(self.around.join("work/link.csv").is_symlink());
    }
}

/// A request of HTTP, in which `HOST` and `TOKEN` stand for what the page alone knows. The page answers nothing, or an
/// answer of HTTP as long as its head says, with no headers but its own. It reads and writes nothing outside of its
/// folder, and leaves no file half written.
pub fn routes(input: &[u8]) {
    // Work on a thread of its own would be measured with the next input: the searches are fuzzed by `gap`.
    if [&b"api/start"[..], SECRET.as_bytes()].iter().any(|what| input.windows(what.len()).any(|w| w == *what))
    {
        return;
    }
    let place = &*PLACE;
    let answer = place.page.answered(&replaced(
        &replaced(input, b"HOST", place.host.as_bytes()),
        b"TOKEN",
        place.token.as_bytes(),
    ));
    place.untouched();
    place.restore();
    if answer.is_empty() {
        return;
    }
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("the end of a head");
    let (head, body) = (std::str::from_utf8(&answer[..end]).expect("text"), &answer[end + 4..]);
    let (status, headers) = head.split_once("\r\n").expect("a status line and headers");
    let code =
        status.strip_prefix("HTTP/1.1 ").and_then(|rest| rest.strip_suffix(' ')).expect("a status line");
    assert!(["200", "400", "403", "404", "411", "412", "413"].contains(&code), "{status}");
    let headers: Vec<(&str, &str)> =
        headers.split("\r\n").map(|line| line.split_once(": ").expect("a header")).collect();
    assert!(
        headers.iter().all(|(name, value)| HEADERS.contains(name) && !value.contains(['\r', '\n'])),
        "{head}"
    );
    let length = headers.iter().find(|(name, _)| *name == "Content-Length").expect("a length").1;
    assert_eq!(length.parse(), Ok(body.len()));
    assert!(!body.windows(SECRET.len()).any(|w| w == SECRET.as_bytes()), "{}", String::from_utf8_lossy(body));
}

/// The bytes with a word in place of another.
fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let mut all = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let [first, tail @ ..] = rest {
        if let Some(after) = rest.strip_prefix(from) {
            all.extend_from_slice(to);
            rest = after;
        } else {
            all.push(*first);
            rest = tail;
        }
    }
    all
}
