//! Headings of columns: the name and the unit, in all common spellings.

use phisindy_phys::unit::Unit;

/// The quantity that a column measures, derived from its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A time.
    Time,
    /// A length or a displacement.
    Length,
    /// An angle.
    Angle,
    /// A velocity.
    Speed,
    /// An angular velocity.
    AngularSpeed,
    /// An acceleration, linear or angular.
    Acceleration,
    /// A force.
    Force,
    /// A torque.
    Torque,
    /// A voltage or a current: the input of a motor, or the output of a sensor.
    Electric,
    /// Counts of an encoder or a converter: of what, the heading does not say.
    Count,
    /// Any other quantity.
    Other,
    /// The heading states no unit.
    Unknown,
}

/// A heading, split into name and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// The text in the file.
    pub raw: String,
    /// The name without the unit, in lower case.
    pub name: String,
    /// The unit as specs spell it; `None` if the heading states none or an unknown one.
    pub unit: Option<String>,
    /// The quantity that the unit measures.
    pub quantity: Quantity,
}

impl Heading {
    /// Reads headings such as `x [mm]`, `Force (kN)`, `t/s`, `theta_rad`, `v_m_per_s`, or a name alone.
    pub fn parse(raw: &str) -> Heading {
        // MATLAB writes `Time (s)` as `Time_s_`.
        let text = raw.trim().trim_end_matches('_');
        // `v_mm/s` is a velocity in mm/s, not `v_mm` in seconds.
        let rate = || suffixed(text).or_else(|| after_blank(text)).filter(|(_, u)| is_quotient(u.as_deref()));
        let split = bracketed(text).or_else(rate).or_else(|| quotient(text));
        let split = split.or_else(|| after_blank(text)).or_else(|| suffixed(text));
        let split = split.or_else(|| acceleration_in_g(text)).or_else(|| unit_of_time(text));
        let (name, unit) = split.unwrap_or((text, None));
        let name = name.trim().trim_end_matches(['_', '-', ',']).to_lowercase();
        let heading = Heading { raw: raw.to_owned(), name, unit, quantity: Quantity::Unknown };
        heading.with_quantity()
    }

    /// Adds the unit of a second heading line, unless the heading states its own.
    pub fn with_unit(mut self, unit: &str) -> Heading {
        if self.unit.is_none() {
            self.unit = normalized(plain_unit(unit));
        }
        self.with_quantity()
    }

    /// Derives the quantity from the unit. An acceleration in `g` or `mg` is not in grams, a velocity in `ms`
    /// is in m/s.
    fn with_quantity(mut self) -> Heading {
        if self.has_word(ACCELERATIONS) {
            match self.unit.as_deref() {
                Some("g") => self.unit = Some("gn".to_owned()),
                Some("mg") => self.unit = Some("mgn".to_owned()),
                _ => {}
            }
        }
        if self.unit.as_deref() == Some("ms") && self.has_word(VELOCITIES) {
            self.unit = Some("m/s".to_owned());
        }
        self.quantity = self.unit.as_deref().map_or(Quantity::Unknown, quantity);
        self
    }

    /// The words of the name without trailing digits: `["x", "mass"]` for `x1_mass2`.
    pub(crate) fn words(&self) -> impl Iterator<Item = &str> {
        let parts = self.name.split(|c: char| !c.is_alphanumeric());
        parts.map(|w| w.trim_end_matches(|c: char| c.is_ascii_digit())).filter(|w| !w.is_empty())
    }

    /// Whether the name is a capital `T`, which is a time or a torque.
    pub(crate) fn is_capital_t(&self) -> bool {
        self.name == "t" && self.raw.trim_start().starts_with('T')
    }

    /// Whether the name contains one of these words.
    pub(crate) fn has_word(&self, words: &[&str]) -> bool {
        self.words().any(|w| words.contains(&w))
    }
}

fn is_quotient(unit: Option<&str>) -> bool {
    unit.is_some_and(|u| u.contains('/'))
}

/// The unit of what is counted.
pub(crate) const COUNT: &str = "count";

/// The factor from a unit to SI; 1 without a known unit.
pub(crate) fn factor(unit: Option<&str>) -> f64 {
    unit.and_then(|u| Unit::parse(u).ok()).map_or(1.0, |u| u.factor)
}

/// Words that name a velocity.
pub(crate) const VELOCITIES: &[&str] = &[
    "v",
    "vel",
    "velocity",
    "speed",
    "dx",
    "dq",
    "dy",
    "dtheta",
    "xdot",
    "qdot",
    "thetadot",
    "dot",
    "omega",
    "w",
    "rate",
    "vx",
    "gyro",
    "gyroscope",
    "gyroskop",
    "geschwindigkeit",
];
/// Words that name an acceleration.
pub(crate) const ACCELERATIONS: &[&str] =
    &["a", "acc", "accel", "acceleration", "beschleunigung", "ax", "ay", "az", "accx", "accy", "accz"];

/// Most bytes of a unit in a heading: each end of a heading of thousands of bytes would be read as a unit
/// otherwise.
const LONGEST_UNIT: usize = 60;

/// A name and its unit.
type Split<'t> = Option<(&'t str, Option<String>)>;

fn bracketed(text: &str) -> Split<'_> {
    let pairs = [('[', ']'), ('(', ')'), ('<', '>'), ('{', '}')];
    let (open, _) = pairs.iter().find(|(_, close)| text.ends_with(*close))?;
    let at = if text.ends_with("))") { text.find(*open)? } else { text.rfind(*open)? };
    if at == 0 {
        return None;
    }
    let name = text[..at].trim().trim_end_matches('/');
    // Text in brackets does not belong to the name, even if it is no known unit.
    Some((name, normalized(&text[at + 1..text.len() - 1])))
}

fn quotient(text: &str) -> Split<'_> {
    let at = text.find('/')?;
    let unit = text[at + 1..].trim();
    let unit = unit.strip_prefix('(').and_then(|u| u.strip_suffix(')')).unwrap_or(unit);
    Some((&text[..at], Some(normalized(unit)?)))
}

fn after_blank(text: &str) -> Split<'_> {
    [" in ", ", ", " "].iter().find_map(|between| {
        let at = text.rfind(between)?;
        Some((&text[..at], Some(bare_unit(&text[at + between.len()..])?)))
    })
}

fn suffixed(text: &str) -> Split<'_> {
    let may_be = |at: usize| at > 0 && text.len() - at <= LONGEST_UNIT;
    text.match_indices('_').filter(|(at, _)| may_be(*at)).find_map(|(at, _)| {
        let tail = text[at + 1..].replace("_per_", "/");
        let unit = bare_unit(&tail).or_else(|| bare_unit(&tail.replace('_', "/")))?;
        Some((&text[..at], Some(unit)))
    })
}

/// `acc_g`: only for accelerations is a final `g` a unit.
fn acceleration_in_g(text: &str) -> Split<'_> {
    let name = text.strip_suffix("_g").or_else(|| text.strip_suffix(" g"))?;
    let first = name.split(|c: char| !c.is_alphabetic()).next().unwrap_or_default().to_lowercase();
    ACCELERATIONS.contains(&first.as_str()).then(|| (name, Some("g".to_owned())))
}

/// A heading that is a unit of time and nothing else: `ms`, `seconds`, `millis`. (`s` may be a distance, `t`
/// and `h` are names.)
fn unit_of_time(text: &str) -> Split<'_> {
    let unit = normalized(text).filter(|unit| quantity(unit) == Quantity::Time && text.len() > 1)?;
    (!matches!(text, "min" | "yr")).then_some((text, Some(unit)))
}

/// A unit that needs no brackets. `x_t` is not in tonnes, and `u_h` is not in hours.
fn bare_unit(text: &str) -> Option<String> {
    let unit = normalized(text)?;
    let known = quantity(&unit) != Quantity::Other
        || matches!(unit.as_str(), "kg" | "K" | "Pa" | "kPa" | "MPa" | "bar" | "mbar" | "psi" | "Hz" | "W");
    let is_name = matches!(text, "t" | "d" | "h" | "min" | "rev" | "turn" | "turns" | "in" | "1");
    (known && !is_name).then_some(unit)
}

/// Other spellings of a unit, in lower case, and the one of specs.
const SPELLINGS: &[(&[&str], &str)] = &[
    (&["sec", "secs", "second", "seconds", "sek", "sekunde", "sekunden"], "s"),
    (&["msec", "msecs", "millis", "millisecond", "milliseconds", "millisekunden"], "ms"),
    (&["usec", "usecs", "µsec", "μsec", "micros", "microsecond", "microseconds", "mikrosekunden"], "us"),
    (&["nsec", "nsecs", "nanos", "nanosecond", "nanoseconds", "nanosekunden"], "ns"),
    (&["meter", "metre", "meters", "metres"], "m"),
    (&["millimeter", "millimetre", "millimeters", "millimetres"], "mm"),
    (&["centimeter", "centimetre", "centimeters", "centimetres"], "cm"),
    (&["micron", "microns", "micrometer", "micrometre"], "um"),
    (&["inch", "inches", "\""], "in"),
    (&["feet", "foot"], "ft"),
    (&["lbs"], "lbf"),
    (&["kp"], "kgf"),
    (&["newton", "newtons"], "N"),
    (&["kilonewton"], "kN"),
    (&["newtonmeter", "n.m", "n m", "n-m"], "N*m"),
    (&["volt", "volts"], "V"),
    (&["ampere", "amperes", "amp", "amps"], "A"),
    (&["milliampere", "milliamps"], "mA"),
    (&["degree", "degrees", "degs", "grad"], "deg"),
    (&["radian", "radians", "rads"], "rad"),
    (&["turns", "revs", "revolution", "revolutions", "umdr", "umdrehung", "umdrehungen"], "rev"),
    (&["u/min", "1/min", "r/min", "rev/min", "min-1", "min^-1"], "rpm"),
    (
        &[
            "counts",
            "cnt",
            "cnts",
            "cts",
            "tick",
            "ticks",
            "pulse",
            "pulses",
            "impulse",
            "impulses",
            "inkrement",
            "inkremente",
            "increment",
            "increments",
            "incr",
            "inkr",
            "lsb",
            "digit",
            "digits",
        ],
        "count",
    ),
    (&["m/s/s"], "m/s^2"),
    (&["dps"], "deg/s"),
];
/// Spellings that differ from a unit of another kind by their case alone: `nm` is a nanometre.
const EXACT_SPELLINGS: &[(&str, &str)] =
    &[("Nm", "N*m"), ("Ncm", "N*cm"), ("Nmm", "N*mm"), ("kNm", "kN*m"), ("mNm", "mN*m")];

/// The spelling of specs of a unit without powers and quotients; the text itself if there is none.
fn spelling(text: &str) -> &str {
    let lower = text.to_lowercase();
    let exact = EXACT_SPELLINGS.iter().find(|(own, _)| *own == text).map(|(_, unit)| *unit);
    let any = || SPELLINGS.iter().find(|(all, _)| all.contains(&lower.as_str())).map(|(_, unit)| *unit);
    exact.or_else(any).unwrap_or(text)
}

/// The unit as specs spell it, if it is known.
pub(crate) fn normalized(text: &str) -> Option<String> {
    if text.len() > LONGEST_UNIT {
        return None;
    }
    // Raised digits and words, as specs write them: `s⁻²` is `s^-2`.
    const PLAIN: [(&str, &str); 7] =
        [("²", "^2"), ("³", "^3"), ("⁻¹", "^-1"), ("⁻^", "^-"), ("**", "^"), ("·", "*"), (" per ", "/")];
    let mut text = PLAIN.iter().fold(text.trim().to_owned(), |text, (from, to)| text.replace(from, to));
    // Where powers stand a blank multiplies: `rad s^-1`, `m s-2`.
    if text.contains(['^', '-']) {
        let parts: Vec<String> = text.split_whitespace().map(negative_power).collect();
        text = parts.join("*");
    }
    let word = match spelling(&text) {
        // `rad/sec`: each part has a spelling of its own.
        same if same == text && text.contains('/') => {
            text.split('/').map(|part| powers(spelling(part.trim()))).collect::<Vec<_>>().join("/")
        }
        other => powers(other),
    };
    (!word.is_empty() && !word.starts_with(|c: char| c.is_ascii_digit()) && Unit::parse(&word).is_ok())
        .then_some(word)
}

/// `s-1` is `s^-1`.
fn negative_power(word: &str) -> String {
    match word.split_once('-') {
        Some((unit, power))
            if unit.chars().all(char::is_alphabetic)
                && !unit.is_empty()
                && matches!(power, "1" | "2" | "3") =>
        {
            format!("{unit}^-{power}")
        }
        _ => word.to_owned(),
    }
}

/// `s2` is `s^2`, and `sec^2` is it too.
fn powers(word: &str) -> String {
    if let Some((front, power)) = word.split_once('^') {
        return format!("{}^{power}", spelling(front));
    }
    match word.strip_suffix(['2', '3']) {
        Some(front) if front.ends_with(|c: char| c.is_alphabetic()) => {
            format!("{}^{}", spelling(front), &word[front.len()..])
        }
        _ => word.to_owned(),
    }
}

/// Words that stand in the place of a unit in a second heading line, beside units that are known.
const OTHER_UNITS: &[&str] =
    &["°c", "degc", "deg c", "a.u.", "au", "raw", "bool", "n/a", "none", "nodim", "unitless", "-", "--"];

/// Whether a text is a unit as a second heading line has it: `mm`, `[mm]`, `Nm`; `false` for a number.
pub(crate) fn is_unit(text: &str) -> bool {
    normalized(plain_unit(text)).is_some()
}

/// Whether a text that may be a unit is a name over its unit, as in `t / ms`: as a unit it measures nothing known.
pub(crate) fn is_name_over_unit(text: &str) -> bool {
    let as_unit = normalized(plain_unit(text)).map(|unit| quantity(&unit));
    let measures = |q: Quantity| !matches!(q, Quantity::Unknown | Quantity::Other);
    text.contains('/') && !as_unit.is_some_and(measures) && measures(Heading::parse(text).quantity)
}

/// Whether a text may stand beside units in a second heading line: empty brackets, temperatures.
pub(crate) fn is_beside_units(text: &str) -> bool {
    let plain = plain_unit(text);
    plain.is_empty() || OTHER_UNITS.contains(&plain.to_lowercase().as_str())
}

/// A unit without the brackets around it, and without the word `Unit:` before it.
fn plain_unit(text: &str) -> &str {
    let text = text.trim_start();
    let label = text.get(..5).filter(|label| label.eq_ignore_ascii_case("unit:")).map_or(0, str::len);
    text[label..].trim_matches(['[', ']', '(', ')', '<', '>', '{', '}', ' '])
}

/// The quantity that a unit measures.
fn quantity(unit: &str) -> Quantity {
    let dimension = |text: &str| Unit::parse(text).map(|u| u.dimension).ok();
    let own = dimension(unit);
    let angle = ["rad", "deg", "°", "rev", "turn"].iter().any(|a| unit.contains(a));
    let same = |text: &str| own.is_some() && own == dimension(text);
    match () {
        () if same("s") => Quantity::Time,
        () if same("m") => Quantity::Length,
        () if same("m/s") => Quantity::Speed,
        () if same("m/s^2") => Quantity::Acceleration,
        () if same("N") => Quantity::Force,
        () if same("N*m") => Quantity::Torque,
        () if same("V") || same("A") => Quantity::Electric,
        () if unit == COUNT => Quantity::Count,
        () if angle && same("") => Quantity::Angle,
        () if (angle || unit == "rpm") && same("1/s") => Quantity::AngularSpeed,
        () if angle && same("1/s^2") => Quantity::Acceleration,
        () => Quantity::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Found by the fuzz target `format`: every end of it was read as a unit, which took a second for 400
    /// bytes.
    #[test]
    fn a_heading_of_thousands_of_bytes_is_read_at_once() {
        let heading = Heading::parse(&"KA_".repeat(10_000));
        assert_eq!((heading.unit, heading.quantity), (None, Quantity::Unknown));
    }

    #[test]
    fn units_stand_in_many_forms() {
        for (raw, name, unit, kind) in [
            ("time_s", "time", Some("s"), Quantity::Time),
            ("t/s", "t", Some("s"), Quantity::Time),
            ("Time (sec)", "time", Some("s"), Quantity::Time),
            ("x_mass_m", "x_mass", Some("m"), Quantity::Length),
            ("x [mm]", "x", Some("mm"), Quantity::Length),
            ("x[µm]", "x", Some("µm"), Quantity::Length),
            ("x in mm", "x", Some("mm"), Quantity::Length),
            ("Force (kN)", "force", Some("kN"), Quantity::Force),
            ("F_motor_N", "f_motor", Some("N"), Quantity::Force),
            ("M [Nm]", "m", Some("N*m"), Quantity::Torque),
            ("theta_rad", "theta", Some("rad"), Quantity::Angle),
            ("phi (°)", "phi", Some("°"), Quantity::Angle),
            ("thetadot_online_rad_per_s", "thetadot_online", Some("rad/s"), Quantity::AngularSpeed),
            ("v/(m/s)", "v", Some("m/s"), Quantity::Speed),
            ("v_m_s", "v", Some("m/s"), Quantity::Speed),
            ("v_mm/s", "v", Some("mm/s"), Quantity::Speed),
            ("v mm/s", "v", Some("mm/s"), Quantity::Speed),
            ("w_rad/s", "w", Some("rad/s"), Quantity::AngularSpeed),
            ("theta_dot_rad/s", "theta_dot", Some("rad/s"), Quantity::AngularSpeed),
            ("acc_m/s^2", "acc", Some("m/s^2"), Quantity::Acceleration),
            ("x_mass/mm", "x_mass", Some("mm"), Quantity::Length),
            ("F_1 / N", "f_1", Some("N"), Quantity::Force),
            ("t / s", "t", Some("s"), Quantity::Time),
            ("t_ms", "t", Some("ms"), Quantity::Time),
            ("v_ms", "v", Some("m/s"), Quantity::Speed),
            ("vel_ms", "vel", Some("m/s"), Quantity::Speed),
            ("a [m/s²]", "a", Some("m/s^2"), Quantity::Acceleration),
            ("acc (m/s2)", "acc", Some("m/s^2"), Quantity::Acceleration),
            ("acc (g)", "acc", Some("gn"), Quantity::Acceleration),
            ("a_g", "a", Some("gn"), Quantity::Acceleration),
            ("a_x [mg]", "a_x", Some("mgn"), Quantity::Acceleration),
            ("load (g)", "load", Some("g"), Quantity::Other),
            ("disp (in)", "disp", Some("in"), Quantity::Length),
            ("x_inch", "x", Some("in"), Quantity::Length),
            ("u_in", "u_in", None, Quantity::Unknown),
            ("u_V", "u", Some("V"), Quantity::Electric),
            ("q_ref_m", "q_ref", Some("m"), Quantity::Length),
            ("load_raw", "load_raw", None, Quantity::Unknown),
            ("x_t", "x_t", None, Quantity::Unknown),
            ("x_d", "x_d", None, Quantity::Unknown),
            ("Zeit [d]", "zeit", Some("d"), Quantity::Time),
            ("x", "x", None, Quantity::Unknown),
            ("m", "m", None, Quantity::Unknown),
            ("s", "s", None, Quantity::Unknown),
            ("ms", "ms", Some("ms"), Quantity::Time),
            ("µs", "µs", Some("µs"), Quantity::Time),
            ("millis", "millis", Some("ms"), Quantity::Time),
            ("seconds", "seconds", Some("s"), Quantity::Time),
            ("x (furlong)", "x", None, Quantity::Unknown),
            ("torque_enabled", "torque_enabled", None, Quantity::Unknown),
            ("T_Nm", "t", Some("N*m"), Quantity::Torque),
            ("M_mNm", "m", Some("mN*m"), Quantity::Torque),
            ("Moment [Ncm]", "moment", Some("N*cm"), Quantity::Torque),
            ("tau_in", "tau_in", None, Quantity::Unknown),
            ("voltage", "voltage", None, Quantity::Unknown),
            ("i_A", "i", Some("A"), Quantity::Electric),
            ("i_meas_A", "i_meas", Some("A"), Quantity::Electric),
            ("enc_cnt", "enc", Some("count"), Quantity::Count),
            ("Geber (Inkremente)", "geber", Some("count"), Quantity::Count),
            ("motor_ticks", "motor", Some("count"), Quantity::Count),
            ("phi [rev/4096]", "phi", Some("rev/4096"), Quantity::Angle),
            ("Winkel [Umdr]", "winkel", Some("rev"), Quantity::Angle),
            ("n (U/min)", "n", Some("rpm"), Quantity::AngularSpeed),
            ("gyro_dps", "gyro", Some("deg/s"), Quantity::AngularSpeed),
            ("omega [rad/sec]", "omega", Some("rad/s"), Quantity::AngularSpeed),
            ("a [mm/sec^2]", "a", Some("mm/s^2"), Quantity::Acceleration),
            ("w [rad·s⁻¹]", "w", Some("rad*s^-1"), Quantity::AngularSpeed),
            ("p_psi", "p", Some("psi"), Quantity::Other),
            ("timestamp_us", "timestamp", Some("us"), Quantity::Time),
            ("time (μsec)", "time", Some("us"), Quantity::Time),
            ("stamp_nsec", "stamp", Some("ns"), Quantity::Time),
            ("w_x [rad s^-1]", "w_x", Some("rad*s^-1"), Quantity::AngularSpeed),
            ("a (m s-2)", "a", Some("m*s^-2"), Quantity::Acceleration),
            ("n [min-1]", "n", Some("rpm"), Quantity::AngularSpeed),
            ("Angle_deg_", "angle", Some("deg"), Quantity::Angle),
            ("Velocity_m_s_", "velocity", Some("m/s"), Quantity::Speed),
        ] {
            let h = Heading::parse(raw);
            assert_eq!((h.name.as_str(), h.unit.as_deref(), h.quantity), (name, unit, kind), "{raw}");
        }
    }

    #[test]
    fn a_second_heading_line_gives_units() {
        let h = Heading::parse("Weg").with_unit("[mm]");
        assert_eq!((h.unit.as_deref(), h.quantity), (Some("mm"), Quantity::Length));
        assert_eq!(Heading::parse("x_m").with_unit("mm").unit.as_deref(), Some("m"));
    }

    #[test]
    fn words_lose_their_numbers() {
        let h = Heading::parse("x1_Laser 2 [mm]");
        assert_eq!(h.words().collect::<Vec<_>>(), ["x", "laser"]);
    }
}
