//! Where the parts of a scheme stand: bodies in a row, walls at its ends, parts between neighbours one above the other,
//! what joins others above the row, contacts and supports of inner bodies below it.

use super::below::{self, Below};
use super::blocks;
use super::canvas::{Along, Canvas, LINE, class};
use super::row;
use super::scheme::{End, Known, Part, Push, Scheme};
use super::symbol::HALF;
use crate::chart::width_of;

/// Round a sketch.
const MARGIN: f64 = 14.0;
/// The thickness of a wall or of a plate with its arrow.
const WALL: f64 = 14.0;
/// Least width and height of a body.
const BODY: (f64, f64) = (92.0, 62.0);
/// Height of a sensor above its body.
const SENSOR: f64 = 26.0;
/// Height of the arrow of a force above a body, with its words.
const ARROW: f64 = 36.0;
/// Between two stems on a body.
const PORT: f64 = 14.0;
/// Part of a disc that stems leave free at each side: its rim is low there.
const IN_DISC: f64 = 0.16;
/// Height of an arrow of a force beside a body, with its words.
const BESIDE: f64 = 38.0;
/// Least length of an arrow.
const LONG: f64 = 52.0;

/// A body with the parts about it, from left to right.
struct Column<'s> {
    body: usize,
    below: Below<'s>,
    sensors: String,
    /// The forces whose arrows stand above the body, or at its free side.
    above: Vec<&'s Push>,
    beside: Vec<&'s Push>,
    /// Parts to its left neighbour or to the wall there.
    before: Vec<&'s Part>,
    wide: f64,
    middle: f64,
}

/// Draws a scheme.
pub(super) fn drawn(scheme: &Scheme) -> Canvas {
    let mut canvas = Canvas::default();
    let mut bottom = MARGIN;
    if !scheme.bodies.is_empty() {
        bottom = mechanism(scheme, &mut canvas) + 18.0;
    }
    blocks::draw(&mut canvas, &scheme.blocks, (MARGIN, bottom));
    canvas
}

/// Width and height with the margins.
pub(super) fn size(canvas: &Canvas) -> (f64, f64) {
    let (wide, high) = canvas.size();
    ((wide + MARGIN).ceil(), (high + MARGIN).ceil())
}

/// The order of the bodies with the fewest parts that pass another body.
fn order(scheme: &Scheme) -> Vec<usize> {
    let n = scheme.bodies.len();
    let joined: Vec<(usize, usize)> = scheme.elements.iter().filter_map(pair).collect();
    let held: Vec<usize> = scheme.elements.iter().filter(|e| pair(e).is_none()).map(body).collect();
    let cost = |order: &[usize]| {
        let place = |b: usize| order.iter().position(|&x| x == b).unwrap_or(0);
        let far = |&(a, b): &(usize, usize)| 10 * (place(a).abs_diff(place(b)) - 1);
        let inner = |&b: &usize| usize::from(place(b) != 0 && place(b) + 1 != n);
        // The order of the spec is left for something only.
        let turned =
            (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).filter(|&(i, j)| order[i] > order[j]);
        joined.iter().map(far).sum::<usize>() + held.iter().map(inner).sum::<usize>() + 12 * turned.count()
    };
    let mut best: Vec<usize> = (0..n).collect();
    // Heap's algorithm.
    let (mut now, mut counts, mut k) = (best.clone(), vec![0; n], 0);
    while k < n {
        if counts[k] < k {
            now.swap(if k % 2 == 0 { 0 } else { counts[k] }, k);
            if cost(&now) < cost(&best) {
                best.clone_from(&now);
            }
            counts[k] += 1;
            k = 0;
        } else {
            counts[k] = 0;
            k += 1;
        }
    }
    best
}

fn pair(part: &Part) -> Option<(usize, usize)> {
    match part.ends {
        (End::Body(a), End::Body(b)) => Some((a, b)),
        _ => None,
    }
}

/// The body of a part that is held by a support.
fn body(part: &Part) -> usize {
    match (part.ends.1, part.ends.0) {
        (End::Body(b), _) | (_, End::Body(b)) => b,
        _ => 0,
    }
}

/// Draws bodies and what is between them; returns where that ends below.
fn mechanism(scheme: &Scheme, canvas: &mut Canvas) -> f64 {
    let order = order(scheme);
    let n = order.len();
    let place = |b: usize| order.iter().position(|&x| x == b).unwrap_or(0);
    let held = |k: usize| {
        scheme.elements.iter().filter(move |e| pair(e).is_none() && place(body(e)) == k).collect::<Vec<_>>()
    };
    let to_wall = |k: usize| -> Vec<&Part> {
        let at_end = k == 0 || k + 1 == n;
        held(k).into_iter().filter(|e| at_end && !below::is_below(e, scheme.bodies[body(e)].turns)).collect()
    };
    let after: Vec<&Part> = if n > 1 { to_wall(n - 1) } else { vec![] };
    let between = |a: usize, b: usize| -> Vec<&Part> {
        let joins =
            |e: &&Part| pair(e).is_some_and(|(x, y)| [(a, b), (b, a)].contains(&(place(x), place(y))));
        scheme.elements.iter().filter(joins).collect()
    };
    let far: Vec<(usize, usize, &Part)> = scheme
        .elements
        .iter()
        .filter_map(|e| {
            let (x, y) = pair(e)?;
            let (a, b) = (place(x).min(place(y)), place(x).max(place(y)));
            (b > a + 1).then_some((a, b, e))
        })
        .collect();
    let mut columns: Vec<Column<'_>> = (0..n)
        .map(|k| {
            let body = order[k];
            let under = held(k)
                .into_iter()
                .filter(|e| below::is_below(e, scheme.bodies[body].turns) || (k > 0 && k + 1 < n));
            let pushes: Vec<&Push> = scheme.pushes.iter().filter(|p| p.body == body).collect();
            let free = k + 1 == n && after.is_empty();
            let (beside, above) = if free { (pushes, vec![]) } else { (vec![], pushes) };
            let before = if k == 0 { to_wall(0) } else { between(k - 1, k) };
            let ports = above.len() + far.iter().filter(|(a, b, _)| *a == k || *b == k).count();
            let below = Below::new(under.collect(), scheme.bodies[body].turns);
            let sensors = sensors(scheme, body);
            let of = &scheme.bodies[body];
            let top = if sensors.is_empty() { 0.0 } else { 28.0 + 1.08 * width_of(&sensors) };
            let inside =
                (1.08 * width_of(&of.name)).max(width_of(&of.inertia)) + if of.turns { 30.0 } else { 20.0 };
            let free = if of.turns { 1.7 } else { 1.0 };
            let wide = BODY.0.max(inside).max(free * (top + PORT * ports as f64 + 12.0)).max(below.least());
            Column { body, below, sensors, above, beside, before, wide, middle: 0.0 }
        })
        .collect();
    let rows = columns.iter().map(|c| row::size(&c.before).1).chain([row::size(&after).1]);
    let beside = columns.iter().map(|c| BESIDE * c.beside.len() as f64).fold(BODY.1, f64::max);
    let mut high = rows.fold(beside, |a, b| a.max(b + 10.0)).ceil();
    // A disc is as wide as it is high.
    if columns.iter().any(|c| scheme.bodies[c.body].turns) {
        high = columns.iter().filter(|c| scheme.bodies[c.body].turns).map(|c| c.wide).fold(high, f64::max);
        columns.iter_mut().filter(|c| scheme.bodies[c.body].turns).for_each(|c| c.wide = high);
    }
    let lane = |part: &Part| LINE * part.words.len() as f64 + 2.0 * HALF + 6.0;
    let lanes: f64 = far.iter().map(|(_, _, e)| lane(e)).sum();
    let arrows = columns.iter().map(|c| c.above.len()).max().unwrap_or(0) as f64 * ARROW;
    let sensing = if columns.iter().any(|c| !c.sensors.is_empty()) { SENSOR } else { 0.0 };
    let top = MARGIN + lanes + arrows + sensing;
    place_columns(&mut columns);
    // The upper edge of a body.
    let rim = |c: &Column<'_>, x: f64| match scheme.bodies[c.body].turns {
        true => top + 0.5 * high - (0.25 * high * high - (x - c.middle).powi(2)).max(0.0).sqrt(),
        false => top,
    };
    let first_port = |c: &Column<'_>| c.middle + port_of(c, scheme.bodies[c.body].turns);
    // Bodies.
    for c in &columns {
        let of = &scheme.bodies[c.body];
        let (left, since) = (c.middle - 0.5 * c.wide, canvas.drawn.len());
        canvas.body(&of.name, of.turns, (left, top, c.wide, high));
        let two = !of.inertia.is_empty();
        let y = top + 0.5 * high;
        let lines = [
            (of.name.clone(), "name middle", if two { -9.0 } else { 0.0 }),
            (of.inertia.clone(), "label middle", 9.0),
        ];
        for (text, style, by) in lines {
            canvas.words(&text, (c.middle, y + by), style);
        }
        canvas.group(since, End::Body(c.body).key());
        if !c.sensors.is_empty() {
            let known = if of.lit.is_empty() { Known::Stated } else { Known::Found };
            let x = left + if of.turns { IN_DISC * c.wide } else { 14.0 };
            canvas.sensor((x, top), known);
            if of.turns {
                canvas.rod((x, top), (x, rim(c, x)), known);
            }
            canvas.words(&c.sensors, (x + 11.0, top - 12.0), &format!("label {}", class(known)));
        }
    }
    // What is between them.
    let edge = |k: usize, side: f64, y: f64, columns: &[Column<'_>]| {
        let c = &columns[k];
        let half = match scheme.bodies[c.body].turns {
            true => {
                let r = 0.5 * high;
                (r * r - (y - top - r).powi(2)).max(0.0).sqrt()
            }
            false => 0.5 * c.wide,
        };
        c.middle + side * half
    };
    for (k, c) in columns.iter().enumerate() {
        let start = top + 0.5 * (high - row::size(&c.before).1);
        let right = |y: f64| edge(k, -1.0, y, &columns);
        if k == 0 {
            row::draw(canvas, &c.before, &scheme.bases, (start, -1), (&|_| MARGIN + WALL, &right));
        } else {
            let left = |y: f64| edge(k - 1, 1.0, y, &columns);
            row::draw(canvas, &c.before, &scheme.bases, (start, 0), (&left, &right));
        }
    }
    let last = &columns[n - 1];
    let (wide, tall) = row::size(&after);
    let wall = last.middle + 0.5 * last.wide + wide;
    let left = |y: f64| edge(n - 1, 1.0, y, &columns);
    row::draw(canvas, &after, &scheme.bases, (top + 0.5 * (high - tall), 1), (&left, &|_| wall));
    // Forces.
    for c in &columns {
        for (k, push) in c.beside.iter().enumerate() {
            let y = top + 0.5 * high + BESIDE * (k as f64 - 0.5 * (c.beside.len() as f64 - 1.0));
            let (x, long) = (c.middle + 0.5 * c.wide + 3.0, LONG.max(width_of(&push.words) * 0.6));
            canvas.arrow((x, y), long, push.known);
            canvas.words(&push.words, (x + 4.0, y - 16.0), &format!("label {}", class(push.known)));
        }
        let mut port = first_port(c);
        for (k, push) in c.above.iter().enumerate() {
            let y = top - sensing - ARROW * k as f64 - 6.0;
            canvas.stem((port, rim(c, port)), y, push.known);
            canvas.arrow((port, y), LONG, push.known);
            canvas.words(&push.words, (port + 4.0, y - 15.0), &format!("label {}", class(push.known)));
            port -= PORT;
        }
    }
    // What joins bodies that are no neighbours.
    let (mut y, mut stems) = (MARGIN, Vec::<f64>::new());
    for (k, (a, b, part)) in far.iter().enumerate() {
        let port = |of: usize| {
            let c = &columns[of];
            let before = far[..k].iter().filter(|(a, b, _)| *a == of || *b == of).count();
            first_port(c) - PORT * (c.above.len() + before) as f64
        };
        let (from, to) = (port(*a), port(*b));
        let since = canvas.drawn.len();
        let line = y + LINE * part.words.len() as f64 + HALF;
        // Stems of the parts above go through: the symbol stands in the widest room between them.
        let mut cuts: Vec<f64> = vec![from, to];
        cuts.extend(stems.iter().copied().filter(|x| *x > from && *x < to));
        cuts.sort_by(f64::total_cmp);
        let rooms = cuts.windows(2).map(|pair| (pair[0], pair[1]));
        let (left, right) = rooms.max_by(|p, q| (p.1 - p.0).total_cmp(&(q.1 - q.0))).unwrap_or((from, to));
        canvas.lines(&part.words, (0.5 * (left + right), y), &format!("label middle {}", class(part.known)));
        for (of, x) in [(*a, from), (*b, to)] {
            canvas.stem((x, rim(&columns[of], x)), line, part.known);
            stems.push(x);
        }
        canvas.rod((from, line), (left, line), part.known);
        canvas.rod((right, line), (to, line), part.known);
        canvas.part(part.kind, part.known, Along::Right(left, line, right - left));
        canvas.group(since, part.key());
        y += lane(part);
    }
    // Contacts and supports below.
    let mut bottom = top + high;
    for c in &columns {
        bottom = bottom.max(c.below.draw(canvas, &scheme.bases, (c.middle, top + high, 0.5 * c.wide)));
    }
    bottom
}

/// Where the first stem stands on a body, from its middle.
fn port_of(c: &Column<'_>, turns: bool) -> f64 {
    if turns { (0.5 - IN_DISC) * c.wide } else { 0.5 * c.wide - 8.0 }
}

/// The columns that sensors read of a body, with what was found of them.
fn sensors(scheme: &Scheme, body: usize) -> String {
    let of = &scheme.bodies[body];
    let names = of.sensors.join(", ");
    if of.lit.is_empty() { names } else { format!("{names}: {}", of.lit.join(", ")) }
}

/// The middles of the bodies, so that neither they nor what stands above and below them meet.
fn place_columns(columns: &mut [Column<'_>]) {
    let above = |c: &Column<'_>| {
        let port = 0.5 * c.wide - 8.0;
        c.above.iter().map(|p| port + LONG.max(width_of(&p.words) + 8.0)).fold(0.0, f64::max)
    };
    let mut x = MARGIN;
    for k in 0..columns.len() {
        let (wide, _) = row::size(&columns[k].before);
        let c = &columns[k];
        let half = 0.5 * c.wide;
        let at_wall = if c.before.is_empty() { MARGIN } else { MARGIN + WALL + wide };
        let middle = match k.checked_sub(1).map(|k| &columns[k]) {
            None => (at_wall + half).max(x + c.below.reach(c.wide).0),
            Some(left) => {
                let gap = if c.before.is_empty() { 30.0 } else { wide };
                let rows = left.middle + 0.5 * left.wide + gap + half;
                let below = left.middle + left.below.reach(left.wide).1 + c.below.reach(c.wide).0 + 14.0;
                let arrows = left.middle + above(left) + half + 12.0;
                rows.max(below).max(arrows)
            }
        };
        x = middle;
        columns[k].middle = middle;
    }
}
