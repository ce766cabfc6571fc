//! The documents hang together: every link and anchor leads somewhere, and every page of the book is in its
//! table of contents.

#![allow(missing_docs)]

#[allow(dead_code)] // each test uses its part
use crate::common::top;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// Files of a folder with this ending, as paths from the top of the project.
fn files(folder: &str, ending: &str) -> BTreeSet<PathBuf> {
    let mut all = BTreeSet::new();
    for entry in std::fs::read_dir(top().join(folder)).expect("a folder") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name");
        let path = format!("{folder}/{name}");
        if top().join(&path).is_dir() {
            all.extend(files(&path, ending));
        } else if name.ends_with(ending) {
            all.insert(path.into());
        }
    }
    all
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(top().join(path)).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Lines outside of code, with their code spans taken out if `spans` says so.
fn prose(text: &str, spans: bool) -> Vec<String> {
    let mut code = false;
    let mut all = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            code = !code;
        } else if !code && (!line.starts_with("    ") || line.trim_start().starts_with("- ")) {
            let parts = line.split('`').enumerate();
            all.push(parts.filter(|(k, _)| !spans || k % 2 == 0).map(|(_, part)| part).collect());
        }
    }
    all
}

/// What stands in the round brackets of `[...](...)`.
fn links(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    for line in prose(text, true) {
        for part in line.split("](").skip(1) {
            all.push(part.split(')').next().unwrap_or(part).to_owned());
        }
    }
    all
}

/// The anchors of a page, as mdbook and GitHub make them of its headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for line in prose(text, false).iter().filter(|l| l.starts_with('#')) {
        let heading = line.trim_start_matches('#').trim().to_lowercase();
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let slug: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let twin = (1..).map(|k| format!("{slug}-{k}")).find(|s| !all.contains(s)).expect("a number");
        if !all.insert(slug) {
            all.insert(twin);
        }
    }
    all
}

/// The path of a link from the top of the project; none if it leaves the project.
fn target(page: &Path, link: &str) -> Option<PathBuf> {
    let mut path = page.parent()?.to_owned();
    for part in Path::new(link).components() {
        match part {
            Component::ParentDir => path = path.parent()?.to_owned(),
            Component::CurDir => {}
            part => path.push(part),
        }
    }
    Some(path)
}

/// What is wrong with the link of a page; a page of the book may not lead out of `docs`.
fn broken(page: &Path, link: &str) -> Option<String> {
    if link.starts_with("http") || link.starts_with("mailto:") {
        return None;
    }
    let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
    let path = if file.is_empty() { page.to_owned() } else { target(page, file)? };
    if !top().join(&path).exists() {
        return Some(format!("{}: `{link}`: there is no such file", page.display()));
    }
    if page.starts_with("docs") && !path.starts_with("docs") {
        return Some(format!("{}: `{link}` leads out of the book", page.display()));
    }
    let known = anchor.is_none_or(|anchor| anchors(&read(&path)).contains(anchor));
    (!known).then(|| format!("{}: `{link}`: there is no such heading", page.display()))
}

#[test]
fn every_link_of_the_documents_leads_somewhere() {
    let mut pages = files("docs", ".md");
    pages.extend(
        ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "CHANGELOG.md", "SECURITY.md"].map(PathBuf::from),
    );
    pages.insert("crates/python/README.md".into());
    let (mut seen, mut wrong) = (0, Vec::new());
    for page in &pages {
        for link in links(&read(page)) {
            seen += 1;
            wrong.extend(broken(page, &link));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 80, "{seen} links");
}

#[test]
fn every_page_is_in_the_table_of_contents() {
    let summary = PathBuf::from("docs/SUMMARY.md");
    let listed: Vec<PathBuf> =
        links(&read(&summary)).iter().filter_map(|link| target(&summary, link)).collect();
    let mut pages = files("docs", ".md");
    pages.remove(&summary);
    assert_eq!(pages, listed.iter().cloned().collect(), "pages, and those of docs/SUMMARY.md");
    assert_eq!(pages.len(), listed.len(), "a page stands there twice");
}

/// The first page is for reading, not for reference.
#[test]
fn the_readme_is_short() {
    assert!(read(Path::new("README.md")).lines().count() <= 120);
}

#[test]
fn links_and_anchors_are_found() {
    let page = "# A `law`, twice\n# A law twice\n[a](b.md#c) `[d](e)` ![f](g.svg)\n```\n[h](i)\n```\n";
    assert_eq!(links(page), ["b.md#c", "g.svg"]);
    assert_eq!(anchors(page), BTreeSet::from(["a-law-twice".to_owned(), "a-law-twice-1".to_owned()]));
    let book = Path::new("docs/method.md");
    assert!(broken(book, "../README.md").is_some_and(|why| why.contains("out of the book")));
    assert!(broken(book, "no.md").is_some() && broken(book, "results.md#no").is_some());
    assert!(
        broken(book, "results.md#speed-of-light").is_some()
            && broken(book, "results.md#many-seeds").is_none()
    );
}
