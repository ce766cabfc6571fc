//! Random rigs: one to five masses on springs, dampers and drives, with laws of the catalogue between them.
//! Their forces stand here twice: as the text of the catalogue for the program, and as arithmetic for who
//! checks it.
#![allow(dead_code, unreachable_pub, missing_docs)]

use phisindy_phys::Law;

/// A small generator of uniform numbers, the same on every machine.
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Dice {
        // Neighbouring seeds must not give neighbouring numbers.
        let mut dice = Dice(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0xd1b5_4a32_d192_ed03);
        (0..8).for_each(|_| {
            dice.unit();
        });
        dice
    }

    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Three digits: short texts.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        ((low + (high - low) * self.unit()) * 1e3).round() / 1e3
    }

    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + (self.unit() * (high - low + 1) as f64) as usize
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }
}

/// Between a body and another one, or the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    pub body: usize,
    pub other: Option<usize>,
}

impl Place {
    /// The difference of a quantity of the two.
    pub fn relative(&self, of: &[f64]) -> f64 {
        of[self.body] - self.other.map_or(0.0, |j| of[j])
    }

    /// The same in names.
    pub fn named(&self, letter: &str) -> String {
        let one = |i: usize| format!("{letter}{}", i + 1);
        self.other.map_or(one(self.body), |j| format!("{} - {}", one(self.body), one(j)))
    }

    /// The sign with which a force that is subtracted acts on a body.
    pub fn sign(&self, body: usize) -> f64 {
        if self.body == body {
            -1.0
        } else if self.other == Some(body) {
            1.0
        } else {
            0.0
        }
    }
}

/// A law of the catalogue at a place, with its numbers.
#[derive(Clone, Debug)]
pub struct Acting {
    pub id: &'static str,
    pub place: Place,
    pub numbers: Vec<(&'static str, f64)>,
    /// Which internal state is its own.
    pub internal: Option<usize>,
}

/// Laws that can hold a body.
pub const HOLDING: &[&str] =
    &["coulomb", "asymmetric-coulomb", "stribeck", "dieterich-ruina", "position-dependent-friction"];
const OTHERS: &[&str] = &[
    "viscous",
    "stiffness",
    "quadratic-drag",
    "cubic-stiffness",
    "quadratic-stiffness",
    "dead-zone",
    "one-sided-stop",
    "offset",
    "harmonic-force",
    "parametric-stiffness",
    "van-der-pol",
    "presliding",
];

impl Acting {
    pub fn number(&self, name: &str) -> f64 {
        self.numbers.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("{name} of {}", self.id)).1
    }

    pub fn holds(&self) -> bool {
        HOLDING.contains(&self.id)
    }

    /// The force that is subtracted, by hand: at displacement `x`, velocity `v` whose sign is `s`, internal
    /// state `z`.
    pub fn force(&self, t: f64, x: f64, v: f64, s: f64, z: f64) -> f64 {
        let p = |name: &str| self.number(name);
        match self.id {
            "viscous" => p("dc") * v,
            "stiffness" => p("dk") * x,
            "quadratic-drag" => p("d") * v * v.abs(),
            "cubic-stiffness" => p("k3") * x * x * x,
            "quadratic-stiffness" => p("k2") * x * x,
            "dead-zone" => {
                let gap = p("gap");
                p("ks")
                    * if x > gap {
                        -gap
                    } else if x < -gap {
                        gap
                    } else {
                        -x
                    }
            }
            "one-sided-stop" => p("ks") * (x - p("gap")).max(0.0),
            "offset" => -p("f0"),
            "harmonic-force" => -p("A") * (p("w") * t + p("phase")).cos(),
            "parametric-stiffness" => p("e") * (p("w") * t + p("phase")).cos() * x,
            "van-der-pol" => -p("mu") * (1.0 - p("a") * x * x) * v,
            "presliding" => p("kt") * z,
            "asymmetric-coulomb" => {
                if s > 0.0 {
                    p("Fp")
                } else {
                    -p("Fm")
                }
            }
            _ => s * self.level(x, v.abs()),
        }
    }

    /// The size of a friction at a displacement and a speed.
    fn level(&self, x: f64, speed: f64) -> f64 {
        let p = |name: &str| self.number(name);
        match self.id {
            "coulomb" => p("Fc"),
            "stribeck" => p("Fc") + (p("Fs") - p("Fc")) * (-(speed / p("vs")).powi(2)).exp(),
            "position-dependent-friction" => p("F0") + p("F1") * x + p("F2") * x * x,
            "dieterich-ruina" => {
                let v = speed + 1e-6;
                p("F") + p("a") * (v / 0.003).ln() + p("b") * (0.022 + 0.003 / v).ln()
            }
            other => panic!("{other} is no friction"),
        }
    }

    /// What it holds at rest, downwards and upwards: the largest one-sided friction at speeds up to a
    /// millionth.
    pub fn hold(&self, x: f64) -> (f64, f64) {
        if self.id == "asymmetric-coulomb" {
            return (-self.number("Fm"), self.number("Fp"));
        }
        let speeds = (0..=20).map(|k| 1e-6 * f64::from(k) / 20.0);
        let most = speeds.map(|v| self.level(x, v)).fold(f64::NEG_INFINITY, f64::max);
        (-most, most)
    }

    /// The force and the rate of its internal state in the catalogue's words.
    pub fn written(&self) -> (String, Option<String>) {
        let path = format!("{}/../phys/laws/{}.ron", env!("CARGO_MANIFEST_DIR"), self.id);
        let law = Law::read(&std::fs::read_to_string(path).unwrap()).unwrap();
        let given = law.given.iter().map(|(n, (x, _))| (n.as_str(), format!("({x:e})")));
        let own = self.numbers.iter().map(|(n, x)| (*n, format!("({x:e})")));
        let mut with: Vec<(&str, String)> = given.chain(own).collect();
        with.push(("x", format!("({})", self.place.named("x"))));
        with.push(("v", format!("({})", self.place.named("v"))));
        with.push(("z", self.internal.map_or(String::new(), |k| format!("z{}", k + 1))));
        let rate = law.internal.first().map(|(_, i)| substituted(&i.rate, &with));
        (substituted(&law.subtracted(false).unwrap(), &with), rate)
    }
}

/// Whole names replaced, all at once.
fn substituted(text: &str, with: &[(&str, String)]) -> String {
    let (mut out, mut word) = (String::new(), String::new());
    for c in text.chars().chain(['\n']) {
        if c.is_alphanumeric() || c == '_' {
            word.push(c);
            continue;
        }
        match with.iter().find(|(name, _)| *name == word) {
            Some((_, text)) => out.push_str(text),
            None => out.push_str(&word),
        }
        word.clear();
        out.push(c);
    }
    out.trim_end().to_owned()
}

/// A rig.
#[derive(Clone, Debug)]
pub struct Rig {
    pub mass: Vec<f64>,
    /// Place, stiffness, damping.
    pub springs: Vec<(Place, f64, f64)>,
    pub laws: Vec<Acting>,
    /// Amplitude, frequency, phase of the forces on one body.
    pub drive: (usize, Vec<[f64; 3]>),
    pub start: Vec<f64>,
    pub duration: f64,
}

impl Rig {
    pub fn draw(dice: &mut Dice) -> Rig {
        let n = dice.whole(1, 5);
        let mass: Vec<f64> = (0..n).map(|_| dice.between(0.5, 2.0)).collect();
        let mut springs = Vec::new();
        let mut places = Vec::new();
        for body in 0..n {
            let ground = Place { body, other: None };
            places.push(ground);
            if body == 0 || dice.chance(0.35) {
                springs.push((ground, dice.between(0.5, 3.0), dice.between(0.0, 0.2)));
            }
            if body > 0 {
                let between = Place { body: body - 1, other: Some(body) };
                places.push(between);
                springs.push((between, dice.between(0.5, 3.0), dice.between(0.0, 0.2)));
            }
        }
        let mut laws: Vec<Acting> = Vec::new();
        // Contacts that held each other in a ring would share their load in any way.
        let mut joined: Vec<usize> = (0..=n).collect();
        let mut internal = 0;
        for _ in 0..dice.whole(1, n + 1) {
            let place = places[dice.whole(0, places.len() - 1)];
            let holds = dice.chance(0.6);
            let id = if holds {
                HOLDING[dice.whole(0, HOLDING.len() - 1)]
            } else {
                OTHERS[dice.whole(0, OTHERS.len() - 1)]
            };
            if holds {
                let (a, b) = (joined[place.body + 1], joined[place.other.map_or(0, |j| j + 1)]);
                if a == b {
                    continue;
                }
                joined.iter_mut().for_each(|j| *j = if *j == a { b } else { *j });
            }
            let spring = springs.iter().find(|(p, ..)| *p == place).map(|s| s.1);
            let Some(numbers) = numbers(id, spring, dice) else { continue };
            let own = (id == "presliding").then_some(internal);
            internal += usize::from(own.is_some());
            laws.push(Acting { id, place, numbers, internal: own });
        }
        let lines = dice.whole(0, 3);
        let line =
            |dice: &mut Dice| [dice.between(0.3, 1.5), dice.between(0.2, 2.0), dice.between(-3.0, 3.0)];
        let drive = (dice.whole(0, n - 1), (0..lines).map(|_| line(dice)).collect());
        let reach = if lines == 0 { 2.0 } else { 0.5 };
        let mut start: Vec<f64> = (0..n).map(|_| dice.between(-reach, reach)).collect();
        // Half of them start at rest: there the contact rule speaks at once.
        let moves = dice.chance(0.5);
        start.extend((0..n).map(|_| if moves { dice.between(-reach, reach) } else { 0.0 }));
        start.extend((0..internal).map(|_| 0.0));
        Rig { mass, springs, laws, drive, start, duration: 30.0 }
    }

    pub fn count(&self) -> usize {
        self.mass.len()
    }

    /// Names of all states.
    pub fn names(&self) -> Vec<String> {
        let n = self.count();
        let numbered = |letter: &str, k: usize| format!("{letter}{}", k + 1);
        let (x, v) = ((0..n).map(|i| numbered("x", i)), (0..n).map(|i| numbered("v", i)));
        x.chain(v).chain((0..self.start.len() - 2 * n).map(|i| numbered("z", i))).collect()
    }

    /// The rates of all states, without some of the laws.
    pub fn rates(&self, without: &dyn Fn(usize) -> bool) -> Vec<String> {
        let n = self.count();
        let mut sums: Vec<String> = vec![String::new(); n];
        let mut act = |place: &Place, force: &str| {
            sums[place.body] += &format!(" - ({force})");
            if let Some(other) = place.other {
                sums[other] += &format!(" + ({force})");
            }
        };
        for (place, k, c) in &self.springs {
            act(place, &format!("{k}*({}) + {c}*({})", place.named("x"), place.named("v")));
        }
        let mut internal = Vec::new();
        for law in self.laws.iter().enumerate().filter(|(k, _)| !without(*k)).map(|(_, l)| l) {
            let (force, rate) = law.written();
            act(&law.place, &force);
            internal.extend(rate);
        }
        for [a, w, p] in &self.drive.1 {
            sums[self.drive.0] += &format!(" + {a}*cos({w}*t + ({p}))");
        }
        let over = |(sum, m): (String, &f64)| format!("(0{sum})/{m}");
        let rates = sums.into_iter().zip(&self.mass).map(over);
        (0..n).map(|i| format!("v{}", i + 1)).chain(rates).chain(internal).collect()
    }

    /// The force of the drive, by hand.
    pub fn push(&self, t: f64) -> f64 {
        self.drive.1.iter().map(|[a, w, p]| a * (w * t + p).cos()).sum()
    }

    /// Kinetic energy and that of the springs.
    pub fn energy(&self, state: &[f64]) -> f64 {
        let n = self.count();
        let (x, v) = (&state[..n], &state[n..2 * n]);
        let kinetic: f64 = self.mass.iter().zip(v).map(|(m, v)| 0.5 * m * v * v).sum();
        kinetic + self.springs.iter().map(|(p, k, _)| 0.5 * k * p.relative(x).powi(2)).sum::<f64>()
    }
}

/// Numbers of a law; `None` if it does not fit the place.
fn numbers(id: &str, spring: Option<f64>, dice: &mut Dice) -> Option<Vec<(&'static str, f64)>> {
    let level = dice.between(0.05, 0.6);
    Some(match id {
        "viscous" => vec![("dc", dice.between(0.02, 0.5))],
        "stiffness" => vec![("dk", dice.between(0.1, 1.0))],
        "quadratic-drag" => vec![("d", dice.between(0.02, 0.5))],
        "cubic-stiffness" => vec![("k3", dice.between(0.05, 1.0))],
        "quadratic-stiffness" => vec![("k2", dice.between(-0.1, 0.1))],
        "dead-zone" => vec![("ks", spring?), ("gap", dice.between(0.05, 0.4))],
        "one-sided-stop" => vec![("ks", dice.between(1.0, 20.0)), ("gap", dice.between(0.1, 0.8))],
        "offset" => vec![("f0", dice.between(-0.5, 0.5))],
        "harmonic-force" | "parametric-stiffness" => {
            let name = if id == "harmonic-force" { "A" } else { "e" };
            vec![
                (name, dice.between(0.1, 0.4)),
                ("w", dice.between(0.3, 2.5)),
                ("phase", dice.between(-3.0, 3.0)),
            ]
        }
        "van-der-pol" => vec![("mu", dice.between(0.05, 0.5)), ("a", dice.between(0.5, 4.0))],
        "presliding" => vec![("Fc", level), ("kt", (level / dice.between(0.05, 0.4) * 1e3).round() / 1e3)],
        "coulomb" => vec![("Fc", level)],
        "asymmetric-coulomb" => vec![("Fp", level), ("Fm", dice.between(0.05, 0.6))],
        "stribeck" => vec![("Fc", level), ("Fs", level * 2.0), ("vs", dice.between(0.05, 0.5))],
        "dieterich-ruina" => {
            let b = dice.between(0.12, 0.45) * level;
            vec![("F", level), ("a", b * dice.between(0.5, 0.95)), ("b", b)]
        }
        // Where it is negative it pushes, and nothing holds.
        "position-dependent-friction" => {
            vec![("F0", level), ("F1", dice.between(-0.3, 0.3)), ("F2", dice.between(0.0, 0.3))]
        }
        other => panic!("no such law: {other}"),
    })
}
