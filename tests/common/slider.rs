//! A slider on a spring: records of an integrator that is not the program's, and its spec.

use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Random numbers (D. E. Knuth's constants).
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    /// Small seeds are alike in their first numbers, which are left out.
    pub(crate) fn new(seed: u64) -> Dice {
        let mut dice = Dice(seed);
        (0..20).for_each(|_| _ = dice.unit());
        dice
    }

    /// Between 0 and 1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.unit().ln()).sqrt() * (TAU * self.unit()).cos()
    }
}

/// The slider, what is wrong with its drive and its sensor, and what hangs on it.
#[derive(Clone, Copy)]
pub(crate) struct Slider {
    pub(crate) mass: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) friction: f64,
    /// By how much static friction exceeds kinetic friction.
    pub(crate) holds: f64,
    /// By which part of itself the friction grows in a second.
    pub(crate) wear: f64,
    /// Half the play of the spring (m).
    pub(crate) play: f64,
    /// Dead band and limit of the drive (N), and its lag (s).
    pub(crate) dead: f64,
    pub(crate) top: f64,
    pub(crate) lag: f64,
    /// Mass, stiffness, damping and quadratic drag of a body that hangs on it.
    pub(crate) body: Option<[f64; 4]>,
    /// Of the sensor of its place.
    pub(crate) gain: f64,
}

impl Slider {
    /// With a spring without play, a drive and a sensor that do what they should, and nothing that hangs on it.
    pub(crate) const fn plain(mass: f64, stiffness: f64, damping: f64, friction: f64) -> Slider {
        let top = f64::INFINITY;
        Slider {
            mass,
            stiffness,
            damping,
            friction,
            holds: 0.0,
            wear: 0.0,
            play: 0.0,
            dead: 0.0,
            top,
            lag: 0.0,
            body: None,
            gain: 1.0,
        }
    }

    /// Places at each 5 ms, by steps of 10 us in which friction takes what it can of the speed (J. J. Moreau, Unilateral
    /// contact and dry friction in finite freedom dynamics, 1988).
    fn places(&self, seconds: f64, drive: &dyn Fn(f64) -> f64) -> Vec<f64> {
        let (h, every) = (1e-5, 500);
        let [mut x, mut v, mut y, mut w] = [0.0_f64; 4];
        let mut acts = drive(0.0);
        let [m, k, c, d] = self.body.unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let mut all = vec![];
        for step in 0..(seconds / h) as usize {
            if step % every == 0 {
                all.push(x);
            }
            let u = drive(step as f64 * h);
            acts = if self.lag > 0.0 { acts + h * (u - acts) / self.lag } else { u };
            let beyond = (acts.abs() - self.dead).max(0.0).min(self.top) * acts.signum();
            let hangs = k * (x - y) + c * (v - w) + d * (v - w) * (v - w).abs();
            let reach = (x.abs() - self.play).max(0.0) * x.signum();
            let free = v + h * (beyond - self.stiffness * reach - self.damping * v - hangs) / self.mass;
            let held = if v == 0.0 { self.holds } else { 0.0 };
            let most = h * (self.friction * (1.0 + self.wear * step as f64 * h) + held) / self.mass;
            // A body that turns is at rest for an instant.
            let next = free - free.clamp(-most, most);
            v = if self.holds > 0.0 && v * next < 0.0 { 0.0 } else { next };
            w += h * hangs / m;
            x += h * v;
            y += h * w;
        }
        all
    }

    /// 9 s of its motion at 200 Hz with 1 % noise: columns `t`, `x`, `F`.
    pub(crate) fn record(&self, drive: &dyn Fn(f64) -> f64, dice: &mut Dice) -> String {
        self.record_from(0.0, drive, dice)
    }

    /// The same, by a clock that shows this at the first sample.
    pub(crate) fn record_from(&self, clock: f64, drive: &dyn Fn(f64) -> f64, dice: &mut Dice) -> String {
        let places = self.places(9.0, drive);
        let size = (places.iter().map(|x| x * x).sum::<f64>() / places.len() as f64).sqrt();
        let mut text = "t,x,F\n".to_owned();
        for (k, x) in places.iter().enumerate() {
            let t = 0.005 * k as f64;
            let _ =
                writeln!(text, "{},{},{}", clock + t, self.gain * x + 0.01 * size * dice.normal(), drive(t));
        }
        text
    }

    /// Its numbers as constants of a spec that holds them.
    pub(crate) fn constants(&self) -> String {
        let Slider { mass, stiffness, damping, friction, .. } = self;
        format!(
            r#""m": ({mass:?}, "kg"), "k": ({stiffness:?}, "N/m"), "c": ({damping:?}, "N*s/m"), "Fc": ({friction:?}, "N")"#
        )
    }
}

/// The spec of a slider with these constants: two thirds of a record to fit, one to validate.
pub(crate) fn spec(constants: &str, data: &str) -> String {
    spec_from(0.0, constants, data)
}

/// The same, of a record by a clock that shows this at the first sample.
pub(crate) fn spec_from(clock: f64, constants: &str, data: &str) -> String {
    let (fit, end) = (clock + 6.0, clock + 9.0);
    let record = format!(r#"Csv(path: "{data}", time: "t", columns: {{ "x": "x", "F": "F" }}, window: "#);
    format!(
        r#"(
    constants: {{ {constants} }},
    states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }},
    known: {{ "x": "v", "v": "(F - k*x - c*v - Fc*sgn(v))/m" }},
    inertia: {{ "v": "m" }}, contacts: ["v"], unknown: {{}},
    data: [ {record}({clock:?}, {fit:?})), {record}({fit:?}, {end:?}), role: Validate) ],
)
"#
    )
}
