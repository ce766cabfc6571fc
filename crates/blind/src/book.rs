//! The preprocessor of the book (`mdbook`): formulas between `$` become MathML, which needs neither script
//! nor network. (<https://rust-lang.github.io/mdBook/for_developers/preprocessors.html>)

use crate::folder;
use anyhow::{Context, Result, anyhow};
use pulldown_latex::{Parser, RenderConfig, Storage, config::DisplayMode, push_mathml};
use serde_json::Value;
use std::convert::Infallible;
use std::io::Read;

/// Takes `[context, book]` as JSON from standard input and prints the book with its formulas as MathML. With
/// the query `supports RENDERER` it prints nothing: every renderer that takes HTML is supported.
///
/// # Errors
/// Standard input is not what mdbook writes, or a formula cannot be typeset.
pub(crate) fn preprocess(query: &[String]) -> Result<()> {
    if !query.is_empty() {
        return Ok(());
    }
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text).context("cannot read standard input")?;
    let [_, mut book]: [Value; 2] = serde_json::from_str(&text).context("this is not what mdbook writes")?;
    chapters(&mut book)?;
    folder::print(&book.to_string())
}

/// Each object with a `content` is a chapter, in all versions of mdbook.
fn chapters(value: &mut Value) -> Result<()> {
    match value {
        Value::Array(all) => all.iter_mut().try_for_each(chapters),
        Value::Object(fields) => {
            if let Some(Value::String(content)) = fields.get_mut("content") {
                *content = with_index(&with_mathml(content)?);
            }
            fields.values_mut().try_for_each(chapters)
        }
        _ => Ok(()),
    }
}

/// Markdown whose links to a `README.md` lead to the `index.html` that mdbook makes of it: mdbook itself
/// names the page so, but leaves the links of other pages as they are.
fn with_index(text: &str) -> String {
    text.replace("/README.md)", "/index.md)")
        .replace("/README.md#", "/index.md#")
        .replace("](README.md", "](index.md")
}

/// Markdown in which formulas are MathML; code stays as it is.
fn with_mathml(text: &str) -> Result<String> {
    let (mut out, mut rest) = (String::with_capacity(2 * text.len()), text);
    while let Some(at) = rest.find(['$', '`']) {
        let (before, from) = rest.split_at(at);
        out.push_str(before);
        let mark = &from[..from.len() - from.trim_start_matches(&from[..1]).len()];
        let inside = &from[mark.len()..];
        // A mark that does not end is text.
        let Some(end) = inside.find(mark) else {
            out.push_str(mark);
            rest = inside;
            continue;
        };
        if mark.starts_with('$') {
            out.push_str(&mathml(&inside[..end], mark.len() > 1)?);
        } else {
            out.push_str(&from[..2 * mark.len() + end]);
        }
        rest = &inside[end + mark.len()..];
    }
    out.push_str(rest);
    Ok(out)
}

/// A formula on one line, with what Markdown would take for itself as entities.
fn mathml(latex: &str, block: bool) -> Result<String> {
    let wrong = |why: String| anyhow!("cannot typeset `{latex}`: {why}");
    let storage = Storage::new();
    let events: Vec<_> =
        Parser::new(latex, &storage).collect::<Result<_, _>>().map_err(|e| wrong(e.to_string()))?;
    let display_mode = if block { DisplayMode::Block } else { DisplayMode::Inline };
    let config = RenderConfig { display_mode, ..Default::default() };
    let mut math = String::new();
    push_mathml(&mut math, events.into_iter().map(Ok::<_, Infallible>), config)
        .map_err(|e| wrong(e.to_string()))?;
    let mut out = String::with_capacity(math.len());
    for c in math.chars() {
        match c {
            '*' | '_' | '|' | '`' | '\\' | '[' | ']' | '$' | '~' => {
                out.push_str(&format!("&#{};", u32::from(c)))
            }
            '\n' => out.push(' '),
            c => out.push(c),
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    fn pages(folder: &Path, all: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pages(&path, all);
            } else if path.extension().is_some_and(|e| e == "md") {
                all.push(path);
            }
        }
    }

    #[test]
    fn every_formula_of_the_book_can_be_typeset() {
        let mut all = Vec::new();
        pages(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs"), &mut all);
        let mut formulas = 0;
        for page in all {
            let made = with_mathml(&std::fs::read_to_string(&page).unwrap());
            formulas += made.unwrap_or_else(|e| panic!("{}: {e}", page.display())).matches("<math").count();
        }
        assert!(formulas > 50, "{formulas}");
    }

    #[test]
    fn links_to_a_readme_lead_to_its_page() {
        let made =
            with_index("[laws](../laws/README.md#stribeck), [this](README.md), [cluster](cluster/README.md)");
        assert_eq!(made, "[laws](../laws/index.md#stribeck), [this](index.md), [cluster](cluster/index.md)");
    }

    #[test]
    fn formulas_become_mathml_and_code_stays() {
        let made =
            with_mathml("a $|v|$ b `$x$` c\n```console\n$ phisindy run\n```\n$$\\frac{1}{2}$$ d").unwrap();
        assert!(made.contains("&#124;") && !made.contains("|v|"), "{made}");
        assert!(made.contains("`$x$` c\n```console\n$ phisindy run\n```\n"), "{made}");
        assert!(made.contains("<mfrac>") && made.ends_with(" d"), "{made}");
    }

    #[test]
    fn chapters_of_chapters_are_found() {
        let mut book = serde_json::json!({ "sections": [{ "Chapter": { "content": "$a$", "sub_items": [
            { "Chapter": { "content": "$b$", "sub_items": [] } }] } }, "Separator"] });
        chapters(&mut book).unwrap();
        assert_eq!(book.to_string().matches("<math").count(), 2);
    }
}
