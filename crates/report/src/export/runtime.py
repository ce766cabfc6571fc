# What follows is the same for every model: the contact rule, and a simulation that locates its events.

OFF_SURFACE = 1e-6  # friction that is singular at rest is looked at so far off, in units of the scale of speed
MARGIN = 1e-10  # friction is continued smoothly so far beyond its surface
ON_SURFACE = 1e-13  # within this fraction of the scale of speed a contact has not yet left its surface
OVERLOAD = 1e-14  # a sticking contact lets go at this overload, in units of what it can hold
SLACK = 1e-12  # rounding must not shake a contact loose at the instant it comes to rest
TORN = 1e-9  # a contact further from rest than this was torn off by a jump of an input
LOAD_RESOLUTION = 1e-3  # how well a step must resolve the load of a sticking contact
SHAPE_RESOLUTION = 300.0  # the same for the speed of a contact whose friction has a shape near rest


class Sampled:
    """Samples of an input as a function of time: "cubic" (a spline), "linear" or "hold" (the last sample)."""

    def __init__(self, times, values, kind="cubic"):
        self.times, self.values, self.kind = [float(t) for t in times], [float(v) for v in values], kind
        if len(self.times) != len(self.values) or not self.times:
            raise ValueError("an input needs as many times as values, and at least one")
        if any(not b > a for a, b in zip(self.times, self.times[1:])):
            raise ValueError("the times of an input must increase")
        self.slopes = _spline_slopes(self.times, self.values) if kind == "cubic" else []
        self.longest = math.inf
        if kind == "cubic" and len(self.times) > 1:
            self.longest = 8.0*(self.times[-1] - self.times[0])/(len(self.times) - 1)

    def at(self, t):
        """Value and slope at time t."""
        times, values = self.times, self.values
        last = len(times) - 1
        if last == 0:
            return values[0], 0.0
        i = min(max(bisect.bisect_right(times, t) - 1, 0), last - 1)
        if self.kind == "hold":
            return values[last if t >= times[last] else i], 0.0
        t0, t1, v0, v1 = times[i], times[i + 1], values[i], values[i + 1]
        h = t1 - t0
        chord = (v1 - v0)/h
        if self.kind == "linear":
            return (v0 + chord*(t - t0) if t - t0 <= t1 - t else v1 + chord*(t - t1)), chord
        s0, s1 = self.slopes[i], self.slopes[i + 1]
        if t <= t0 and i == 0:
            return v0 + s0*(t - t0), s0
        if t >= t1 and i + 1 == last:
            return v1 + s1*(t - t1), s1
        r = (t - t0)/h
        bend, twist = chord - s0, s0 + s1 - 2.0*chord
        return v0 + (t - t0)*(s0 + r*(bend + (r - 1.0)*twist)), s0 + r*(2.0*bend + (3.0*r - 2.0)*twist)

    def breaks(self):
        """Where the value jumps or turns a corner."""
        if self.kind == "cubic":
            return []
        which = 0 if self.kind == "hold" else 1
        return [t for t in self.times if self.at(math.nextafter(t, -math.inf))[which] != self.at(t)[which]]


def _spline_slopes(t, v):
    """Slopes at the knots of the cubic spline with not-a-knot ends."""
    n = len(t)
    h = [b - a for a, b in zip(t, t[1:])]
    chord = [(b - a)/step for a, b, step in zip(v, v[1:], h)]
    if n <= 2:
        return [chord[0]]*2 if n == 2 else [0.0]
    if n == 3:
        curvature = (chord[1] - chord[0])/(h[0] + h[1])
        return [chord[0] - curvature*h[0], chord[0] + curvature*h[0], chord[1] + curvature*h[1]]
    above, slopes = [0.0]*n, [0.0]*n
    for i in range(n):
        if i == 0:
            two = h[0] + h[1]
            below, diagonal, upper = 0.0, h[1], two
            right = ((h[0] + 2.0*two)*h[1]*chord[0] + h[0]*h[0]*chord[1])/two
        elif i == n - 1:
            two = h[-1] + h[-2]
            below, diagonal, upper = two, h[-2], 0.0
            right = (h[-1]*h[-1]*chord[-2] + (2.0*two + h[-1])*h[-2]*chord[-1])/two
        else:
            below, diagonal, upper = h[i], 2.0*(h[i - 1] + h[i]), h[i - 1]
            right = 3.0*(h[i]*chord[i - 1] + h[i - 1]*chord[i])
        pivot = diagonal - (below*above[i - 1] if i else 0.0)
        above[i] = upper/pivot
        slopes[i] = (right - (below*slopes[i - 1] if i else 0.0))/pivot
    for i in range(n - 2, -1, -1):
        slopes[i] -= above[i]*slopes[i + 1]
    return slopes


class Formula:
    """An input given by a function of time, its rate of change if it is known, and the times at which it jumps or turns a corner."""

    longest = math.inf

    def __init__(self, value, slope=None, breaks=()):
        self.value, self.given, self.corners = value, slope, list(breaks)

    def at(self, t):
        if self.given is not None:
            return self.value(t), self.given(t)
        d = 2e-5  # seconds: right to nine digits up to a hundred cycles per second
        near, far = self.value(t + d) - self.value(t - d), self.value(t + 2.0*d) - self.value(t - 2.0*d)
        return self.value(t), (8.0*near - far)/(12.0*d)

    def breaks(self):
        return self.corners


class Constant(Formula):
    """An input that stays as it is."""

    def __init__(self, value, slope=0.0):
        super().__init__(lambda t: value, lambda t: slope)


class Field:
    """The model at a point, in its present modes: +1 or -1 for a contact that slips, the fraction of its friction for one that sticks."""

    def __init__(self, inputs, parameters):
        count = len(CONTACTS)
        self.inputs, self.parameters, self.left_of = inputs, parameters, math.inf
        self.modes, self.stuck = [0.0]*count, [False]*count
        self.floors, self.margins = [0.0]*count, [0.0]*count
        self.scale, self.speed = [1.0]*count, [1.0]*count

    def arguments(self, t, x):
        edge = t if t < self.left_of else math.nextafter(self.left_of, -math.inf)
        read = [signal.at(edge) for signal in self.inputs]
        sides = [0.0 if stuck else mode for stuck, mode in zip(self.stuck, self.modes)]
        return (t, x, [u for u, _ in read], [du for _, du in read], self.parameters, self.modes, sides, self.floors,
                self.margins)

    def rates(self, t, x):
        """dx/dt, and after it the load of each contact that sticks."""
        if any(self.stuck):
            self.hold(t, x)
        loads = [mode if stuck else 0.0 for mode, stuck in zip(self.modes, self.stuck)]
        return _flow(*self.arguments(t, x)) + loads

    def outputs(self, t, x):
        """What sensors read beside the states."""
        if any(self.stuck):
            self.hold(t, x)
        return _outputs(*self.arguments(t, x))

    def look(self, t, x, held=True):
        """Evaluates the surfaces, with contacts that stick held at rest if asked for."""
        if held and any(self.stuck):
            self.hold(t, x)
        c, n, all_ = len(CONTACTS), len(STATES), _surfaces(*self.arguments(t, x))
        self.w, self.w_rate = all_[:c], all_[c:2*c]
        self.influence = [all_[(2 + k)*c:(3 + k)*c] for k in range(c)]
        self.normals = [all_[(2 + c)*c + k*n:(2 + c)*c + (k + 1)*n] for k in range(c)]

    def hold(self, t, x):
        """Sets the modes of all that sticks to the fractions of friction that keep it at rest: one linear system."""
        held = [c for c, stuck in enumerate(self.stuck) if stuck]
        for c in held:
            self.modes[c] = 0.0
        self.look(t, x, held=False)
        rows = [[self.influence[c][k] for k in held] + [-self.w_rate[c]] for c in held]
        for c, mode in zip(held, _solved(rows)):
            self.modes[c] = mode

    def begin(self, t, x, scale):
        """Modes at a start: the sign of w, or the rule where it is zero."""
        self.look(t, x, held=False)
        on = []
        for c in range(len(CONTACTS)):
            size = sum(abs(a*s) for a, s in zip(self.normals[c], scale))
            self.scale[c] = size if size > 0.0 else 1.0
            self.margins[c] = MARGIN*self.scale[c]
            self.speed[c] = max(self.scale[c], abs(self.w[c]))
            if self.w[c] == 0.0:
                on.append(c)
            else:
                self.modes[c] = math.copysign(1.0, self.w[c])
        for c in range(len(CONTACTS)):
            self.choose_floor(c, t, x)
        if on:
            self.resolve(on, t, x)

    def choose_floor(self, c, t, x):
        """Of friction with a shape near rest: the little speed at which it is largest and finite."""
        if not CONTACTS[c][2]:
            return
        mode, self.modes[c] = self.modes[c], 0.0
        little = OFF_SURFACE*self.scale[c]

        def friction(floor):
            self.floors[c] = floor
            self.look(t, x, held=False)
            return -self.influence[c][c]

        best = (-math.inf, little)
        for floor in (0.0, self.margins[c], 0.1*little, little):
            size = friction(floor)
            if size > best[0] and math.isfinite(size) and math.isfinite(friction(floor - self.margins[c])):
                best = (size, floor)
        self.floors[c], self.modes[c] = best[1], mode

    def resolve(self, on, t, x):
        """The contact rule for those that stand on their surfaces now and for all that stick."""
        grips = [c for c, stuck in enumerate(self.stuck) if stuck]
        for c in on:
            came, self.modes[c], self.stuck[c] = self.modes[c], 0.0, False
            self.choose_floor(c, t, x)
            self.look(t, x, held=False)
            push, grip = self.w_rate[c], -self.influence[c][c]
            if CONTACTS[c][1] and grip > 0.0:
                grips.append(c)
                continue
            forward, backward = push - grip > 0.0, push + grip < 0.0
            if forward != backward:
                self.modes[c] = 1.0 if forward else -1.0
            else:
                self.modes[c] = -came if came != 0.0 else 1.0 if push >= 0.0 else -1.0
        self.share(grips, t, x)

    def share(self, grips, t, x):
        """All stick at first; the most overloaded one slips the way it is pushed; one that was relieved sticks again."""
        for c in grips:
            self.stuck[c] = True
        for _ in range(4*len(grips) + 4):
            self.hold(t, x)
            loads = [(math.inf if self.modes[c] != self.modes[c] else abs(self.modes[c]), c) for c in grips if self.stuck[c]]
            load, worst = max(loads, key=lambda pair: pair[0], default=(0.0, None))
            if load > 1.0 + SLACK:
                self.stuck[worst] = False
                self.modes[worst] = -1.0 if self.modes[worst] < 0.0 else 1.0
                continue
            self.look(t, x, held=False)
            relieved = [c for c in grips if not self.stuck[c]
                        and self.modes[c]*self.w_rate[c] < -SLACK*abs(self.influence[c][c])]
            if not relieved:
                return
            self.stuck[relieved[0]] = True

    def release(self, c, t, x):
        """A stuck contact goes the way it is pushed; the others that stick are decided anew."""
        self.hold(t, x)
        self.modes[c], self.stuck[c] = -1.0 if self.modes[c] < 0.0 else 1.0, False
        self.resolve([], t, x)

    def reconsider(self, t, x):
        """After a jump of an input: what it tore off or carried across its surface slips."""
        self.look(t, x, held=False)
        w = list(self.w)
        for c, far in enumerate(TORN*speed for speed in self.speed):
            if abs(w[c]) > far if self.stuck[c] else w[c]*self.modes[c] < -far:
                self.stuck[c], self.modes[c] = False, math.copysign(1.0, w[c])
        self.resolve([], t, x)

    def keep_at_rest(self, t, x):
        """Moves a point onto the surfaces of all that sticks, one after the other: contacts that share a body move each other."""
        if any(self.stuck):
            self.look(t, x, held=False)
            for c, stuck in enumerate(self.stuck):
                if stuck and self.w[c] != 0.0:
                    self.project(c, x)
                    self.look(t, x, held=False)

    def project(self, c, x):
        length = sum(a*a for a in self.normals[c])
        if length > 0.0:
            for j, a in enumerate(self.normals[c]):
                x[j] -= a*self.w[c]/length

    def signs(self):
        return [0 if stuck else int(mode) for stuck, mode in zip(self.stuck, self.modes)]


def _solved(rows):
    """Gauss-Jordan elimination; an unknown that the others decide becomes zero, and takes no row from those that come after it."""
    m, found = len(rows), {}
    largest = max((abs(a) for row in rows for a in row[:m]), default=0.0)
    for col in range(m):
        used = len(found)
        pivot = max(range(used, m), key=lambda r: abs(rows[r][col]), default=None)
        if pivot is None or abs(rows[pivot][col]) <= 1e-13*largest:
            continue
        found[col] = used
        rows[used], rows[pivot] = rows[pivot], rows[used]
        inverse = 1.0/rows[used][col]
        rows[used] = [a*inverse for a in rows[used]]
        for r in range(m):
            if r != used and rows[r][col] != 0.0:
                factor = rows[r][col]
                rows[r] = [a - factor*b for a, b in zip(rows[r], rows[used])]
    return [rows[found[col]][m] if col in found else 0.0 for col in range(m)]


def rates(t, x, u, modes, du=None, p=None):
    """dx/dt at time t, state x and inputs u, for contacts in the given modes: +1 and -1 slip in that direction, 0 sticks.

    What sticks is held by the friction that it takes: its velocity does not change. du are the rates of change of the inputs, which matter where
    something sticks to what an input moves. p are the parameters; PARAMETERS if not given.
    """
    field = Field([Constant(a, b) for a, b in zip(u, du or [0.0]*len(u))], p or PARAMETERS)
    field.modes, field.stuck = [float(s) for s in modes], [s == 0 for s in modes]
    for c, stuck in enumerate(field.stuck):
        if stuck:
            field.choose_floor(c, t, x)
    return field.rates(t, list(x))[:len(STATES)]


def modes(t, x, u, du=None, p=None, scale=None):
    """The modes at a point by the contact rule: the sign of the velocity, or at rest 0 while friction holds and the direction of the push else.

    scale is the smallest size of each state that matters (1 if not given): friction that is singular at rest is looked at 1e-6 of it off rest.
    """
    field = Field([Constant(a, b) for a, b in zip(u, du or [0.0]*len(u))], p or PARAMETERS)
    field.begin(t, list(x), scale or [1.0]*len(STATES))
    return field.signs()


C = [0.0, 0.2, 0.3, 0.8, 8.0/9.0, 1.0, 1.0]
A = [[0.2], [3.0/40.0, 9.0/40.0], [44.0/45.0, -56.0/15.0, 32.0/9.0],
     [19372.0/6561.0, -25360.0/2187.0, 64448.0/6561.0, -212.0/729.0],
     [9017.0/3168.0, -355.0/33.0, 46732.0/5247.0, 49.0/176.0, -5103.0/18656.0],
     [35.0/384.0, 0.0, 500.0/1113.0, 125.0/192.0, -2187.0/6784.0, 11.0/84.0]]
E = [71.0/57600.0, 0.0, -71.0/16695.0, 71.0/1920.0, -17253.0/339200.0, 22.0/525.0, -1.0/40.0]
D = [-12715105075.0/11282082432.0, 0.0, 87487479700.0/32700410799.0, -10690763975.0/1880347072.0,
     701980252875.0/199316789632.0, -1453857185.0/822651844.0, 69997945.0/29380423.0]


class Motion:
    """What simulate returns: states, outputs and modes at the times, and all changes of mode as (time, contact, from, to)."""

    def __init__(self):
        self.states, self.outputs, self.modes, self.events = [], [], [], []


def simulate(times, start=None, inputs=(), p=None, t0=None, tolerance=1e-10, scale=None):
    """The motion at the given times (which do not decrease), from the state `start` at time t0 (the first one if not given).

    inputs: for each input a Sampled, a function of time, or a pair of functions, the input and its rate of change.
    tolerance: local error of a step relative to each state's size. scale: the smallest size of each state that matters; if not given, the
    largest value of a first, coarse run.
    """
    signals = [s if hasattr(s, "at") else Formula(*s) if isinstance(s, tuple) else Formula(s) for s in inputs]
    if len(signals) != len(INPUTS):
        raise ValueError(f"{len(INPUTS)} inputs are needed, not {len(signals)}")
    start = START if start is None else start
    if any(x is None for x in start) or len(start) != len(STATES):
        raise ValueError("start: one number for each of " + ", ".join(name for name, _ in STATES))
    t0 = times[0] if t0 is None else t0
    if scale is None:
        scale = _sizes(times, start, t0, signals, p or PARAMETERS)
    return _Run(times, start, t0, signals, p or PARAMETERS, tolerance, scale).motion()


def _sizes(times, start, t0, signals, parameters):
    """The largest value of each state in a coarse run; friction that is singular at rest is too steep for the smallest scales."""
    for smallest in (1e-9, 1e-6, 1e-3, 1.0):
        try:
            coarse = _Run(times, start, t0, signals, parameters, 1e-4, [smallest]*len(STATES)).motion()
        except ArithmeticError:
            if smallest == 1.0:
                raise
            continue
        sizes = [max((abs(row[k]) for row in coarse.states), default=0.0) for k in range(len(STATES))]
        # What is smaller is rounding, as of a mass that sticks throughout.
        return [size if size > 1e-4*smallest else 1.0 for size in sizes]


class _Run:
    """Adaptive steps of Dormand and Prince's pair 5(4) from event to event."""

    def __init__(self, times, start, t0, signals, parameters, tolerance, scale):
        self.field = Field(signals, parameters)
        self.times, self.tolerance, self.scale = list(times), tolerance, scale
        self.t, self.x = float(t0), [float(x) for x in start]
        self.span = max(self.times[-1] - t0, 5e-324)
        self.longest = min([32.0*self.span/len(self.times)] + [s.longest for s in signals])
        corners = {b for s in signals for b in s.breaks() if t0 < b < t0 + self.span}
        self.breaks = sorted(corners, reverse=True)
        self.flutter = (0, self.t)
        self.steps = 0
        self.next, self.out = 0, Motion()

    def motion(self):
        field = self.field
        field.left_of = self.breaks[-1] if self.breaks else math.inf
        field.begin(self.t, self.x, self.scale)
        self.settle()
        self.h = self.first_step()
        while self.next < len(self.times) and self.times[self.next] <= self.t:
            back = self.times[self.next] - self.t
            self.write([x + back*f for x, f in zip(self.x, self.k0)])
        while self.next < len(self.times):
            self.step()
        return self.out

    def write(self, x):
        self.out.states.append(x)
        if OUTPUTS:
            self.out.outputs.append(self.field.outputs(self.times[self.next], x))
        self.out.modes.append(self.field.signs())
        self.next += 1

    def settle(self):
        """Rates and surfaces at the present point."""
        self.k0 = self.field.rates(self.t, self.x)
        self.field.look(self.t, self.x)
        self.here = (self.field.w, self.field.w_rate)

    def first_step(self):
        norm = max([abs(f/s) for f, s in zip(self.k0, self.scale)], default=0.0)
        h0 = min(1e-3/norm, self.longest) if norm > 1e-10 else 1e-3*self.longest
        moved = self.field.rates(self.t + h0, [x + h0*f for x, f in zip(self.x, self.k0)])
        change = max([abs((b - a)/h0/s) for a, b, s in zip(self.k0, moved, self.scale)], default=0.0)
        largest = max(norm, change)
        h1 = (0.1*self.tolerance**0.2/largest)**0.5 if largest > 1e-15 else h0
        return min(h1, 100.0*h0, self.longest)

    def advance(self, h):
        self.length, self.k, self.dense = h, [self.k0], None
        for stage in range(1, 7):
            row = A[stage - 1]
            x = [x0 + h*sum(a*k[i] for a, k in zip(row, self.k)) for i, x0 in enumerate(self.x)]
            self.k.append(self.field.rates(self.t + C[stage]*h, x))
        self.end = x

    def inside(self, theta):
        """The state at a fraction of the step, by Hairer's interpolant."""
        if self.dense is None:
            self.dense = []
            for i, (a, b) in enumerate(zip(self.x, self.end)):
                difference = b - a
                bend = self.length*self.k[0][i] - difference
                fourth = difference - self.length*self.k[6][i] - bend
                self.dense.append((a, difference, bend, fourth, self.length*sum(d*k[i] for d, k in zip(D, self.k))))
        back = 1.0 - theta
        return [a + theta*(b + back*(c + theta*(d + back*e))) for a, b, c, d, e in self.dense]

    def guard(self, c, t, x):
        """Positive while the mode of a contact may last."""
        field = self.field
        if field.stuck[c]:
            field.hold(t, x)
            return 1.0 - abs(field.modes[c]) + OVERLOAD
        field.look(t, x)
        return field.modes[c]*field.w[c]

    def guard_inside(self, c, theta):
        return self.guard(c, self.t + theta*self.length, self.inside(theta))

    def error(self):
        """The largest scaled error of the step just tried: at most 1 is good."""
        field, n = self.field, len(self.x)
        errors = [sum(e*k[i] for e, k in zip(E, self.k)) for i in range(n + len(CONTACTS))]
        scaled = [abs(self.length*errors[i])/(self.tolerance*max(self.scale[i], abs(self.x[i]), abs(self.end[i])))
                  for i in range(n)]
        for c, (_, _, shaped) in enumerate(CONTACTS):
            if field.stuck[c]:
                scaled.append(abs(errors[n + c])/LOAD_RESOLUTION)
            elif shaped:
                e = sum(a*self.length*errors[j] for j, a in enumerate(field.normals[c]))
                speed = max(abs(self.here[0][c]), abs(self.there[0][c]), field.floors[c], 1e-9*field.scale[c])
                scaled.append(abs(e)/(SHAPE_RESOLUTION*self.tolerance*speed))
        return max(scaled, default=0.0) if all(math.isfinite(e) for e in scaled) else math.inf

    def step(self):
        field, end = self.field, self.times[-1]
        target = min(self.breaks[-1], end) if self.breaks else end
        tiny = 1e-15*max(abs(self.t), abs(end), self.span)
        while True:
            self.steps += 1
            if self.steps > 2000000:
                raise ArithmeticError(f"more than two million steps at t = {self.t}")
            h = min(self.h, self.longest)
            if target - self.t - h < 1e-3*h:
                h = target - self.t
            self.advance(h)
            field.look(self.t + h, self.end)
            self.there = (field.w, field.w_rate)
            error = self.error()
            if error <= 1.0:
                event = self.first_event()
                if event is None:
                    growth = min(max(0.9*error**-0.2, 0.2), 5.0) if error > 0.0 else 5.0
                    self.h = max(h*growth, self.h if h < self.h else 0.0)
                    self.accept()
                    self.turn_corner()
                    return
                c, theta = event
                if theta is not None:
                    if theta > 0.0:
                        self.locate(c, theta)
                        self.accept()
                    self.pass_events(c)
                    self.turn_corner()
                    self.h = self.first_step()
                    return
                self.h = 0.5*h
            else:
                shrink = min(max(0.9*error**-0.2, 0.1), 0.9) if math.isfinite(error) else 0.1
                self.h = h*shrink
                reach = self.overshoot()
                if reach is not None:
                    self.h = min(max(self.h, 0.5*min(h, reach)), 0.9*h)
            if self.h <= tiny:
                raise ArithmeticError(f"the step length collapsed at t = {self.t}")

    def overshoot(self):
        """If the failed step ends across a slipping contact's surface: the time to reach it in a straight line."""
        field, (w, rate), (late, _) = self.field, self.here, self.there
        crossed = [c for c in range(len(CONTACTS)) if not field.stuck[c] and field.modes[c]*late[c] < 0.0 and rate[c] != 0.0]
        return min((-w[c]/rate[c] for c in crossed if -w[c]/rate[c] > 0.0), default=None)

    def first_event(self):
        """The first guard that fails in the step: (contact, fraction), or (contact, None) if only a shorter step can tell."""
        first = None
        for c in range(len(CONTACTS)):
            found = self.overload(c) if self.field.stuck[c] else self.crossing(c)
            if found is not None and found[1] is None:
                return found
            if found is not None and (first is None or found[1] < first[1]):
                first = found
        return first

    def overload(self, c):
        """Where in the step a sticking contact is overloaded."""
        reserve = [1.0 - abs(k[len(self.x) + c]) + OVERLOAD for k in self.k[:6]]
        failing = [i for i in range(1, 6) if reserve[i] < 0.0]
        bracket = (C[failing[0] - 1], C[failing[0]]) if failing else None
        least = reserve.index(min(reserve))
        if bracket is None and 0 < least < 5:
            peak = _golden(C[least - 1], C[least + 1], lambda theta: self.guard_inside(c, theta))
            if self.guard_inside(c, peak) < 0.0:
                bracket = (C[least - 1], peak)
        if bracket is None:
            return None
        good, bad = bracket
        if self.guard_inside(c, good) <= 0.0:
            return c, good
        return c, _root(good, bad, lambda theta: self.guard_inside(c, theta))

    def crossing(self, c):
        """Where in the step a slipping contact reaches its surface; one that starts on it must leave first."""
        field, here, mode = self.field, ON_SURFACE*self.field.speed[c], self.field.modes[c]
        start, early = mode*self.here[0][c], mode*self.here[1][c]
        end, late = mode*self.there[0][c], mode*self.there[1][c]
        if start > here:
            if end < 0.0:
                return c, _root(0.0, 1.0, lambda theta: self.guard_inside(c, theta))
            if early < 0.0 < late:
                def slope(theta):
                    self.guard_inside(c, theta)
                    return -mode*field.w_rate[c]
                lowest = _root(0.0, 1.0, slope)
                if self.guard_inside(c, lowest) < 0.0:
                    return c, _root(0.0, lowest, lambda theta: self.guard_inside(c, theta))
        elif end < -here:
            for f in (0.5, 0.25, 0.75, 0.125, 0.03, 0.005):
                if self.guard_inside(c, f) > here:
                    return c, _root(f, 1.0, lambda theta: self.guard_inside(c, theta))
            return c, None if self.length > 1e-9*self.span else 1.0
        return None

    def locate(self, c, theta):
        """Repeats the step so that it ends on the surface: Newton's method on its length."""
        field, h, stuck = self.field, self.length, self.field.stuck[c]
        size = OVERLOAD if stuck else ON_SURFACE*field.speed[c]
        delta = min(1e-4, 0.5*theta)
        slope = (self.guard_inside(c, theta) - self.guard_inside(c, theta - delta))/(delta*h)
        length = theta*h
        for _ in range(4):
            self.advance(length)
            g = self.guard(c, self.t + length, self.end)
            if not stuck:
                slope = field.modes[c]*field.w_rate[c]
            change = -g/slope if slope != 0.0 else math.inf
            if abs(g) <= size or not abs(change) <= 0.1*h or length + change <= 0.0:
                break
            length = min(length + change, h)
        field.look(self.t + self.length, self.end)
        self.there = (field.w, field.w_rate)

    def accept(self):
        t1 = self.t + self.length
        while self.next < len(self.times) and self.times[self.next] <= t1:
            x = self.inside((self.times[self.next] - self.t)/self.length)
            self.field.keep_at_rest(self.times[self.next], x)
            self.write(x)
        self.t, self.x, self.k0, self.here = t1, list(self.end), self.k[6], self.there
        self.field.speed = [max(speed, abs(w)) for speed, w in zip(self.field.speed, self.here[0])]
        self.field.keep_at_rest(self.t, self.x)
        if not all(abs(x) <= 1e24*s for x, s in zip(self.x, self.scale)):
            raise ArithmeticError(f"the motion grows without bound at t = {self.t}")

    def pass_events(self, first):
        """New modes at the present point, and whatever else is due at the same instant."""
        if self.t - self.flutter[1] > 1e-4*self.span:
            self.flutter = (0, self.t)
        field, due, done = self.field, first, []
        while due is not None:
            self.flutter = (self.flutter[0] + 1, self.flutter[1])
            if self.flutter[0] > 200:
                raise ArithmeticError(f"{CONTACTS[due][0]} changes sign without end at t = {self.t}")
            before = field.signs()
            if field.stuck[due]:
                field.release(due, self.t, self.x)
            else:
                field.look(self.t, self.x)
                field.project(due, self.x)
                field.resolve([due], self.t, self.x)
            self.record(before)
            self.settle()
            done.append(due)
            w, rate = self.here
            due = next((c for c in range(len(CONTACTS)) if c not in done and not field.stuck[c]
                        and field.modes[c]*w[c] <= ON_SURFACE*field.speed[c] and field.modes[c]*rate[c] < 0.0), None)

    def record(self, before):
        for c, (old, new) in enumerate(zip(before, self.field.signs())):
            if old != new:
                self.out.events.append((self.t, CONTACTS[c][0], old, new))

    def turn_corner(self):
        """Goes on behind a jump or a corner of an input, if the present point is one."""
        if not self.breaks or self.breaks[-1] > self.t:
            return
        while self.breaks and self.breaks[-1] <= self.t:
            self.breaks.pop()
        self.field.left_of = self.breaks[-1] if self.breaks else math.inf
        before = self.field.signs()
        self.field.reconsider(self.t, self.x)
        self.record(before)
        self.settle()


def _root(good, bad, g):
    """The root of g between good (positive) and bad (negative), to 1e-10: the Illinois variant of false position."""
    high, low, side = g(good), g(bad), 0
    for _ in range(80):
        middle = (good*low - bad*high)/(low - high) if low != high else math.nan
        if not min(good, bad) < middle < max(good, bad):
            middle = 0.5*(good + bad)
        value = g(middle)
        if value == 0.0 or abs(bad - good) <= 1e-10:
            return middle
        if value > 0.0:
            good, high = middle, value
            low = 0.5*low if side == 1 else low
            side = 1
        else:
            bad, low = middle, value
            high = 0.5*high if side == -1 else high
            side = -1
    return bad


def _golden(a, b, g):
    """Where g is least between a and b, by the golden section, to 1e-5 of the interval."""
    ratio = 0.5*(5.0**0.5 - 1.0)
    left, right = b - ratio*(b - a), a + ratio*(b - a)
    low, high = g(left), g(right)
    for _ in range(24):
        if low < high:
            b, right, high = right, left, low
            left = b - ratio*(b - a)
            low = g(left)
        else:
            a, left, low = left, right, high
            right = a + ratio*(b - a)
            high = g(right)
    return left if low < high else right


def main():
    """CSV with headings on standard input (t and the inputs; of several records, told apart by a column `record`, the one of START; other columns are
    ignored); the motion as CSV on standard output."""
    rows = [row for row in csv.DictReader(sys.stdin) if row.get("record", RECORD) == RECORD]
    missing = [name for name in ["t"] + [name for name, _, _ in INPUTS] if not rows or name not in rows[0]]
    if missing:
        sys.exit("no column " + ", ".join(missing) + " on standard input")
    times = [float(row["t"]) for row in rows]
    inputs = [Sampled(times, [row[name] for row in rows], kind) for name, _, kind in INPUTS]
    motion = simulate(times, inputs=inputs, t0=START_TIME)
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["t"] + [name for name, _ in STATES + OUTPUTS] + ["mode " + name for name, _, _ in CONTACTS])
    for t, x, y, signs in zip(times, motion.states, motion.outputs or [[]]*len(times), motion.modes):
        out.writerow([repr(t)] + [repr(v) for v in x + y] + signs)


if __name__ == "__main__":
    main()
