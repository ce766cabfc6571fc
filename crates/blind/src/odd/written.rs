//! A rig as a spec and a data file, as odd as the reference allows.

use super::rig::Rig;
use crate::dice::Dice;
use std::fmt::Write;

pub(super) const SPEC: &str = "odd.ron";
pub(super) const DATA: &str = "odd.csv";

/// Units of lengths, and how many metres they are.
const LENGTHS: &[(&str, f64)] =
    &[("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2), ("km", 1e3), ("in", 0.0254), ("ft", 0.3048)];
/// Units of times, and how many seconds they are.
const TIMES: &[(&str, f64)] = &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0), ("h", 3600.0)];
/// Names of a displacement, its velocity and a stiffness.
const NAMES: &[[&str; 3]] = &[
    ["x", "v", "k"],
    ["ξ", "ξ_t", "ω"],
    ["Weg", "Geschwindigkeit", "Härte"],
    ["e", "E", "e1"],
    ["_", "__", "___"],
    ["T", "tt", "pi_"],
    ["sgnx", "lnx", "maximum"],
    ["a_name_that_goes_on_and_on_and_on_until_nobody_reads_it_any_more", "v1", "k1"],
];

/// Files, and how to read a number back from them.
pub(super) struct Written {
    pub(super) files: Vec<(String, Vec<u8>)>,
    names: &'static [&'static str; 3],
    unknown: String,
}

impl Written {
    /// The spec of a rig: its record is `synthetic` or in a data file, its friction unknown with a `dictionary` or known.
    pub(super) fn new(rig: &Rig, synthetic: bool, dictionary: bool, dice: &mut Dice) -> Written {
        let names = dice.pick(NAMES);
        let length = *dice.pick(LENGTHS);
        let [x, v, k] = names;
        let spring = dice
            .pick(&[
                "-K*X",
                "-(K*X)",
                "-X*K",
                "-(((K)))*X",
                "0 - K*X",
                "-K*X^1",
                "K*(-X)",
                "-(K*X + K*X)/2",
                "-K*X*1.0e0",
                "-K * ( X ) + 0",
            ])
            .replace('K', "\0")
            .replace('X', x)
            .replace('\0', k);
        let speed = format!("{}/s", length.0);
        let stiffness = rig.frequency * rig.frequency;
        let mut constants = vec![format!("\"{k}\": ({stiffness:?}, \"1/s^2\")")];
        if dice.chance(0.3) {
            constants.push("\"nobody_asks_for_it\": (1e-300, \"kg\")".to_owned());
        }
        let friction = format!("{:?}*sgn({v})", rig.friction);
        let truth = format!("\"{v}\": \"-{friction}\"");
        let (rate, truth) = match dice.chance(0.5) {
            true if !dictionary => (format!("{spring} - {friction}"), String::new()),
            _ => (spring, truth),
        };
        let more = dice.pick(&["", ", \"|V|\"", ", \"V^2\", \"|X|\""]).replace('V', v).replace('X', x);
        let unknown = format!("unknown: {{ \"{v}\": (factor: \"-sgn({v})\", candidates: [\"1\"{more}]) }}");
        let (file, read) = table(rig, names, dice);
        let record = if synthetic {
            let start = format!("start: {{ \"{x}\": {:?}, \"{v}\": 0.0 }}", rig.size / length.1);
            let times = format!("duration: {:?}, step: {:?}", rig.step * rig.samples as f64, rig.step);
            format!("Synthetic(truth: {{ {truth} }}, {start}, {times})")
        } else {
            read
        };
        let mut fields = vec![
            format!("states: {{ \"{x}\": \"{}\", \"{v}\": \"{speed}\" }}", length.0),
            format!("constants: {{ {} }}", constants.join(", ")),
            format!("known: {{ \"{x}\": \"{v}\", \"{v}\": \"{rate}\" }}"),
            format!("contacts: [\"{v}\"]"),
            format!("data: [{record}]"),
        ];
        if dictionary {
            fields.push(unknown.clone());
        }
        if dice.chance(0.5) {
            fields.push(format!(
                "title: \"{}\"",
                dice.pick(&[
                    "",
                    "a \\\"quoted\\\" one",
                    "Ünïcode \\u{1F600}",
                    "// no comment",
                    "$x^2$ <b>&amp;"
                ])
            ));
        }
        for place in (1..fields.len()).rev() {
            fields.swap(place, dice.whole(0, place));
        }
        let gap = dice.pick(&[", ", ",\n    ", ",\r\n", ", /* \" ( */ ", ", // }\n"]);
        let spec = format!(
            "{}(\n{}{}\n)\n",
            dice.pick(&["", "\u{feff}", "// a comment\n", "\n\n"]),
            fields.join(gap),
            dice.pick(&["", ","])
        );
        let files = vec![(SPEC.to_owned(), spec.into_bytes()), (DATA.to_owned(), file)];
        Written { files, names, unknown }
    }

    /// Takes the dictionary out of the spec: the model is believed to be complete.
    pub(super) fn believed_complete(&mut self) {
        let spec = &mut self.files[0].1;
        *spec = String::from_utf8_lossy(spec).replace(&self.unknown, "learn: ()").into_bytes();
    }

    /// What is wrong about simulated columns, which are in SI, if anything is.
    pub(super) fn simulated(&self, rig: &Rig, out: &str) -> Option<String> {
        let mut lines = out.lines();
        let heads: Vec<&str> = lines.next()?.split(',').collect();
        let column = heads.iter().position(|head| head.starts_with(self.names[0]))?;
        let mut worst = 0.0_f64;
        for (k, line) in lines.enumerate() {
            let Some(shown) = line.split(',').nth(column).and_then(|cell| cell.parse::<f64>().ok()) else {
                return Some(format!("no number in row {k}: {line}"));
            };
            let exact = rig.at(rig.step * k as f64).0;
            worst = worst.max((shown - exact).abs() / rig.size.abs());
        }
        (worst > 1e-6).then(|| format!("simulated motion is off by {worst:e} of its size"))
    }
}

/// A text of times and readings, and the record that reads it.
fn table(rig: &Rig, names: &[&str; 3], dice: &mut Dice) -> (Vec<u8>, String) {
    let time = *dice.pick(TIMES);
    let read = *dice.pick(LENGTHS);
    let velocities = dice.chance(0.4);
    let (separator, comma) =
        *dice.pick(&[(",", false), (";", false), (";", true), ("\t", false), ("\t", true), (" ", false)]);
    let digits = dice.whole(5, 9);
    let end = dice.pick(&["\n", "\r\n"]);
    let text = |x: f64| {
        let text = format!("{x:.digits$e}");
        if comma { text.replace('.', ",") } else { text }
    };
    let offset = *dice.pick(&[0.0, 0.0, 12.5, -3.0, 1e3]) * rig.step;
    let heads = if separator == " " {
        ["t", "x", "v", "n"]
    } else {
        *dice.pick(&[
            ["t", "x", "v", "n"],
            ["Zeit", "Weg [mm]", "Tempo", "№"],
            ["time", "Größe", "dx/dt", "#"],
        ])
    };
    let extra = dice.chance(0.3);
    let mut out = String::new();
    let skip = dice.whole(0, 2) * usize::from(dice.chance(0.3));
    (0..skip).for_each(|_| out += &format!("measured by nobody{end}"));
    let mut cells: Vec<String> = heads[..2].iter().map(|h| (*h).to_owned()).collect();
    if velocities {
        cells.push(heads[2].to_owned());
    }
    if extra {
        cells.push(heads[3].to_owned());
    }
    out += &(cells.join(separator) + end);
    let omit = dice.chance(0.2);
    for k in 0..rig.samples {
        let t = rig.step * k as f64;
        let (x, v) = rig.at(t);
        let reading = |x: f64| if omit && k % 37 == 11 { "NaN".to_owned() } else { text(x / read.1) };
        let mut cells = vec![text((t + offset) / time.1), reading(x)];
        if velocities {
            cells.push(text(v / read.1));
        }
        if extra {
            cells.push(k.to_string());
        }
        out += &(cells.join(separator) + end);
    }
    if dice.chance(0.2) {
        out.truncate(out.trim_end().len());
    }
    let mut record = format!(
        "{}(path: \"{DATA}\", time: (\"{}\", \"{}\"), columns: {{ \"{}\": (\"{}\", \"{}\")",
        dice.pick(&["Csv", "Table"]),
        heads[0],
        time.0,
        names[0],
        heads[1],
        read.0
    );
    if velocities {
        let _ = write!(record, ", \"{}\": (\"{}\", \"{}/s\")", names[1], heads[2], read.0);
    }
    record += " }";
    if skip > 0 {
        let _ = write!(record, ", skip: {skip}");
    }
    if omit {
        record += ", missing: Omit";
    }
    if dice.chance(0.3) {
        let _ = write!(record, ", separator: '{}'", separator.replace('\t', "\\t"));
    }
    if dice.chance(0.3) {
        let _ = write!(record, ", decimal: '{}'", if comma { ',' } else { '.' });
    }
    let bytes = match dice.whole(0, 3) {
        0 => [b"\xef\xbb\xbf".to_vec(), out.into_bytes()].concat(),
        1 => [b"\xff\xfe".to_vec(), out.encode_utf16().flat_map(u16::to_le_bytes).collect()].concat(),
        _ => out.into_bytes(),
    };
    (bytes, record + ")")
}

/// A law that nobody thought of, with units that fit and no parameter that does nothing.
pub(super) fn law(dice: &mut Dice) -> String {
    let force = shape(dice, 3);
    let scales =
        [("b", "/b", "m/s"), ("c", "/c", "m")].into_iter().filter(|(_, used, _)| force.contains(used));
    let (mut parameters, mut sketch) =
        ("\"A\": (unit: \"N\", within: (-1e9, 1e9))".to_owned(), "\"A\": 1.0".to_owned());
    for (name, _, unit) in scales {
        let _ = write!(parameters, ", \"{name}\": (unit: \"{unit}\", within: (1e-6, 1e6))");
        let _ = write!(sketch, ", \"{name}\": 0.3");
    }
    format!(
        "(name: \"odd law\", about: \"Drawn by dice.\", reference: \"none\", roles: {{ \"x\": \"m\", \"v\": \"m/s\" }},\n\
         parameters: {{ {parameters} }},\nforce: \"A*({force})\", sketch: (over: \"v\", with: {{ {sketch} }}))\n"
    )
}

/// A number without a unit, made of displacement and velocity.
fn shape(dice: &mut Dice, depth: usize) -> String {
    if depth == 0 {
        return (*dice.pick(&["v/b", "x/c", "v/b", "1", "0.5"])).to_owned();
    }
    let form = *dice.pick(&[
        "sgn(L)",
        "tanh(L)",
        "abs(L)",
        "exp(-abs(L))",
        "sin(L)",
        "L*R",
        "L + R",
        "L - R",
        "L/(1 + abs(R))",
        "L^2",
        "L^3",
        "max(L, R)",
        "min(L, R)",
        "pos(L)",
        "step(L)*R",
        "dead(L, 0.5)",
        "atan(L)",
        "sqrt(abs(L))",
        "ln(1 + abs(L))",
        "1/(L)",
    ]);
    form.replace('L', &format!("({})", shape(dice, depth - 1)))
        .replace('R', &format!("({})", shape(dice, depth - 1)))
}
