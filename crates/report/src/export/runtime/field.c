/* What follows is the same for every model: the contact rule, and steps that locate its events. */

#define ROOM(n) ((n) > 0 ? (n) : 1)
#define LOADS (STATES + CONTACTS)

static const double OFF_SURFACE = 1e-6;  /* friction that is singular at rest is looked at so far off, in units of the scale of speed */
static const double MARGIN = 1e-10;      /* friction is continued smoothly so far beyond its surface */
static const double ON_SURFACE = 1e-13;  /* within this fraction of the scale of speed a contact has not yet left its surface */
static const double OVERLOAD = 1e-14;    /* a sticking contact lets go at this overload, in units of what it can hold */
static const double SLACK = 1e-12;       /* rounding must not shake a contact loose at the instant it comes to rest */
static const double TORN = 1e-9;         /* a contact further from rest than this was torn off by a jump of an input */
static const double USUAL_TOLERANCE = 1e-10; /* local error of a step relative to the size of each state */
static const double LOAD_RESOLUTION = 1e-3;   /* how well a step must resolve the load of a sticking contact */
static const double SHAPE_RESOLUTION = 300.0; /* the same for the speed of a contact whose friction has a shape near rest */

/* How an input goes between its samples: the last one, a straight line, a spline with not-a-knot ends. */
typedef enum { HOLD, LINEAR, CUBIC } Kind;

/* An input: samples (slope: from model_spline, for CUBIC), or, where count is 0, functions of time. */
typedef struct {
    int count;
    const double *times, *values, *slopes;
    Kind kind;
    double (*value)(double t, void *context);
    double (*slope)(double t, void *context); /* matters where something sticks to what this input moves; NULL for 0 */
    void *context;
} Input;

/* How a run is made; model_options() has what is usual. */
typedef struct {
    double tolerance;      /* local error of a step relative to each state's size */
    const double *scale;   /* the smallest size of each state that matters; NULL: the largest value of a first, coarse run */
    const double *breaks;  /* times at which an input that is a function jumps or turns a corner, rising */
    int break_count;
    void (*event)(double t, int contact, int from, int to, void *context); /* told of every change of mode; NULL for nobody */
    void *context;
    double *outputs; /* what sensors read: room for count rows of OUTPUTS numbers; NULL: not wanted */
} Options;

/* Why a run ended early. */
typedef enum { FINE, NO_MEMORY, TOO_MANY_STEPS, STEP_COLLAPSED, NO_BOUND, FLUTTER } Status;

/* Value and slope of an input at a time. */
static void read_input(const Input *u, double t, double *value, double *slope)
{
    if (u->count == 0) {
        *value = u->value(t, u->context);
        *slope = u->slope != NULL ? u->slope(t, u->context) : 0.0;
        return;
    }
    int last = u->count - 1, low = 0, high = last;
    if (last == 0) {
        *value = u->values[0], *slope = 0.0;
        return;
    }
    while (high - low > 1) {
        int middle = low + (high - low)/2;
        if (u->times[middle] <= t)
            low = middle;
        else
            high = middle;
    }
    int i = low;
    if (u->kind == HOLD) {
        *value = u->values[t >= u->times[last] ? last : i], *slope = 0.0;
        return;
    }
    double t0 = u->times[i], t1 = u->times[i + 1], v0 = u->values[i], v1 = u->values[i + 1];
    double h = t1 - t0, chord = (v1 - v0)/h;
    if (u->kind == LINEAR) {
        *value = t - t0 <= t1 - t ? v0 + chord*(t - t0) : v1 + chord*(t - t1), *slope = chord;
        return;
    }
    double s0 = u->slopes[i], s1 = u->slopes[i + 1];
    if (t <= t0 && i == 0) {
        *value = v0 + s0*(t - t0), *slope = s0;
    } else if (t >= t1 && i + 1 == last) {
        *value = v1 + s1*(t - t1), *slope = s1;
    } else {
        double r = (t - t0)/h, bend = chord - s0, twist = s0 + s1 - 2.0*chord;
        *value = v0 + (t - t0)*(s0 + r*(bend + (r - 1.0)*twist));
        *slope = s0 + r*(2.0*bend + (3.0*r - 2.0)*twist);
    }
}

/* The model at a point, in its present modes: +1 or -1 for a contact that slips, the fraction of its friction for one that sticks. */
typedef struct {
    const Input *inputs;
    const Parameters *parameters;
    double left_of; /* inputs are read as they are just before this time: a step that ends where one jumps must not see the jump */
    double modes[ROOM(CONTACTS)], floors[ROOM(CONTACTS)], margins[ROOM(CONTACTS)];
    double scale[ROOM(CONTACTS)], speed[ROOM(CONTACTS)];
    bool stuck[ROOM(CONTACTS)];
    double surface[ROOM(CONTACTS*(2 + CONTACTS + STATES))]; /* w, dw/dt, d(dw/dt)/ds, dw/dx */
} Field;

#define W(f, c) ((f)->surface[c])
#define W_RATE(f, c) ((f)->surface[CONTACTS + (c)])
#define INFLUENCE(f, c, k) ((f)->surface[(2 + (c))*CONTACTS + (k)])
#define NORMAL(f, c, j) ((f)->surface[(2 + CONTACTS)*CONTACTS + (c)*STATES + (j)])

static void field_new(Field *f, const Input *inputs, const Parameters *parameters)
{
    memset(f, 0, sizeof *f);
    f->inputs = inputs, f->parameters = parameters, f->left_of = INFINITY;
    for (int c = 0; c < CONTACTS; c++)
        f->scale[c] = f->speed[c] = 1.0;
}

typedef void Expressions(double, const double *, const double *, const double *, const Parameters *, const double *, const double *,
                         const double *, const double *, double *);

static void evaluate(Field *f, Expressions *expressions, double t, const double *x, double *out)
{
    double u[ROOM(INPUTS)] = {0}, du[ROOM(INPUTS)] = {0}, sides[ROOM(CONTACTS)] = {0};
    double edge = t < f->left_of ? t : nextafter(f->left_of, -INFINITY);
    for (int k = 0; k < INPUTS; k++)
        read_input(&f->inputs[k], edge, &u[k], &du[k]);
    for (int c = 0; c < CONTACTS; c++)
        sides[c] = f->stuck[c] ? 0.0 : f->modes[c];
    expressions(t, x, u, du, f->parameters, f->modes, sides, f->floors, f->margins, out);
}

static bool any_stuck(const Field *f)
{
    for (int c = 0; c < CONTACTS; c++)
        if (f->stuck[c])
            return true;
    return false;
}

static void field_look(Field *f, double t, const double *x) { evaluate(f, surfaces, t, x, f->surface); }

/* Gauss-Jordan elimination on m rows of m + 1 numbers; an unknown that the others decide becomes zero, and takes no row from those that come after it. */
static void solve_rows(double *a, int m)
{
    int width = m + 1, used = 0, row_of[ROOM(CONTACTS)];
    double largest = 0.0, found[ROOM(CONTACTS)];
    for (int i = 0; i < m*m; i++)
        largest = fmax(largest, fabs(a[i/m*width + i%m]));
    for (int col = 0; col < m; col++) {
        int pivot = used;
        for (int r = used + 1; r < m; r++)
            if (fabs(a[r*width + col]) > fabs(a[pivot*width + col]))
                pivot = r;
        row_of[col] = -1;
        if (used == m || fabs(a[pivot*width + col]) <= 1e-13*largest)
            continue;
        for (int j = 0; j < width; j++) {
            double other = a[pivot*width + j];
            a[pivot*width + j] = a[used*width + j];
            a[used*width + j] = other;
        }
        double inverse = 1.0/a[used*width + col];
        for (int j = 0; j < width; j++)
            a[used*width + j] *= inverse;
        for (int r = 0; r < m; r++) {
            double factor = a[r*width + col];
            if (r != used && factor != 0.0)
                for (int j = 0; j < width; j++)
                    a[r*width + j] -= factor*a[used*width + j];
        }
        row_of[col] = used++;
    }
    for (int col = 0; col < m; col++)
        found[col] = row_of[col] < 0 ? 0.0 : a[row_of[col]*width + m];
    for (int col = 0; col < m; col++)
        a[col*width + m] = found[col];
}

/* Sets the modes of all that sticks to the fractions of friction that keep it at rest: one linear system. */
static void field_hold(Field *f, double t, const double *x)
{
    int held[ROOM(CONTACTS)], m = 0;
    double rows[ROOM(CONTACTS*(CONTACTS + 1))] = {0};
    for (int c = 0; c < CONTACTS; c++)
        if (f->stuck[c])
            held[m++] = c, f->modes[c] = 0.0;
    field_look(f, t, x);
    for (int i = 0; i < m; i++) {
        for (int k = 0; k < m; k++)
            rows[i*(m + 1) + k] = INFLUENCE(f, held[i], held[k]);
        rows[i*(m + 1) + m] = -W_RATE(f, held[i]);
    }
    solve_rows(rows, m);
    for (int i = 0; i < m; i++)
        f->modes[held[i]] = rows[i*(m + 1) + m];
}

static void field_held_look(Field *f, double t, const double *x)
{
    if (any_stuck(f))
        field_hold(f, t, x);
    field_look(f, t, x);
}

/* dx/dt, and after it the load of each contact that sticks. */
static void field_rates(Field *f, double t, const double *x, double *out)
{
    if (any_stuck(f))
        field_hold(f, t, x);
    evaluate(f, flow, t, x, out);
    for (int c = 0; c < CONTACTS; c++)
        out[STATES + c] = f->stuck[c] ? f->modes[c] : 0.0;
}

/* What sensors read beside the states. */
static void field_outputs(Field *f, double t, const double *x, double *out)
{
    if (any_stuck(f))
        field_hold(f, t, x);
    evaluate(f, outputs, t, x, out);
}

static double friction_at(Field *f, int c, double floor, double t, const double *x)
{
    f->floors[c] = floor;
    field_look(f, t, x);
    return -INFLUENCE(f, c, c);
}

/* Of friction with a shape near rest: the little speed at which it is largest and finite. */
static void field_choose_floor(Field *f, int c, double t, const double *x)
{
    if (!SHAPED[c])
        return;
    double mode = f->modes[c], little = OFF_SURFACE*f->scale[c], most = -INFINITY, best = little;
    double floors[4] = {0.0, f->margins[c], 0.1*little, little};
    f->modes[c] = 0.0;
    for (int i = 0; i < 4; i++) {
        double size = friction_at(f, c, floors[i], t, x);
        if (size > most && isfinite(size) && isfinite(friction_at(f, c, floors[i] - f->margins[c], t, x)))
            most = size, best = floors[i];
    }
    f->floors[c] = best, f->modes[c] = mode;
}

/* All stick at first; the most overloaded one slips the way it is pushed; one that was relieved sticks again. */
static void field_share(Field *f, const int *grips, int count, double t, const double *x)
{
    for (int i = 0; i < count; i++)
        f->stuck[grips[i]] = true;
    for (int round = 0; round < 4*count + 4; round++) {
        int worst = -1, relieved = -1;
        double load = 0.0;
        field_hold(f, t, x);
        for (int i = 0; i < count; i++) {
            int c = grips[i];
            double own = isnan(f->modes[c]) ? INFINITY : fabs(f->modes[c]);
            if (f->stuck[c] && own > load)
                worst = c, load = own;
        }
        if (worst >= 0 && load > 1.0 + SLACK) {
            f->stuck[worst] = false;
            f->modes[worst] = f->modes[worst] < 0.0 ? -1.0 : 1.0;
            continue;
        }
        field_look(f, t, x);
        for (int i = count - 1; i >= 0; i--) {
            int c = grips[i];
            if (!f->stuck[c] && f->modes[c]*W_RATE(f, c) < -SLACK*fabs(INFLUENCE(f, c, c)))
                relieved = c;
        }
        if (relieved < 0)
            return;
        f->stuck[relieved] = true;
    }
}

/* The contact rule for those that stand on their surfaces now and for all that stick. */
static void field_resolve(Field *f, const int *on, int on_count, double t, const double *x)
{
    int grips[ROOM(CONTACTS)], count = 0;
    for (int c = 0; c < CONTACTS; c++)
        if (f->stuck[c])
            grips[count++] = c;
    for (int i = 0; i < on_count; i++) {
        int c = on[i];
        double came = f->modes[c];
        f->modes[c] = 0.0, f->stuck[c] = false;
        field_choose_floor(f, c, t, x);
        field_look(f, t, x);
        double push = W_RATE(f, c), grip = -INFLUENCE(f, c, c);
        if (CAN_STICK[c] && grip > 0.0) {
            grips[count++] = c;
            continue;
        }
        bool forward = push - grip > 0.0, backward = push + grip < 0.0;
        if (forward != backward)
            f->modes[c] = forward ? 1.0 : -1.0;
        else
            f->modes[c] = came != 0.0 ? -came : push >= 0.0 ? 1.0 : -1.0;
    }
    field_share(f, grips, count, t, x);
}

/* Modes at a start: the sign of w, or the rule where it is zero. */
static void field_begin(Field *f, double t, const double *x, const double *scale)
{
    int on[ROOM(CONTACTS)], count = 0;
    field_look(f, t, x);
    for (int c = 0; c < CONTACTS; c++) {
        double size = 0.0, w = W(f, c);
        for (int j = 0; j < STATES; j++)
            size += fabs(NORMAL(f, c, j)*scale[j]);
        f->scale[c] = size > 0.0 ? size : 1.0;
        f->margins[c] = MARGIN*f->scale[c];
        f->speed[c] = fmax(f->scale[c], fabs(w));
        if (w == 0.0)
            on[count++] = c;
        else
            f->modes[c] = copysign(1.0, w);
    }
    for (int c = 0; c < CONTACTS; c++)
        field_choose_floor(f, c, t, x);
    if (count > 0)
        field_resolve(f, on, count, t, x);
}

/* A stuck contact goes the way it is pushed; the others that stick are decided anew. */
static void field_release(Field *f, int c, double t, const double *x)
{
    field_hold(f, t, x);
    f->modes[c] = f->modes[c] < 0.0 ? -1.0 : 1.0;
    f->stuck[c] = false;
    field_resolve(f, NULL, 0, t, x);
}

/* After a jump of an input: what it tore off or carried across its surface slips. */
static void field_reconsider(Field *f, double t, const double *x)
{
    field_look(f, t, x);
    for (int c = 0; c < CONTACTS; c++) {
        double w = W(f, c), far = TORN*f->speed[c];
        if (f->stuck[c] ? fabs(w) > far : w*f->modes[c] < -far)
            f->stuck[c] = false, f->modes[c] = copysign(1.0, w);
    }
    field_resolve(f, NULL, 0, t, x);
}

static void field_project(const Field *f, int c, double *x)
{
    double length = 0.0;
    for (int j = 0; j < STATES; j++)
        length += NORMAL(f, c, j)*NORMAL(f, c, j);
    for (int j = 0; j < STATES && length > 0.0; j++)
        x[j] -= NORMAL(f, c, j)*W(f, c)/length;
}

/* Moves a point onto the surfaces of all that sticks, one after the other: contacts that share a body move each other. */
static void field_keep_at_rest(Field *f, double t, double *x)
{
    if (!any_stuck(f))
        return;
    field_look(f, t, x);
    for (int c = 0; c < CONTACTS; c++)
        if (f->stuck[c] && W(f, c) != 0.0) {
            field_project(f, c, x);
            field_look(f, t, x);
        }
}

static int field_sign(const Field *f, int c) { return f->stuck[c] ? 0 : f->modes[c] < 0.0 ? -1 : 1; }
