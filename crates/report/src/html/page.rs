//! The page: header with the finding, first figures, contents, sections, figures.

use crate::chart::{self, Chart, Sheet};
use crate::format::capital;
use crate::input::Input;
use crate::markup::{Element, element};
use crate::sketch;
use crate::tied::tied;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");
/// What a report may do: run this one script, by its SHA-256, and reach nothing else, whatever a spec puts into it.
const POLICY: &str = "default-src 'none'; script-src 'sha256-nl+VQ7WhhobBniBj7gymgbXc/EYVs/xbcLRIG/saus8='; \
                      style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";

/// A sketch is drawn no smaller than this part of its size: its words stay legible.
const LEGIBLE: f64 = 0.8;

/// The tone of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    /// The result can be used.
    Good,
    /// The result cannot be used.
    Bad,
    /// A question stays open.
    Open,
}

impl Tone {
    /// Class and sign, so that the tone does not depend on colour alone.
    fn class_and_sign(self) -> (&'static str, &'static str) {
        match self {
            Tone::Good => ("good", "✓"),
            Tone::Bad => ("bad", "✕"),
            Tone::Open => ("open", "?"),
        }
    }
}

/// The result in a few words.
pub(crate) struct Banner {
    pub(crate) tone: Tone,
    /// One word.
    pub(crate) headline: String,
    /// The finding in a sentence, with its numbers.
    pub(crate) text: String,
    /// How it was found; may be empty.
    pub(crate) how: String,
}

/// A finished report: one page that needs no network, and its figures as files.
#[derive(Clone, Debug)]
pub struct HtmlReport {
    /// The page.
    pub page: String,
    /// File name and content of each figure.
    pub figures: Vec<(String, String)>,
}

/// A section with the name by which links reach it.
struct Section {
    id: String,
    heading: String,
    element: Element,
}

/// A report under construction.
pub(crate) struct Page {
    title: String,
    spec: String,
    banner: Banner,
    /// Figures of the first screen.
    first: Vec<Element>,
    /// Number of sections that stand before them.
    early: usize,
    sections: Vec<Section>,
    charts: Vec<Chart>,
}

/// A picture with its caption.
pub(crate) type Captioned = (Chart, String);

impl Page {
    /// A page about a spec.
    pub(crate) fn new(input: Input<'_>, banner: Banner) -> Page {
        let title = &input.case.system.title;
        let title = if title.is_empty() { input.name.to_owned() } else { title.clone() };
        Page::of_refusal(&title, input.name, banner)
    }

    /// A page about a spec that could not be read.
    pub(crate) fn of_refusal(title: &str, spec: &str, banner: Banner) -> Page {
        let [title, spec] = [title, spec].map(str::to_owned);
        Page { title, spec, banner, first: vec![], early: 0, sections: vec![], charts: vec![] }
    }

    /// Adds a section unless it is empty.
    pub(crate) fn section(&mut self, heading: &str, content: impl IntoIterator<Item = Element>) {
        let content: Vec<Element> = content.into_iter().collect();
        if !content.is_empty() {
            let id: String = heading.to_lowercase().replace(|c: char| !c.is_ascii_alphanumeric(), "-");
            let title = element("h2").with("id", &id).text(heading);
            let section = element("section").with("aria-labelledby", &id).add(title).all(content);
            self.sections.push(Section { id, heading: heading.to_owned(), element: section });
        }
    }

    /// Adds a section with a list unless it is empty.
    pub(crate) fn list(&mut self, heading: &str, lines: &[String]) {
        let items = lines.iter().map(|line| worded(element("li"), line));
        let list = element("ul").all(items);
        self.section(heading, (!lines.is_empty()).then_some(list));
    }

    /// Adds a section with figures and captions unless it is empty.
    pub(crate) fn figures(&mut self, heading: &str, draw: impl Fn(Sheet) -> Vec<Captioned>) {
        let figures = self.drawn(Sheet::Page, draw);
        self.section(heading, figures);
    }

    /// Charts with their captions as elements, each drawn for a page and for a phone; the charts become
    /// figure files of the report.
    pub(crate) fn drawn(&mut self, sheet: Sheet, draw: impl Fn(Sheet) -> Vec<Captioned>) -> Vec<Element> {
        let both = draw(sheet).into_iter().zip(draw(Sheet::Phone));
        let figures = both.map(|((wide, caption), (narrow, _))| self.figure(wide, &narrow, &caption));
        figures.collect()
    }

    fn figure(&mut self, wide: Chart, narrow: &Chart, caption: &str) -> Element {
        let on = |class: &str, chart: Element| element("div").class(class).add(chart);
        let pieces = wide.pieces();
        let whole = if pieces.is_empty() { "wide" } else { "wide cut" };
        let paper = element("div").class("paper").with("aria-hidden", "true").all(pieces.iter().cloned());
        let figure = element("figure")
            .add(on(whole, wide.inline("")))
            .all((!pieces.is_empty()).then_some(paper))
            .add(on("narrow", narrow.inline("-phone")))
            .add(element("figcaption").text(tied(caption)));
        self.charts.push(wide);
        figure
    }

    /// Adds the sketch of the model. It is drawn once: on a phone a wide one is moved sideways.
    pub(crate) fn sketch(&mut self, made: Option<Captioned>) {
        let Some((chart, caption)) = made else { return };
        let held = element("div").with("style", format!("min-width:{}px", (LEGIBLE * chart.width()).ceil()));
        let scroll = element("div")
            .class("scroll")
            .with("tabindex", 0)
            .with("role", "group")
            .with("aria-label", "sketch of the model")
            .add(held.add(chart.named()));
        let caption = element("figcaption").text(tied(&caption));
        self.section("The model", [element("figure").add(scroll).add(caption)]);
        self.charts.push(chart);
    }

    /// Adds the figures of the first screen, side by side, and what stands below them. Sections that were
    /// added before stand above.
    pub(crate) fn first(&mut self, figures: Vec<Element>, below: Vec<Element>) {
        self.early = self.sections.len();
        if !figures.is_empty() {
            self.first.push(element("div").class("pair").all(figures));
        }
        self.first.extend(below);
    }

    /// The page and the figures as texts.
    pub(crate) fn html(&self) -> HtmlReport {
        let figures = self.charts.iter().map(|chart| (format!("{}.svg", chart.name), chart.file()));
        HtmlReport { page: self.page(), figures: figures.collect() }
    }

    fn page(&self) -> String {
        let meta = |name: &str, content: &str| element("meta").with("name", name).with("content", content);
        let head = element("head")
            .add(element("meta").with("charset", "utf-8"))
            .add(element("meta").with("http-equiv", "Content-Security-Policy").with("content", POLICY))
            .add(meta("viewport", "width=device-width, initial-scale=1"))
            .add(meta("color-scheme", "light dark"))
            .add(meta("generator", concat!("phisindy ", env!("CARGO_PKG_VERSION"))))
            .add(element("title").text(format!("{}: {}", self.title, self.banner.headline.to_lowercase())))
            .add(element("style").raw(format!("{STYLE}{}{}", chart::STYLE, sketch::STYLE)));
        let sections: Vec<Element> = self.sections.iter().map(|s| s.element.clone()).collect();
        let (early, late) = sections.split_at(self.early);
        let first = self.first.iter().chain(late).cloned();
        let main = element("main").add(self.top()).all(early.iter().cloned()).all(first);
        let body = element("body").all(self.contents()).add(main).add(element("script").raw(SCRIPT));
        let html = element("html").with("lang", "en").add(head).add(body);
        format!("<!DOCTYPE html>\n{html}\n")
    }

    /// Title and finding.
    fn top(&self) -> Element {
        let (class, sign) = self.banner.tone.class_and_sign();
        let verdict = element("p")
            .class("verdict")
            .add(element("span").class("sign").with("aria-hidden", "true").text(sign))
            .text(" ")
            .text(&self.banner.headline);
        let how = element("p").class("how").text(tied(&self.banner.how));
        let banner = element("div")
            .class(format!("banner {class}"))
            .add(verdict)
            .add(worded(element("p").with("id", "finding").class("finding"), &self.banner.text))
            .all((!self.banner.how.is_empty()).then_some(how));
        let spec = element("span").class("spec").text(" · ").add(element("code").text(&self.spec));
        element("div")
            .class("top")
            .add(element("p").class("kind").text("phisindy report").add(spec))
            .add(element("h1").with("id", "top").text(&self.title))
            .add(banner)
    }

    /// Links to the sections, if there are enough to get lost.
    fn contents(&self) -> Option<Element> {
        let link = |id: &str, words: &str| {
            element("li").add(element("a").with("href", format!("#{id}")).text(words))
        };
        let links = self.sections.iter().map(|s| link(&s.id, &s.heading));
        let list = element("ul").add(link("top", &self.banner.headline)).all(links);
        (self.sections.len() > 2).then(|| element("nav").with("aria-label", "Contents").add(list))
    }
}

/// Preformatted text.
pub(crate) fn block(text: &str, label: &str) -> Element {
    let pre = element("pre").class("scroll").with("tabindex", 0).with("role", "group");
    pre.with("aria-label", label).add(element("code").text(text))
}

/// A paragraph.
pub(crate) fn paragraph(text: &str) -> Element {
    worded(element("p"), text)
}

/// The element with a text in which what stands between back ticks is code.
pub(crate) fn worded(element_: Element, text: &str) -> Element {
    let parts: Vec<&str> = text.split('`').collect();
    // A single back tick is itself.
    if parts.len().is_multiple_of(2) {
        return element_.text(tied(text));
    }
    let add = |out: Element, (k, part): (usize, &&str)| match k % 2 {
        0 => out.text(tied(part)),
        _ => out.add(element("code").text(part)),
    };
    parts.iter().enumerate().fold(element_, add)
}

/// The words as a sentence of their own. A name at the beginning stays as it is written.
pub(crate) fn sentence(words: &str) -> String {
    let named =
        words.split([' ', ':']).next().is_some_and(|first| first.contains(|c: char| !c.is_alphabetic()));
    let end = if words.ends_with(['.', '?', '!']) { "" } else { "." };
    format!("{}{end}", if named { words.to_owned() } else { capital(words) })
}

/// Adds the warnings: what a careful reader should know of the result.
pub(crate) fn add_warnings(page: &mut Page, warnings: &[String]) {
    let sentences: Vec<String> = warnings.iter().map(|w| sentence(w)).collect();
    page.list("Warnings", &sentences);
}

/// Adds doubts about the data and notes on their processing, each in its section.
pub(crate) fn add_data_remarks(page: &mut Page, doubts: &[String], notes: &[String]) {
    let sentences = |all: &[String]| all.iter().map(|words| sentence(words)).collect::<Vec<_>>();
    page.list("What is odd about the data", &sentences(doubts));
    page.list("What was done to the data", &sentences(notes));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The colours of a block of the style sheet.
    fn colours(block: &str) -> Vec<(&str, [f64; 3])> {
        let pairs = block.split(';').filter_map(|line| line.trim().trim_start_matches('{').split_once(": #"));
        let channel = |hex: &str, k: usize| {
            f64::from(u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).expect("two digits"))
        };
        let named = |(name, hex): (&'static str, &str)| (name, [0, 1, 2].map(|k| channel(hex, k) / 255.0));
        let own: Vec<(&'static str, &str)> = NAMES
            .iter()
            .filter_map(|n| {
                pairs.clone().find(|(name, _)| name.trim().ends_with(n)).map(|(_, hex)| (*n, hex))
            })
            .collect();
        own.into_iter().map(named).collect()
    }

    const NAMES: [&str; 8] =
        ["--page", "--panel", "--ink", "--soft", "--accent", "--good", "--bad", "--open"];

    /// WCAG 2.1, relative luminance.
    fn luminance(colour: [f64; 3]) -> f64 {
        let linear = |c: f64| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        let [r, g, b] = colour.map(linear);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    #[test]
    fn words_stand_out_from_what_is_behind_them() {
        let blocks: Vec<&str> =
            STYLE.split(":root {").skip(1).map(|b| b.split('}').next().unwrap_or("")).collect();
        assert_eq!(blocks.len(), 2, "light and dark");
        for block in blocks {
            let all = colours(block);
            assert_eq!(all.len(), NAMES.len(), "{block}");
            for (behind, back) in &all[..2] {
                for (word, front) in &all[2..] {
                    let (a, b) = (luminance(*back), luminance(*front));
                    let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
                    assert!(contrast >= 4.5, "{word} on {behind}: {contrast:.2}");
                }
            }
        }
    }
}
