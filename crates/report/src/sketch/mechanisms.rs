//! Mechanisms whose sketches are tested: the model without its data, and what must stand in its sketch.

/// Name, spec, sketch in words.
pub(super) const MECHANISMS: [(&str, &str, &str); 25] = [
    (
        "cart with a hanging load",
        r#"constants: { "M": (2.0, "kg"), "m": (1.0, "kg"), "l": (0.6, "m"), "g": (9.81, "m/s^2"), "k": (20.0, "N/m"), "c": (2.0, "N*s/m"), "b": (0.02, "N*m*s") },
        inputs: { "F": "N" },
        energy: (coordinates: { "x": ("v", "m"), "th": ("w", "rad") }, kinetic: "(M + m)*v^2/2 + m*l*v*w*cos(th) + m*(l*w)^2/2",
            potential: "k*x^2/2 - m*g*l*cos(th)", dissipation: "c*v^2/2 + b*w^2/2", forces: { "F": "v" }),
        unknown: { "v": (factor: "-sgn(v)", candidates: ["1"]) }, contacts: ["v"]"#,
        "x, M + m = 3 kg: spring k = 20 N/m to the ground; damper c = 2 N·s/m to the ground; joint m·l·cos(th) to th; friction to the ground, asked for; force F. th, 0.36 kg·m²: damper b = 0.02 N·m·s/rad to the ground; weight on an arm m·g·l·sin(th).",
    ),
    (
        "two discs on a shaft",
        r#"constants: { "J": (0.01, "kg*m^2"), "I": (0.02, "kg*m^2"), "kt": (5.0, "N*m/rad"), "ct": (0.01, "N*m*s/rad") },
        states: { "a": "rad", "b": "rad", "wa": "rad/s", "wb": "rad/s" }, inputs: { "T": "N*m" },
        known: { "a": "wa", "b": "wb", "wa": "(T - kt*(a-b) - ct*(wa-wb))/J", "wb": "(kt*(a-b) + ct*(wa-wb))/I" },
        inertia: { "wa": "J", "wb": "I" }, unknown: {}, contacts: ["wb"]"#,
        "a, J = 0.01 kg·m²: spring kt = 5 N·m/rad to b; damper ct = 0.01 N·m·s/rad to b; force T. b, I = 0.02 kg·m²: friction to the ground.",
    ),
    (
        "quarter of a car",
        r#"constants: { "ms": (300.0, "kg"), "mu": (40.0, "kg"), "ks": (2e4, "N/m"), "kt": (2e5, "N/m"), "cs": (1500.0, "N*s/m") },
        states: { "zs": "m", "zu": "m", "vs": "m/s", "vu": "m/s" }, inputs: { "r": "m" },
        known: { "zs": "vs", "zu": "vu", "vs": "(-ks*(zs-zu) - cs*(vs-vu))/ms", "vu": "(ks*(zs-zu) + cs*(vs-vu) - kt*(zu-r))/mu" },
        inertia: { "vs": "ms", "vu": "mu" }, unknown: {}, contacts: ["vs-vu"]"#,
        "zs, ms = 300 kg: spring ks = 20000 N/m to zu; damper cs = 1500 N·s/m to zu; friction to zu. zu, μ = 40 kg: spring kt = 200000 N/m to r, which moves.",
    ),
    (
        "three masses between walls",
        r#"constants: { "m": (1.0, "kg"), "k": (10.0, "N/m"), "c": (0.1, "N*s/m"), "k13": (2.0, "N/m") },
        states: { "x1": "m", "x2": "m", "x3": "m", "v1": "m/s", "v2": "m/s", "v3": "m/s" }, inputs: { "F": "N" },
        known: { "x1": "v1", "x2": "v2", "x3": "v3", "v1": "(-k*x1 - k*(x1-x2) - k13*(x1-x3) + F)/m",
            "v2": "(k*(x1-x2) - k*(x2-x3) - c*v2 - k*x2)/m", "v3": "(k*(x2-x3) + k13*(x1-x3) - k*x3 - c*v3)/m" },
        inertia: { "v1": "m", "v2": "m", "v3": "m" }, unknown: {}, contacts: ["v1", "v2", "v3", "v1-v2"]"#,
        "x₁, m = 1 kg: spring k = 10 N/m to x₂; spring k₁₃ = 2 N/m to x₃; spring k = 10 N/m to the ground; friction to the ground; friction to x₂; force F. x₂, m = 1 kg: spring k = 10 N/m to x₃; spring k = 10 N/m to the ground; damper c = 0.1 N·s/m to the ground; friction to the ground. x₃, m = 1 kg: spring k = 10 N/m to the ground; damper c = 0.1 N·s/m to the ground; friction to the ground.",
    ),
    (
        "stiffening spring and drag",
        r#"constants: { "m": (1.0, "kg"), "k": (10.0, "N/m"), "k3": (100.0, "N/m^3"), "d": (0.3, "N*s^2/m^2") },
        states: { "x": "m", "v": "m/s" }, inputs: { "F": "N", "Q": "N" }, known: { "x": "v", "v": "(F + 2*Q - k*x - k3*x^3 - d*abs(v)*v)/m" }, inertia: { "v": "m" }, unknown: {}"#,
        "x, m = 1 kg: spring k = 10 N/m to the ground; nonlinear spring k₃·x³ to the ground; nonlinear damper d·|v|·v to the ground; force F + 2·Q.",
    ),
    (
        "mass on a belt",
        r#"constants: { "m": (1.0, "kg"), "k": (10.0, "N/m"), "V": (0.1, "m/s"), "Fc": Find(start: 1.0, unit: "N", within: (0.0, 5.0)) },
        states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "(-k*x - Fc*sgn(v - V))/m" }, inertia: { "v": "m" }, unknown: {}, contacts: ["v-V"]"#,
        "x, m = 1 kg: spring k = 10 N/m to the ground; friction Fc·sgn(v − V) to the ground.",
    ),
    (
        "motor with a spindle",
        r#"constants: { "J": (1e-4, "kg*m^2"), "kt": (0.05, "N*m/A"), "L": (1e-3, "H"), "R": (1.0, "ohm"), "b": (1e-5, "N*m*s/rad") },
        states: { "th": "rad", "w": "rad/s", "i": "A" }, inputs: { "U": "V" },
        known: { "th": "w", "w": "(kt*i - b*w)/J", "i": "(U - R*i - kt*w)/L" }, inertia: { "w": "J" }, unknown: {}, contacts: ["w"]"#,
        "th, J = 0.0001 kg·m²: damper b = 1e−5 N·m·s/rad to the ground; friction to the ground; force kt·i. i, its rate of w, i, U.",
    ),
    (
        "tanks",
        r#"constants: { "A": (0.1, "m^2"), "a": (1e-3, "m^2"), "g": (9.81, "m/s^2") },
        states: { "h1": "m", "h2": "m" }, inputs: { "q": "m^3/s" },
        known: { "h1": "(q - a*sqrt(2*g*abs(h1)))/A", "h2": "(a*sqrt(2*g*abs(h1)) - a*sqrt(2*g*abs(h2)))/A" }, unknown: {}"#,
        "h₁, its rate of h₁, q. h₂, its rate of h₁, h₂.",
    ),
    (
        "rope over a drum",
        r#"constants: { "m": (5.0, "kg"), "J": (0.1, "kg*m^2"), "r": (0.2, "m"), "k": (1e3, "N/m"), "c": (5.0, "N*s/m") }, inputs: { "T": "N*m" },
        energy: (coordinates: { "z": ("v", "m"), "th": ("w", "rad") }, kinetic: "m*v^2/2 + J*w^2/2", potential: "k*(z - r*th)^2/2",
            dissipation: "c*(v - r*w)^2/2", forces: { "T": "w" }), unknown: {}"#,
        "z, m = 5 kg: spring k = 1000 N/m to th; damper c = 5 N·s/m to th. th, J = 0.1 kg·m²: force T.",
    ),
    (
        "double pendulum",
        r#"constants: { "m": (1.0, "kg"), "l": (0.5, "m"), "g": (9.81, "m/s^2"), "b": (0.01, "N*m*s") },
        energy: (coordinates: { "a": ("wa", "rad"), "b2": ("wb", "rad") }, kinetic: "m*(l*wa)^2 + m*(l*wb)^2/2 + m*l^2*wa*wb*cos(a-b2)",
            potential: "-2*m*g*l*cos(a) - m*g*l*cos(b2)", dissipation: "b*wa^2/2 + b*(wa-wb)^2/2"), unknown: {}, contacts: ["wa", "wa-wb"]"#,
        "a, 0.5 kg·m²: damper b = 0.01 N·m·s/rad to b₂; damper b = 0.01 N·m·s/rad to the ground; weight on an arm 2·m·g·l·sin(a); joint m·l²·cos(a − b₂) to b₂; friction to the ground; friction to b₂. b₂, 0.25 kg·m²: weight on an arm m·g·l·sin(b₂).",
    ),
    (
        "shaker table",
        r#"constants: { "m": (2.0, "kg"), "k": (800.0, "N/m"), "c": (3.0, "N*s/m"), "kg": (50.0, "N/m"), "k3": (1e5, "N/m^3") },
        states: { "x": "m", "v": "m/s" }, inputs: { "u": "m", "du": "m/s" },
        known: { "x": "v", "v": "(-k*(x-u) - c*(v-du) - kg*x - k3*(x-u)^3)/m" }, inertia: { "v": "m" },
        outputs: { "acc": (unit: "m/s^2", reads: "rate(v)") }, unknown: { "v": (factor: "-1/m", candidates: ["sgn(v-du)", "v*|v|", "x", "1"]) }, contacts: ["v-du"]"#,
        "x, m = 2 kg: spring k = 800 N/m to u, which moves; spring kg = 50 N/m to the ground; damper c = 3 N·s/m to u, which moves; nonlinear spring k₃·(x − u)³ to u, which moves; friction to u, which moves, asked for; nonlinear damper to the ground, asked for; spring to the ground, asked for; force ?.",
    ),
    (
        "only rates",
        r#"states: { "y": "V", "w": "V/s" }, inputs: { "u": "V" }, constants: { "k": (value: 1.8e5, unit: "1/s^2", within: (1e5, 3e5)), "g": (1.6e5, "1/s^2") },
        known: { "y": "w", "w": "-k*y + g*u" }, unknown: {}"#,
        "y: spring k = 180000 1/s² to the ground; force g·u.",
    ),
    (
        "four in a row with a long way round",
        r#"constants: { "m": (1.0, "kg"), "k": (10.0, "N/m"), "q": (3.0, "N/m") },
        states: { "x1": "m", "x2": "m", "x3": "m", "x4": "m", "v1": "m/s", "v2": "m/s", "v3": "m/s", "v4": "m/s" }, inputs: { "F1": "N", "F2": "N" },
        known: { "x1": "v1", "x2": "v2", "x3": "v3", "x4": "v4", "v1": "(-k*x1 - k*(x1-x2) - q*(x1-x4) + F1)/m", "v2": "(k*(x1-x2) - k*(x2-x3) + F2 - q*(x2-x4))/m",
            "v3": "(k*(x2-x3) - k*(x3-x4))/m", "v4": "(k*(x3-x4) + q*(x1-x4) + q*(x2-x4))/m" },
        inertia: { "v1": "m", "v2": "m", "v3": "m", "v4": "m" }, unknown: {}, contacts: ["v3", "v3-v4"]"#,
        "x₁, m = 1 kg: spring k = 10 N/m to x₂; spring q = 3 N/m to x₄; spring k = 10 N/m to the ground; force F₁. x₂, m = 1 kg: spring k = 10 N/m to x₃; spring q = 3 N/m to x₄; force F₂. x₃, m = 1 kg: spring k = 10 N/m to x₄; friction to the ground; friction to x₄. x₄, m = 1 kg.",
    ),
    (
        "hysteresis between two",
        r#"constants: { "m": (1.0, "kg"), "k": (10.0, "N/m"), "A": (5.0, "N/m"), "s": (2.0, "1/m") },
        states: { "x1": "m", "x2": "m", "v1": "m/s", "v2": "m/s", "z": "N" }, inputs: { "F": "N" },
        known: { "x1": "v1", "x2": "v2", "v1": "(-k*x1 - z + F)/m", "v2": "(z - k*x2)/m", "z": "A*(v1-v2) - s*abs(v1-v2)*z" },
        inertia: { "v1": "m", "v2": "m" }, unknown: {}"#,
        "x₁, m = 1 kg: spring k = 10 N/m to the ground; force z to x₂; force F. x₂, m = 1 kg: spring k = 10 N/m to the ground. z, its rate of v₁, v₂, z.",
    ),
    (
        "lift with gravity",
        r#"constants: { "m": (2.0, "kg"), "g": (9.81, "m/s^2"), "k": (100.0, "N/m"), "d": (0.01, "m") },
        states: { "z": "m", "v": "m/s" }, known: { "z": "v", "v": "-g - k/m*dead(z, d)" }, inertia: { "v": "m" }, unknown: {}"#,
        "z, m = 2 kg: nonlinear spring k·dead(z, d) to the ground; force −m·g.",
    ),
    (
        "vehicle on a road",
        r#"constants: { "m": (1200.0, "kg"), "cr": (0.01, "1"), "g": (9.81, "m/s^2"), "cw": (0.4, "kg/m") },
        states: { "v": "m/s" }, inputs: { "F": "N" }, known: { "v": "F/m - g*cr - cw/m*v*abs(v)" }, inertia: { "v": "m" }, unknown: {}, contacts: ["v"]"#,
        "v, m = 1200 kg: nonlinear damper cw·v·|v| to the ground; friction to the ground; force F − m·(g·cr).",
    ),
    (
        "absorber on a shaken mass",
        r#"constants: { "M": (10.0, "kg"), "m": (0.5, "kg"), "K": (1e3, "N/m"), "k": (50.0, "N/m"), "c": (0.4, "N*s/m") },
        states: { "X": "m", "x": "m", "V": "m/s", "v": "m/s" }, inputs: { "u": "mm" },
        known: { "X": "V", "x": "v", "V": "(-K*(X-u) - k*(X-x) - c*(V-v))/M", "v": "(k*(X-x) + c*(V-v))/m" }, unknown: {}, contacts: ["V"]"#,
        "X, M = 10 kg: spring k = 50 N/m to x; spring K = 1000 N/m to u, which moves; damper c = 0.4 N·s/m to x; friction to the ground. x, m = 0.5 kg.",
    ),
    (
        "two coupled by a turning frame",
        r#"constants: { "m": (1.0, "kg"), "k": (30.0, "N/m"), "G": (2.0, "N*s/m") },
        states: { "x": "m", "y": "m", "vx": "m/s", "vy": "m/s" },
        known: { "x": "vx", "y": "vy", "vx": "(-k*x + G*vy)/m", "vy": "(-k*y - G*vx)/m" }, inertia: { "vx": "m", "vy": "m" }, unknown: {}"#,
        "x, m = 1 kg: spring k = 30 N/m to the ground; force G·vy to y. y, m = 1 kg: spring k = 30 N/m to the ground.",
    ),
    (
        "servo with its controller",
        r#"constants: { "m": (1.0, "kg"), "kp": (400.0, "N/m"), "kd": (20.0, "N*s/m") },
        states: { "x": "m", "v": "m/s" }, inputs: { "r": "m", "F": "N" },
        known: { "x": "v", "v": "(kp*(r - x) - kd*v + F)/m" }, inertia: { "v": "m" }, unknown: {}"#,
        "x, m = 1 kg: spring kp = 400 N/m to r, which moves; damper kd = 20 N·s/m to the ground; force F.",
    ),
    (
        "beam that buckles",
        r#"constants: { "k": (5.0, "1/s^2"), "b": (100.0, "1/(m^2*s^2)"), "c": (0.2, "1/s"), "A": (1.0, "m/s^2"), "W": (2.0, "rad/s"), "e": (0.1, "1") },
        states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "k*x - b*x^3 - c*v + A*cos(W*t) - e*k*cos(W*t)*x" }, unknown: {}"#,
        "x: spring −k = −5 1/s² to the ground; damper c = 0.2 1/s to the ground; nonlinear spring b·x³, e·k·cos(W·t)·x to the ground; force A·cos(W·t).",
    ),
    (
        "dashpot behind a spring",
        r#"constants: { "m": (1.0, "kg"), "k": (100.0, "N/m"), "q": (50.0, "N/m"), "d": (4.0, "N*s/m") },
        states: { "x": "m", "v": "m/s", "s": "m" }, known: { "x": "v", "s": "q*(x - s)/d", "v": "(-k*x - q*(x - s))/m" }, inertia: { "v": "m" }, unknown: {}"#,
        "x, m = 1 kg: spring k + q = 150 N/m to the ground; force q·s to the ground. s, its rate of x, s.",
    ),
    (
        "resonant circuit",
        r#"constants: { "L": (0.1, "H"), "R": (2.0, "ohm"), "C": (1e-5, "F") },
        states: { "q": "C", "i": "A" }, inputs: { "U": "V" }, known: { "q": "i", "i": "(U - R*i - q/C)/L" }, unknown: {}"#,
        "q: spring 1e6 1/s² to the ground; damper 20 1/s to the ground; force 1/L·U.",
    ),
    (
        "magnet in front of iron",
        r#"constants: { "m": (0.2, "kg"), "k": (300.0, "N/m"), "B": (1e-4, "N*m^2/A^2"), "a": (0.02, "m") },
        states: { "x": "m", "v": "m/s" }, inputs: { "i": "A" }, known: { "x": "v", "v": "(-k*x + B*i^2/(a - x)^2)/m" }, inertia: { "v": "m" }, unknown: {}"#,
        "x, m = 0.2 kg: spring k = 300 N/m to the ground; force B·i²/(a − x)² to the ground.",
    ),
    (
        "five in a row",
        r#"constants: { "m": (1.0, "kg"), "k": (10.0, "N/m"), "c": (0.1, "N*s/m") },
        states: { "x1": "m", "x2": "m", "x3": "m", "x4": "m", "x5": "m", "v1": "m/s", "v2": "m/s", "v3": "m/s", "v4": "m/s", "v5": "m/s" }, inputs: { "u": "m", "F": "N" },
        known: { "x1": "v1", "x2": "v2", "x3": "v3", "x4": "v4", "x5": "v5", "v1": "(-k*(x1-u) - k*(x1-x2))/m", "v2": "(k*(x1-x2) - k*(x2-x3) - c*v2)/m",
            "v3": "(k*(x2-x3) - k*(x3-x4) + F)/m", "v4": "(k*(x3-x4) - k*(x4-x5) - c*v4)/m", "v5": "(k*(x4-x5) - c*v5)/m" },
        inertia: { "v1": "m", "v2": "m", "v3": "m", "v4": "m", "v5": "m" }, unknown: {}, contacts: ["v2", "v5"]"#,
        "x₁, m = 1 kg: spring k = 10 N/m to x₂; spring k = 10 N/m to u, which moves. x₂, m = 1 kg: spring k = 10 N/m to x₃; damper c = 0.1 N·s/m to the ground; friction to the ground. x₃, m = 1 kg: spring k = 10 N/m to x₄; force F. x₄, m = 1 kg: spring k = 10 N/m to x₅; damper c = 0.1 N·s/m to the ground. x₅, m = 1 kg: damper c = 0.1 N·s/m to the ground; friction to the ground.",
    ),
    (
        "wheel that slips on a rail",
        r#"constants: { "m": (50.0, "kg"), "J": (1.2, "kg*m^2"), "r": (0.3, "m") },
        states: { "x": "m", "th": "rad", "v": "m/s", "w": "rad/s" }, inputs: { "T": "N*m" },
        known: { "x": "v", "th": "w", "v": "0", "w": "T/J" }, inertia: { "v": "m", "w": "J" }, let: { "slip": "r*w - v" }, places: { "rail": "slip" },
        unknown: {}, contacts: ["slip"]"#,
        "x, m = 50 kg: friction to th. th, J = 1.2 kg·m²: force T.",
    ),
];

/// The specs of the repository: name, sketch in words.
pub(super) const SPECS: [(&str, &str); 35] = [
    (
        "ball",
        "z, sensors of z: damper to the ground, asked for; nonlinear damper to the ground, asked for; force −g.",
    ),
    (
        "sampled_pid",
        "x, sensors of x, F: force to the ground; friction to the ground, asked for; damper to the ground, asked for. i, its rate of x, r, measured.",
    ),
    (
        "boucwen",
        "x, m = 2 kg, sensors of x: spring k = 50000 N/m to the ground; damper c = 10 N·s/m to the ground; force u.",
    ),
    (
        "boucwen_rig",
        "x, m = 2 kg, sensors of x: spring k = 50000 N/m to the ground; damper c = 10 N·s/m to the ground; force z to the ground; force u. z, its rate of v, z.",
    ),
    (
        "case10",
        "x, m = 3.08 kg, sensors of x: spring k = 1190 N/m to u, which moves; damper c = 0.203 N·s/m to u, which moves; friction to the ground, asked for.",
    ),
    (
        "case1a",
        "x, m = 1 kg, sensors of x, y: spring k = 1 N/m to the ground; damper d = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t).",
    ),
    (
        "case1b",
        "x, m = 1 kg, sensors of x, y: spring k = 1 N/m to the ground; damper d = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t).",
    ),
    (
        "case2a",
        "x, m = 1 kg, sensors of x, y: spring k = 1 N/m to the ground; damper d = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t).",
    ),
    (
        "case2b",
        "x, m = 1 kg, sensors of x, y: spring k = 1 N/m to the ground; damper d = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t).",
    ),
    (
        "case3_coulomb",
        "x, m = 1 kg, sensors of x, y: spring k = 1 N/m to the ground; damper d = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t).",
    ),
    (
        "case3_dr",
        "x, m = 1 kg, sensors of x, y: spring k = 1 N/m to the ground; damper d = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t).",
    ),
    (
        "case4",
        "x, m = 1 kg, sensors of x, y: spring k = 64 N/m to the ground; damper c = 5 N·s/m to the ground; friction to the ground, asked for; force F.",
    ),
    (
        "case5",
        "x₁, m₁ = 1 kg, sensors of x₁, y₁: spring k₂ = 1 N/m to x₂; spring k₁ = 1 N/m to the ground; damper c₂ = 0.1 N·s/m to x₂; damper c₁ = 0.1 N·s/m to the ground; force F₀·cos(W·t). x₂, m₂ = 1 kg, sensors of x₂, y₂: friction to the ground, asked for.",
    ),
    (
        "case6",
        "x₁, m₁ = 1 kg, sensors of x₁, y₁: spring k₂ = 1 N/m to x₂; spring k₁ = 1 N/m to the ground; damper c₂ = 0.1 N·s/m to x₂; damper c₁ = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t). x₂, m₂ = 1 kg, sensors of x₂, y₂: friction to the ground, asked for.",
    ),
    (
        "case7",
        "x₁, m₁ = 1 kg, sensors of x₁, y₁: spring k₂ = 1 N/m to x₂; spring k₁ = 1 N/m to the ground; damper c₂ = 0.1 N·s/m to x₂; damper c₁ = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t). x₂, m₂ = 1 kg, sensors of x₂, y₂: friction to the ground, asked for.",
    ),
    (
        "case7_expert",
        "x₁, m₁ = 1 kg, sensors of x₁, y₁: spring k₂ = 1 N/m to x₂; spring k₁ = 1 N/m to the ground; damper c₂ = 0.1 N·s/m to x₂; damper c₁ = 0.1 N·s/m to the ground; friction to the ground, asked for; force F₀·cos(W·t). x₂, m₂ = 1 kg, sensors of x₂, y₂: friction to the ground, asked for.",
    ),
    (
        "case8a",
        "x, m = 3.08 kg, sensors of x: spring k = 1190 N/m to u, which moves; damper c = 0.203 N·s/m to u, which moves; friction to the ground, asked for; force ?.",
    ),
    (
        "case8b",
        "x, m = 3.08 kg, sensors of x: spring k = 1190 N/m to the ground; damper c = 0.203 N·s/m to the ground; friction to the ground, asked for; spring to the ground, asked for; damper to the ground, asked for; force ?.",
    ),
    (
        "case8c",
        "x, m = 3.08 kg, sensors of x: spring k = 1190 N/m to the ground; damper c = 0.203 N·s/m to the ground; friction to the ground, asked for; spring to the ground, asked for; damper to the ground, asked for; force −c·A·W·sin(W·t) + k·A·cos(W·t); force ?.",
    ),
    (
        "case9a",
        "x, m = 3.08 kg, sensors of x: spring k = 1190 N/m to u, which moves; damper c = 0.203 N·s/m to u, which moves; friction to the ground, asked for.",
    ),
    (
        "case9b",
        "x, m = 3.08 kg, sensors of x: spring k = 1190 N/m to u, which moves; damper d = 0.203 N·s/m to u, which moves; friction to the ground, asked for.",
    ),
    ("damper", "p, its rate of p, v, measured."),
    (
        "emps",
        "q, M = 90 kg, sensors of q: friction to the ground, asked for; damper to the ground, asked for; force F; force ?.",
    ),
    (
        "frame_250g",
        "x, m = 3.08 kg, sensors of x: spring k = 1191 N/m to u, which moves; damper c = 0.669 N·s/m to u, which moves; friction to the ground, asked for.",
    ),
    (
        "frame_450g",
        "x, m = 3.08 kg, sensors of x: spring k = 1191 N/m to u, which moves; damper c = 0.669 N·s/m to u, which moves; friction to the ground, asked for.",
    ),
    (
        "frame_continuous",
        "x, m = 3.08 kg, sensors of x: spring k = 1190 N/m to u, which moves; damper c = 0.203 N·s/m to u, which moves; friction to the ground, asked for.",
    ),
    (
        "frame_gap",
        "x, m = 3.08 kg, sensors of x: spring k = 1191 N/m to u, which moves; damper c = 0.669 N·s/m to u, which moves.",
    ),
    (
        "frame_mu",
        "x, m = 3.08 kg, sensors of x: spring k = 1191 N/m to u, which moves; damper c = 0.669 N·s/m to u, which moves; friction to the ground, asked for.",
    ),
    ("lorenz63", "x, measured, asked for. y, measured, asked for. z, measured, asked for."),
    ("lorenz63_quintic", "x, measured, asked for. y, measured, asked for. z, measured, asked for."),
    (
        "nncc",
        "x, m = 1 kg, sensors of x: friction to the ground, asked for; spring to the ground, asked for; damper to the ground, asked for; force F₀·cos(W·t).",
    ),
    (
        "pendulum",
        "θ, sensors of θ: weight on an arm gl·sin(θ); friction to the ground, asked for; damper to the ground, asked for; nonlinear damper to the ground, asked for.",
    ),
    (
        "servo",
        "θ, sensors of θ: weight on an arm gl·sin(θ); friction to the ground, asked for; damper to the ground, asked for.",
    ),
    (
        "silverbox",
        "y, sensors of y: spring k = 180000 1/s² to the ground; damper c = 40 1/s to the ground; force g·u.",
    ),
    ("vanderpol", "x, measured, asked for. y, measured, asked for."),
];
