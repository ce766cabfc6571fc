def sgn(x):
    """-1, 0 or 1 with the sign of x."""
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else x*0.0


def step(x):
    return 0.5 + 0.5*sgn(x)


def rest(x):
    return 1.0 if x == 0.0 else x if x != x else 0.0


def pos(x):
    return 0.0 if x <= 0.0 else x


def dead(x, g):
    """x outside of +-g, less g; 0 inside."""
    beyond = abs(x) - g
    return sgn(x)*beyond if beyond > 0.0 else beyond if beyond != beyond else 0.0


def smaller(a, b):
    return a if a < b or a != a else b


def larger(a, b):
    return a if a > b or a != a else b


def floor(x):
    return float(math.floor(x)) if math.isfinite(x) else x


def mod(a, b):
    return a - b*floor(div(a, b))


def gate(a, b):
    return a if b > 0.0 else 0.0


def masked(a, b):
    return 0.0 if a == 0.0 or b == 0.0 else a*b


# Python stops where IEEE arithmetic goes on with an infinity or no number; friction that is singular at rest needs the latter.

def div(a, b):
    if b == 0.0:
        return math.nan if a == 0.0 or a != a else math.copysign(math.inf, a)*math.copysign(1.0, b)
    return a/b


def power(a, b):
    try:
        return math.pow(a, b)
    except (ValueError, OverflowError):
        if a < 0.0 and b != math.floor(b):
            return math.nan
        odd = b % 2.0 == 1.0
        return math.copysign(math.inf, a) if odd else math.inf


def ln(x):
    return math.log(x) if x > 0.0 else -math.inf if x == 0.0 else math.nan


def exp(x):
    try:
        return math.exp(x)
    except OverflowError:
        return math.inf


def sqrt(x):
    return math.sqrt(x) if x >= 0.0 else math.nan


def sin(x):
    return math.sin(x) if math.isfinite(x) else math.nan


def cos(x):
    return math.cos(x) if math.isfinite(x) else math.nan


def tan(x):
    return math.tan(x) if math.isfinite(x) else math.nan
