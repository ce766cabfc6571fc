//! All laws that were tried beside the model as it is, best first, and those that could not be tried.

use super::page::paragraph;
use super::table::{Cell, code, table, text};
use crate::chart::digits;
use crate::format::capital;
use crate::markup::{Element, element};
use phisindy_gap::{Gap, Tried};
use phisindy_phys::LawEntry;

/// Rows that are shown; the others are folded.
const SHOWN: usize = 14;

/// The tables; empty if nothing was tried.
pub(crate) fn leaderboard(found: &Gap, catalogue: &[LawEntry]) -> Vec<Element> {
    if found.tried.is_empty() {
        return vec![];
    }
    // The score of a fit counts the scatter of what is left, that of the regression the noise: they do not
    // compare.
    let (fitted, screened): (Vec<&Tried>, Vec<&Tried>) = found.tried.iter().partition(|t| t.gap.is_some());
    let said = paragraph(
        "Each law by itself beside the model as it is. Score: how far its fit lowers the criterion (misfit and the price \
         of its numbers). Gap: what its fit leaves, in units of the noise. Probability: among the laws that were fitted \
         and not ruled out, where one of them leaves noise alone. A law that evidence rules out is struck through.",
    );
    let mut out = vec![said];
    let rows = |part: &[&Tried], best: f64| part.iter().map(|t| row(t, best, catalogue)).collect::<Vec<_>>();
    let best = |all: &[&Tried]| all.iter().map(|t| t.score).filter(|s| s.is_finite()).fold(0.0, f64::max);
    let head = ["law", "score", "gap", "probability", "ruled out because"];
    let (first, rest) = fitted.split_at(SHOWN.min(fitted.len()));
    out.extend(table("Laws that were fitted in full, best first", &head, rows(first, best(&fitted))));
    let more = table("The other laws that were fitted in full", &head, rows(rest, best(&fitted)));
    out.extend(more.map(|table| folded(&format!("{} more that were fitted", rest.len()), table)));
    let head = ["law", "score of the regression"];
    let short = |all: &[&Tried]| -> Vec<Vec<Cell>> {
        rows(all, best(&screened)).into_iter().map(|row| row.into_iter().take(2).collect()).collect()
    };
    // Where no law was worth a fit the screening is all there is.
    let open = if fitted.is_empty() { SHOWN.min(screened.len()) } else { 0 };
    let (first, rest) = screened.split_at(open);
    out.extend(table("Laws that were screened by regression alone, best first", &head, short(first)));
    let caption = "Laws that were screened by regression alone: others did better";
    let words = format!(
        "{}{} laws and places that were screened only",
        rest.len(),
        if open > 0 { " more" } else { "" }
    );
    out.extend(table(caption, &head, short(rest)).map(|table| folded(&words, table)));
    let not: Vec<Vec<Cell>> =
        found.not_tried.iter().map(|n| vec![code(&n.law), text(n.why.to_string())]).collect();
    let count = found.not_tried.len();
    let words = format!("{count} {} not tried", if count == 1 { "law was" } else { "laws were" });
    out.extend(table("Laws that were not tried", &["law", "why not"], not).map(|list| folded(&words, list)));
    out
}

/// An element behind a line that opens it.
fn folded(words: &str, inside: Element) -> Element {
    element("details").add(element("summary").text(words)).add(inside)
}

fn row(t: &Tried, best: f64, catalogue: &[LawEntry]) -> Vec<Cell> {
    let entry = catalogue.iter().find(|e| e.id == t.at.law);
    let name = entry.map_or_else(|| t.at.law.clone(), |e| capital(&e.law.name));
    let words = element(if t.vetoed.is_some() { "s" } else { "span" }).text(name);
    let law = element("span").add(words).text(" at ").add(element("code").text(&t.at.at));
    let part = (t.score / best).clamp(0.0, 1.0);
    let bar = element("span").class("part").with("aria-hidden", "true");
    let bar = bar.with("style", format!("--part:{:.3}", if part.is_finite() { part } else { 0.0 }));
    let score = element("span").class("score").add(bar).text(digits(t.score, 3));
    let number = |x: Option<f64>| x.map_or(text("–"), |x| text(digits(x, 3)));
    let probability = t.probability.map_or(text("–"), |p| text(share(p)));
    let why = t.vetoed.as_ref().map(ToString::to_string).unwrap_or_default();
    vec![Cell::Made(law), Cell::Made(score), number(t.gap), probability, text(why)]
}

/// A probability in per cent.
fn share(p: f64) -> String {
    match 100.0 * p {
        x if x > 99.9 => "> 99.9 %".to_owned(),
        x if x < 0.1 => "< 0.1 %".to_owned(),
        x => format!("{x:.1} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::share;

    #[test]
    fn a_probability_is_never_zero_or_one() {
        assert_eq!([1.0, 0.5, 1e-9].map(share), ["> 99.9 %", "50.0 %", "< 0.1 %"]);
    }
}
