//! Lines too long to be shown: what surrounds the marked places is kept, the rest becomes dots.

use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, Label, Source, Sources};
use std::borrow::Cow;
use std::ops::Range;

/// Longer lines are clipped.
const WIDEST: usize = 200;
/// Bytes kept before and behind a marked place, and of the place itself.
const AROUND: usize = 60;
/// Stands for what is left out.
const DOTS: &str = "...";

/// A diagnostic and the texts that it points into, both clipped where that is needed.
pub(super) struct Clipped<'a> {
    pub(super) diagnostic: Cow<'a, Diagnostic>,
    pub(super) sources: Cow<'a, Sources>,
    /// For each source that was clipped, where each kept piece begins: in the clipped text, and in the whole
    /// one.
    pieces: Vec<(usize, Vec<(usize, usize)>)>,
}

impl<'a> Clipped<'a> {
    pub(super) fn new(diagnostic: &'a Diagnostic, sources: &'a Sources) -> Clipped<'a> {
        let mut clipped = Clipped {
            diagnostic: Cow::Borrowed(diagnostic),
            sources: Cow::Borrowed(sources),
            pieces: vec![],
        };
        let mut touched: Vec<usize> = diagnostic.labels.iter().map(|l| l.source.0).collect();
        touched.sort_unstable();
        touched.dedup();
        for id in touched {
            let text = &sources.files[id].text;
            let places = diagnostic.labels.iter().filter(|l| l.source.0 == id).map(|l| l.span.range());
            if let Some(kept) = kept(text, places) {
                clipped.clip(id, &kept);
            }
        }
        clipped
    }

    /// Leaves of a source only these pieces, which are in order and apart.
    fn clip(&mut self, id: usize, kept: &[Range<usize>]) {
        let whole = self.sources.files[id].text.clone();
        let (mut text, mut begin, mut end) = (String::new(), Vec::new(), 0);
        for piece in kept {
            if piece.start > end {
                text += DOTS;
            }
            begin.push((text.len(), piece.start));
            text += &whole[piece.clone()];
            end = piece.end;
        }
        if end < whole.len() {
            text += DOTS;
        }
        let moved = |at: usize| {
            let k = kept.partition_point(|p| p.start <= at).saturating_sub(1);
            // A place that is longer than what is kept of it ends where that ends.
            begin[k].0 + at.clamp(kept[k].start, kept[k].end) - kept[k].start
        };
        for Label { source, span, .. } in &mut self.diagnostic.to_mut().labels {
            if source.0 == id {
                *span = Span::new(moved(span.start), moved(span.end));
            }
        }
        let Source { name, first_line, .. } = &self.sources.files[id];
        let source = Source { name: name.clone(), text, first_line: *first_line };
        self.sources.to_mut().files[id] = source;
        self.pieces.push((id, begin));
    }

    /// The column, counted from 1, of a place in the clipped text in the line as it really is; none where
    /// nothing was clipped.
    pub(super) fn column(&self, whole: &Sources, id: usize, at: usize) -> Option<usize> {
        let (_, begin) = self.pieces.iter().find(|(clipped, _)| *clipped == id)?;
        let (here, there) = begin[begin.partition_point(|(b, _)| *b <= at).checked_sub(1)?];
        let text = &whole.files[id].text;
        let before = text.get(..there + at - here)?;
        Some(1 + before.chars().rev().take_while(|c| *c != '\n').count())
    }
}

/// The pieces to keep of a text whose marked lines are too long for a screen; none if all of it can be shown.
fn kept(text: &str, places: impl Iterator<Item = Range<usize>>) -> Option<Vec<Range<usize>>> {
    let boundary = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let mut long: Vec<(Range<usize>, Range<usize>)> = Vec::new();
    for place in places {
        let place = boundary(place.start)..boundary(place.end);
        let start = text[..place.start].rfind('\n').map_or(0, |at| at + 1);
        let end = text[place.start..].find('\n').map_or(text.len(), |at| place.start + at);
        if end - start > WIDEST {
            let to = place.end.min(place.start + AROUND).min(end);
            let around = place.start.saturating_sub(AROUND).max(start)..(to + AROUND).min(end);
            long.push((start..end, boundary(around.start)..boundary(around.end)));
        }
    }
    if long.is_empty() {
        return None;
    }
    long.sort_by_key(|(_, around)| around.start);
    let mut pieces: Vec<Range<usize>> = Vec::new();
    let mut done = 0;
    for (line, around) in &long {
        // The lines before this one stay as they are.
        if line.start > done || done == 0 {
            pieces.push(done..line.start);
        }
        pieces.push(around.clone());
        done = done.max(line.end);
    }
    pieces.push(done..text.len());
    let mut joined: Vec<Range<usize>> = Vec::new();
    for piece in pieces.into_iter().filter(|p| !p.is_empty()) {
        match joined.last_mut() {
            Some(last) if piece.start <= last.end => last.end = last.end.max(piece.end),
            _ => joined.push(piece),
        }
    }
    Some(joined)
}
