//! Laws for people: a list, one law with its parameters, a page with all pictures.

use crate::format::capital;
use crate::table::{aligned, short};
use phisindy_phys::LawEntry;

/// One line for each law.
pub fn list(all: &[LawEntry]) -> String {
    let rows: Vec<Vec<String>> =
        all.iter().map(|e| vec![e.id.clone(), e.law.name.clone(), e.law.about.clone()]).collect();
    aligned(&rows).join("\n") + "\n"
}

/// One law, for people: its name, what it says, its parameters, where it comes from, its text.
pub fn shown(entry: &LawEntry) -> String {
    let law = &entry.law;
    let mut lines = vec![format!("{} ({})", capital(&law.name), entry.id), law.about.clone(), String::new()];
    lines.extend(law.acts());
    if !law.parameters.is_empty() {
        let mut rows = vec![["parameter", "unit", "within"].map(str::to_owned).to_vec()];
        for (name, p) in &law.parameters {
            let unit = if p.unit.is_empty() { "-".to_owned() } else { p.unit.clone() };
            rows.push(vec![name.clone(), unit, format!("{} to {}", short(p.within.0), short(p.within.1))]);
        }
        lines.push(String::new());
        lines.extend(aligned(&rows));
    }
    lines.push(String::new());
    lines.push(format!("Reference: {}", law.reference));
    lines.push(String::new());
    lines.push(format!("laws/{}.ron:", entry.id));
    lines.extend(entry.text.lines().map(|l| format!("    {l}").trim_end().to_owned()));
    lines.join("\n") + "\n"
}

/// All laws with their pictures, as a page of Markdown.
pub fn gallery(all: &[LawEntry]) -> String {
    let mut out = String::from(
        "# The catalogue of laws\n\nWritten by `phisindy laws --out docs/laws` from the files in `specs/laws`. Each picture is drawn along the motion `x = sin t`, `v = cos t`, with example\nnumbers; a law of your own gets one by a line `sketch: (over: \"v\", with: { ... })`.\n",
    );
    for e in all {
        let law = &e.law;
        out += &format!("\n## {} (`{}`)\n\n{}\n", capital(&law.name), e.id, law.about);
        if law.sketch.is_some() {
            out += &format!("\n![{}]({}.svg)\n", capital(&law.name), e.id);
        }
        out.push('\n');
        out += &law.acts().iter().map(|l| format!("- {}\n", code(l))).collect::<String>();
        for (name, p) in &law.parameters {
            let unit = if p.unit.is_empty() { "no unit" } else { p.unit.as_str() };
            let each = if p.each { ", one for each record" } else { "" };
            out += &format!("- `{name}`: {unit}, {} to {}{each}\n", short(p.within.0), short(p.within.1));
        }
        if !law.reference.is_empty() {
            out += &format!("\n{}\n", law.reference);
        }
    }
    out
}

/// Formats the part after the colon as code.
fn code(line: &str) -> String {
    line.split_once(": ").map_or_else(|| line.to_owned(), |(what, text)| format!("{what}: `{text}`"))
}
