//! A picture as SVG, inside a page or as a file.

use super::label::at;
use crate::markup::{Element, element};

/// The style sheet of charts; its classes are those of the marks.
pub(crate) const STYLE: &str = include_str!("chart.css");

/// A picture is drawn at most so much larger than it is.
const LARGER: f64 = 1.06;
/// A picture that is not higher needs no cut: on paper it is less than a third of a page.
const LOW: f64 = 300.0;

/// A picture with a description for readers who do not see it.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Name of its file, unique in its page.
    pub(crate) name: String,
    /// What the picture shows.
    pub(crate) title: String,
    /// The content in words and numbers.
    pub(crate) description: String,
    width: f64,
    height: f64,
    body: Vec<Element>,
    /// Rules of its own beside [`STYLE`].
    style: &'static str,
    /// Heights at which it may be cut.
    cuts: Vec<f64>,
}

impl Chart {
    /// An empty picture.
    pub(crate) fn new(name: &str, title: &str, description: &str, (width, height): (f64, f64)) -> Chart {
        let [name, title, description] = [name, title, description].map(str::to_owned);
        Chart { name, title, description, width, height, body: vec![], style: "", cuts: vec![] }
    }

    /// The same with rules of its own, which a page of it needs too.
    pub(crate) fn styled(self, style: &'static str) -> Chart {
        Chart { style, ..self }
    }

    /// Its width as it is drawn.
    pub(crate) fn width(&self) -> f64 {
        self.width
    }

    /// Adds elements.
    pub(crate) fn draw(&mut self, parts: impl IntoIterator<Item = Element>) {
        self.body.extend(parts);
    }

    /// On paper a high picture may be cut at this height: nothing is drawn across it.
    pub(crate) fn may_be_cut(&mut self, at: f64) {
        self.cuts.push(at);
    }

    /// A picture that is too high for a part of a page of paper as pieces of it, one above the other; they
    /// show what stands in [`Chart::inline`]. None of a picture that is low or in one piece.
    pub(crate) fn pieces(&self) -> Vec<Element> {
        if self.height <= LOW || self.cuts.is_empty() {
            return vec![];
        }
        let ends: Vec<f64> =
            [0.0].into_iter().chain(self.cuts.iter().copied()).chain([self.height]).collect();
        let piece = |pair: &[f64]| {
            let (width, high) = (at(self.width), at(pair[1] - pair[0]));
            let view = format!("0 {} {width} {high}", at(pair[0]));
            let whole = element("use").with("href", format!("#{}-all", self.name));
            element("svg")
                .class("chart")
                .with("viewBox", view)
                .with("width", width)
                .with("height", high)
                .add(whole)
        };
        ends.windows(2).map(piece).collect()
    }

    /// The picture as an element of a page that includes the style sheet. `variant` tells pictures of one
    /// name apart.
    pub(crate) fn inline(&self, variant: &str) -> Element {
        self.inside(element("svg"), variant)
    }

    /// The same with its name as the `id` of the element.
    pub(crate) fn named(&self) -> Element {
        self.inside(element("svg").with("id", &self.name), "")
    }

    fn inside(&self, svg: Element, variant: &str) -> Element {
        let id = |part: &str| format!("{}{variant}-{part}", self.name);
        let (title, description) = (id("title"), id("desc"));
        self.framed(svg)
            .with("aria-labelledby", format!("{title} {description}"))
            .add(element("title").with("id", title).text(&self.title))
            .add(element("desc").with("id", description).text(&self.description))
            // The style sheet reaches pieces of it too, where they stand.
            .add(element("g").class("chart").with("id", id("all")).all(self.body.iter().cloned()))
    }

    /// The picture as a file, with the style sheet in it.
    pub(crate) fn file(&self) -> String {
        let svg = self
            .framed(element("svg"))
            .with("xmlns", "http://www.w3.org/2000/svg")
            .add(element("title").text(&self.title))
            .add(element("desc").text(&self.description))
            .add(element("style").raw(format!("{STYLE}{}", self.style)))
            .add(element("rect").class("paper").with("width", self.width).with("height", self.height))
            .all(self.body.iter().cloned());
        format!("{svg}\n")
    }

    fn framed(&self, svg: Element) -> Element {
        svg.class("chart")
            .with("role", "img")
            .with("viewBox", format!("0 0 {} {}", self.width, self.height))
            .with("width", self.width)
            .with("height", self.height)
            .with("style", format!("max-width:{}px", at(LARGER * self.width)))
    }
}
