//! Axes: positions of values, and ticks at round values.

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic.
    Log,
    /// `ln(1 + value)`, which starts at zero.
    FromZero,
}

/// An axis with its range.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    /// The quantity.
    name: String,
    /// Its unit; empty for plain numbers.
    unit: String,
    scale: Scale,
    from: f64,
    to: f64,
    /// Whether ticks are whole numbers.
    whole: bool,
    /// Whether it has neither ticks nor a name.
    bare: bool,
}

/// A tick: its value and its label.
pub(crate) type Tick = (f64, String);

impl Axis {
    /// A linear axis that contains the values, with 6 % of their range added at both ends.
    pub(crate) fn around(name: &str, unit: &str, values: impl IntoIterator<Item = f64>) -> Axis {
        let (from, to) = extent(values);
        let room = 0.06 * (to - from);
        Axis::between(name, unit, from - room, to + room)
    }

    /// A linear axis with these ends.
    pub(crate) fn between(name: &str, unit: &str, from: f64, to: f64) -> Axis {
        // A range of zero length is widened.
        let (from, to) = if to > from {
            (from, to)
        } else {
            let reach = if from == 0.0 { 1.0 } else { 0.1 * from.abs() };
            (from - reach, from + reach)
        };
        Axis {
            name: name.to_owned(),
            unit: unit.to_owned(),
            scale: Scale::Linear,
            from,
            to,
            whole: false,
            bare: false,
        }
    }

    /// From 0 to 1, without ticks.
    pub(crate) fn bare() -> Axis {
        Axis { bare: true, ..Axis::between("", "", 0.0, 1.0) }
    }

    /// On another scale.
    pub(crate) fn on(mut self, scale: Scale) -> Axis {
        self.scale = scale;
        self
    }

    /// With ticks at whole numbers only.
    pub(crate) fn whole(mut self) -> Axis {
        self.whole = true;
        self
    }

    /// The first and the last value of the axis.
    pub(crate) fn ends(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    /// The position of a value: 0 at the start of the axis, 1 at its end.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let spread = |v: f64| match self.scale {
            Scale::Linear => v,
            Scale::Log => v.max(f64::MIN_POSITIVE).ln(),
            Scale::FromZero => v.max(0.0).ln_1p(),
        };
        let (a, b) = (spread(self.from), spread(self.to));
        ((spread(value) - a) / (b - a)).clamp(-1.0, 2.0)
    }

    /// The axis for the script of the page: ends, scale, name and unit, separated by bars.
    pub(super) fn told(&self) -> String {
        let scale = match self.scale {
            Scale::Linear => "linear",
            Scale::Log => "log",
            Scale::FromZero => "from-zero",
        };
        let name = if self.bare { "" } else { &self.name };
        format!("{:e}|{:e}|{scale}|{name}|{}", self.from, self.to, self.unit)
    }

    /// The power of ten that all labels share, which keeps them short.
    fn power(&self) -> i32 {
        let largest = self.from.abs().max(self.to.abs());
        let power = largest.log10().floor() as i32;
        if self.scale == Scale::Linear && !(-2..5).contains(&power) { 3 * power.div_euclid(3) } else { 0 }
    }

    /// The label of the axis.
    pub(crate) fn label(&self) -> String {
        let factor = match self.power() {
            0 => String::new(),
            power => format!("10{}", superscript(power)),
        };
        let parts: Vec<&str> = [factor.as_str(), &self.unit].into_iter().filter(|p| !p.is_empty()).collect();
        if parts.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, parts.join(" ")) }
    }

    /// Ticks, about `count` of them.
    pub(crate) fn ticks(&self, count: usize) -> Vec<Tick> {
        match self.scale {
            _ if self.bare => vec![],
            Scale::Linear => self.even(count),
            Scale::Log => self.decades(count, self.from),
            Scale::FromZero => {
                let above = self.decades(count, 1.0_f64.min(self.to));
                // Near zero there is no room for two labels.
                let above = above.into_iter().filter(|(v, _)| self.place(*v) > 0.07);
                [(0.0, "0".to_owned())].into_iter().chain(above).collect()
            }
        }
    }

    fn even(&self, count: usize) -> Vec<Tick> {
        let rough = (self.to - self.from) / count.max(1) as f64;
        let size = 10f64.powf(rough.log10().floor());
        // Takes the round step whose number of ticks is nearest to `count`.
        let apart = |s: &f64| (s * size / rough).ln().abs();
        let nearest = [1.0, 2.0, 5.0, 10.0].into_iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let step = size * nearest.unwrap_or(1.0);
        let step = if self.whole { step.max(1.0) } else { step };
        let unit = 10f64.powi(self.power());
        let decimals = (-(step / unit).log10().floor()).max(0.0) as usize;
        let first = (self.from / step - 1e-9).ceil() as i64;
        let last = (self.to / step + 1e-9).floor() as i64;
        let label = |v: f64| minus(format!("{:.decimals$}", v / unit + 0.0));
        (first..=last).map(|k| (k as f64 * step, label(k as f64 * step))).collect()
    }

    /// Powers of ten, with 2 and 5 between them on a short axis.
    fn decades(&self, count: usize, from: f64) -> Vec<Tick> {
        let low = from.max(f64::MIN_POSITIVE).log10();
        let (first, last) = (low.floor() as i32, self.to.log10().ceil() as i32);
        let every = ((last - first) as usize / count.max(1) + 1) as i32;
        let steps: &[f64] = if self.to.log10() - low < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let powers = (first..=last).filter(|p| p.rem_euclid(every) == 0);
        let values = powers.flat_map(|p| steps.iter().map(move |s| (s * 10f64.powi(p), *s as i32, p)));
        let seen = values.filter(|(v, ..)| *v >= from * (1.0 - 1e-9) && *v <= self.to * (1.0 + 1e-9));
        seen.map(|(v, s, p)| (v, if (-3..4).contains(&p) { plain(v) } else { scientific(s, p) })).collect()
    }
}

/// The least and the largest of the finite values.
fn extent(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|v| v.is_finite());
    let (from, to) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if from <= to { (from, to) } else { (0.0, 1.0) }
}

fn plain(x: f64) -> String {
    // The value is 1, 2 or 5 times a power of ten: rounding removes its error in the last bit.
    format!("{}", (x * 1e6).round() / 1e6)
}

fn scientific(digit: i32, power: i32) -> String {
    let ten = format!("10{}", superscript(power));
    if digit == 1 { ten } else { format!("{digit}·{ten}") }
}

fn superscript(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
    power.to_string().chars().map(raised).collect()
}

/// Replaces hyphens by minus signs.
fn minus(text: String) -> String {
    text.replace('-', "−")
}

/// A number in a text, with `count` significant digits.
pub(crate) fn digits(x: f64, count: usize) -> String {
    if !x.is_finite() {
        return "–".to_owned();
    }
    let power = if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 };
    if (-4..6).contains(&power) {
        minus(format!("{x:.*}", (count as i32 - 1 - power).max(0) as usize))
    } else {
        minus(format!("{:.*}", count - 1, x / 10f64.powi(power))) + "·10" + &superscript(power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, count: usize) -> Vec<String> {
        axis.ticks(count).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(labels(&Axis::between("x", "m", -1.1, 2.3), 3), ["−1", "0", "1", "2"]);
        assert_eq!(labels(&Axis::between("x", "m", 0.0, 1.0), 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&Axis::between("n", "", 1.0, 3.0).whole(), 8), ["1", "2", "3"]);
        assert_eq!(labels(&Axis::between("g", "", 1.0, 40.0).on(Scale::Log), 5), ["1", "2", "5", "10", "20"]);
        assert_eq!(
            labels(&Axis::between("c", "", 0.0, 3e6).on(Scale::FromZero), 5),
            ["0", "100", "10⁴", "10⁶"]
        );
    }

    #[test]
    fn small_and_large_values_share_a_power_of_ten() {
        let axis = Axis::between("x", "m", 0.0, 2.5e-4);
        assert_eq!((axis.label().as_str(), labels(&axis, 5)[1].as_str()), ("x (10⁻⁶ m)", "50"));
    }

    #[test]
    fn a_constant_has_an_axis_too() {
        for value in [0.0, -3.0, f64::NAN] {
            let axis = Axis::around("x", "m", [value, value]);
            assert!(axis.ends().0 < axis.ends().1 && !axis.ticks(4).is_empty(), "{axis:?}");
        }
    }

    #[test]
    fn numbers_keep_their_digits() {
        assert_eq!(
            [0.12345, -1234.5, 0.0, 1.5e-7].map(|x| digits(x, 3)),
            ["0.123", "−1234", "0.00", "1.50·10⁻⁷"]
        );
    }
}
