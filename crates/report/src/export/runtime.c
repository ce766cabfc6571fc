/* What follows is the same for every model: the contact rule, and a simulation that locates its events. */

#define ROOM(n) ((n) > 0 ? (n) : 1)
#define LOADS (STATES + CONTACTS)

static const double OFF_SURFACE = 1e-6;  /* friction that is singular at rest is looked at so far off, in units of the scale of speed */
static const double MARGIN = 1e-10;      /* friction is continued smoothly so far beyond its surface */
static const double ON_SURFACE = 1e-13;  /* within this fraction of the scale of speed a contact has not yet left its surface */
static const double OVERLOAD = 1e-14;    /* a sticking contact lets go at this overload, in units of what it can hold */
static const double SLACK = 1e-12;       /* rounding must not shake a contact loose at the instant it comes to rest */
static const double TORN = 1e-9;         /* a contact further from rest than this was torn off by a jump of an input */
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

Options model_options(void)
{
    Options usual = {1e-10, NULL, NULL, 0, NULL, NULL, NULL};
    return usual;
}

/* Slopes at the knots of the cubic spline with not-a-knot ends; above is room for n numbers. */
void model_spline(int n, const double *t, const double *v, double *slopes, double *above)
{
#define STEP(i) (t[(i) + 1] - t[i])
#define CHORD(i) ((v[(i) + 1] - v[i])/STEP(i))
    if (n == 1) {
        slopes[0] = 0.0;
    } else if (n == 2) {
        slopes[0] = slopes[1] = CHORD(0);
    } else if (n == 3) {
        double curvature = (CHORD(1) - CHORD(0))/(STEP(0) + STEP(1));
        slopes[0] = CHORD(0) - curvature*STEP(0);
        slopes[1] = CHORD(0) + curvature*STEP(0);
        slopes[2] = CHORD(1) + curvature*STEP(1);
    } else if (n > 3) {
        for (int i = 0; i < n; i++) {
            double below, diagonal, upper, right;
            if (i == 0) {
                double two = STEP(0) + STEP(1);
                below = 0.0, diagonal = STEP(1), upper = two;
                right = ((STEP(0) + 2.0*two)*STEP(1)*CHORD(0) + STEP(0)*STEP(0)*CHORD(1))/two;
            } else if (i == n - 1) {
                double h = STEP(n - 2), before = STEP(n - 3), two = h + before;
                below = two, diagonal = before, upper = 0.0;
                right = (h*h*CHORD(n - 3) + (2.0*two + h)*before*CHORD(n - 2))/two;
            } else {
                below = STEP(i), diagonal = 2.0*(STEP(i - 1) + STEP(i)), upper = STEP(i - 1);
                right = 3.0*(STEP(i)*CHORD(i - 1) + STEP(i - 1)*CHORD(i));
            }
            double pivot = diagonal - (i > 0 ? below*above[i - 1] : 0.0);
            above[i] = upper/pivot;
            slopes[i] = (right - (i > 0 ? below*slopes[i - 1] : 0.0))/pivot;
        }
        for (int i = n - 2; i >= 0; i--)
            slopes[i] -= above[i]*slopes[i + 1];
    }
#undef STEP
#undef CHORD
}

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

static double constant_value(double t, void *context) { return (void)t, ((double *)context)[0]; }
static double constant_slope(double t, void *context) { return (void)t, ((double *)context)[1]; }

/* A field at a point whose inputs are numbers; constants is room for two numbers of each input. */
static void field_at_point(Field *f, Input *inputs, double *constants, const double *u, const double *du, const Parameters *p)
{
    memset(inputs, 0, ROOM(INPUTS)*sizeof *inputs);
    for (int k = 0; k < INPUTS; k++) {
        constants[2*k] = u[k], constants[2*k + 1] = du != NULL ? du[k] : 0.0;
        Input constant = {0, NULL, NULL, NULL, HOLD, constant_value, constant_slope, &constants[2*k]};
        inputs[k] = constant;
    }
    field_new(f, inputs, p != NULL ? p : &PARAMETERS);
}

/* dx/dt at time t, state x and inputs u, for contacts in the given modes: +1 and -1 slip in that direction, 0 sticks.
   What sticks is held by the friction that it takes: its velocity does not change. du (NULL for zeros) are the rates of change of the inputs,
   which matter where something sticks to what an input moves; p NULL: PARAMETERS. */
void model_rates(double t, const double *x, const double *u, const int *modes, const double *du, const Parameters *p, double *dx)
{
    Field f;
    Input inputs[ROOM(INPUTS)];
    double constants[ROOM(2*INPUTS)], out[ROOM(LOADS)];
    field_at_point(&f, inputs, constants, u, du, p);
    for (int c = 0; c < CONTACTS; c++)
        f.modes[c] = modes[c], f.stuck[c] = modes[c] == 0;
    for (int c = 0; c < CONTACTS; c++)
        if (f.stuck[c])
            field_choose_floor(&f, c, t, x);
    field_rates(&f, t, x, out);
    memcpy(dx, out, STATES*sizeof *dx);
}

/* The modes at a point by the contact rule: the sign of the velocity, or at rest 0 while friction holds and the direction of the push else.
   scale is the smallest size of each state that matters (NULL: 1): friction that is singular at rest is looked at 1e-6 of it off rest. */
void model_modes(double t, const double *x, const double *u, const double *du, const Parameters *p, const double *scale, int *modes)
{
    Field f;
    Input inputs[ROOM(INPUTS)];
    double constants[ROOM(2*INPUTS)], ones[ROOM(STATES)];
    for (int j = 0; j < STATES; j++)
        ones[j] = 1.0;
    field_at_point(&f, inputs, constants, u, du, p);
    field_begin(&f, t, x, scale != NULL ? scale : ones);
    for (int c = 0; c < CONTACTS; c++)
        modes[c] = field_sign(&f, c);
}

/* Dormand and Prince's pair 5(4) with Hairer's interpolant. */
static const double NODE[7] = {0.0, 0.2, 0.3, 0.8, 8.0/9.0, 1.0, 1.0};
static const double STAGE[6][6] = {{0.2},
                                   {3.0/40.0, 9.0/40.0},
                                   {44.0/45.0, -56.0/15.0, 32.0/9.0},
                                   {19372.0/6561.0, -25360.0/2187.0, 64448.0/6561.0, -212.0/729.0},
                                   {9017.0/3168.0, -355.0/33.0, 46732.0/5247.0, 49.0/176.0, -5103.0/18656.0},
                                   {35.0/384.0, 0.0, 500.0/1113.0, 125.0/192.0, -2187.0/6784.0, 11.0/84.0}};
static const double ERROR[7] = {71.0/57600.0, 0.0, -71.0/16695.0, 71.0/1920.0, -17253.0/339200.0, 22.0/525.0, -1.0/40.0};
static const double DENSE[7] = {-12715105075.0/11282082432.0, 0.0, 87487479700.0/32700410799.0, -10690763975.0/1880347072.0,
                                701980252875.0/199316789632.0, -1453857185.0/822651844.0, 69997945.0/29380423.0};

typedef struct {
    double w[ROOM(CONTACTS)], rate[ROOM(CONTACTS)];
} Surfaces;

typedef struct {
    Field field;
    const Options *options;
    const double *times, *scale;
    int count, next;
    double *states;
    int *modes;
    double tolerance, t, h, longest, span, length, flutter_from;
    int flutter, steps;
    double x[ROOM(STATES)], end[ROOM(STATES)], k[7][ROOM(LOADS)], dense[ROOM(STATES)][5];
    bool interpolated;
    Surfaces here, there;
    double *breaks; /* falling */
    int break_count;
} Run;

/* What a step holds: no event, one at a fraction of the step, or something that only a shorter step can tell. */
typedef enum { NOTHING, EVENT, SHORTER } Search;

static void run_surfaces(Run *r, Surfaces *s)
{
    for (int c = 0; c < CONTACTS; c++)
        s->w[c] = W(&r->field, c), s->rate[c] = W_RATE(&r->field, c);
}

/* Rates and surfaces at the present point. */
static void run_settle(Run *r)
{
    field_rates(&r->field, r->t, r->x, r->k[0]);
    field_held_look(&r->field, r->t, r->x);
    run_surfaces(r, &r->here);
}

static double run_first_step(Run *r)
{
    double norm = 0.0, change = 0.0, moved[ROOM(STATES)], rates[ROOM(LOADS)];
    for (int i = 0; i < STATES; i++)
        norm = fmax(norm, fabs(r->k[0][i]/r->scale[i]));
    double h0 = norm > 1e-10 ? fmin(1e-3/norm, r->longest) : 1e-3*r->longest;
    for (int i = 0; i < STATES; i++)
        moved[i] = r->x[i] + h0*r->k[0][i];
    field_rates(&r->field, r->t + h0, moved, rates);
    for (int i = 0; i < STATES; i++)
        change = fmax(change, fabs((rates[i] - r->k[0][i])/h0/r->scale[i]));
    double largest = fmax(norm, change), h1 = largest > 1e-15 ? sqrt(0.1*pow(r->tolerance, 0.2)/largest) : h0;
    return fmin(fmin(h1, 100.0*h0), r->longest);
}

static void run_advance(Run *r, double h)
{
    r->length = h, r->interpolated = false;
    for (int stage = 1; stage < 7; stage++) {
        for (int i = 0; i < STATES; i++) {
            double sum = 0.0;
            for (int j = 0; j < stage; j++)
                sum += STAGE[stage - 1][j]*r->k[j][i];
            r->end[i] = r->x[i] + h*sum;
        }
        field_rates(&r->field, r->t + NODE[stage]*h, r->end, r->k[stage]);
    }
}

/* The state at a fraction of the step. */
static void run_inside(Run *r, double theta, double *x)
{
    if (!r->interpolated)
        for (int i = 0; i < STATES; i++) {
            double difference = r->end[i] - r->x[i], bend = r->length*r->k[0][i] - difference, fifth = 0.0;
            for (int j = 0; j < 7; j++)
                fifth += DENSE[j]*r->k[j][i];
            r->dense[i][0] = r->x[i], r->dense[i][1] = difference, r->dense[i][2] = bend;
            r->dense[i][3] = difference - r->length*r->k[6][i] - bend, r->dense[i][4] = r->length*fifth;
        }
    r->interpolated = true;
    double back = 1.0 - theta;
    for (int i = 0; i < STATES; i++) {
        const double *d = r->dense[i];
        x[i] = d[0] + theta*(d[1] + back*(d[2] + theta*(d[3] + back*d[4])));
    }
}

/* Positive while the mode of a contact may last. */
static double run_guard(Run *r, int c, double t, const double *x)
{
    Field *f = &r->field;
    if (f->stuck[c]) {
        field_hold(f, t, x);
        return 1.0 - fabs(f->modes[c]) + OVERLOAD;
    }
    field_held_look(f, t, x);
    return f->modes[c]*W(f, c);
}

static double guard_inside(Run *r, int c, double theta)
{
    double x[ROOM(STATES)];
    run_inside(r, theta, x);
    return run_guard(r, c, r->t + theta*r->length, x);
}

static double falling_inside(Run *r, int c, double theta)
{
    guard_inside(r, c, theta);
    return -r->field.modes[c]*W_RATE(&r->field, c);
}

/* The root of g between good (positive) and bad (negative), to 1e-10: the Illinois variant of false position. */
static double root(Run *r, int c, double good, double bad, double (*g)(Run *, int, double))
{
    double high = g(r, c, good), low = g(r, c, bad);
    int side = 0;
    for (int i = 0; i < 80; i++) {
        double middle = (good*low - bad*high)/(low - high);
        if (!(middle > fmin(good, bad) && middle < fmax(good, bad)))
            middle = 0.5*(good + bad);
        double value = g(r, c, middle);
        if (value == 0.0 || fabs(bad - good) <= 1e-10)
            return middle;
        if (value > 0.0) {
            good = middle, high = value;
            low *= side == 1 ? 0.5 : 1.0;
            side = 1;
        } else {
            bad = middle, low = value;
            high *= side == -1 ? 0.5 : 1.0;
            side = -1;
        }
    }
    return bad;
}

/* Where the guard is least between a and b, by the golden section, to 1e-5 of the interval. */
static double golden(Run *r, int c, double a, double b)
{
    double ratio = 0.5*(sqrt(5.0) - 1.0), left = b - ratio*(b - a), right = a + ratio*(b - a);
    double low = guard_inside(r, c, left), high = guard_inside(r, c, right);
    for (int i = 0; i < 24; i++) {
        if (low < high) {
            b = right, right = left, high = low;
            left = b - ratio*(b - a);
            low = guard_inside(r, c, left);
        } else {
            a = left, left = right, low = high;
            right = a + ratio*(b - a);
            high = guard_inside(r, c, right);
        }
    }
    return low < high ? left : right;
}

/* Where in the step a sticking contact is overloaded. */
static Search run_overload(Run *r, int c, double *theta)
{
    double reserve[6], good = 0.0, bad = -1.0;
    int least = 0;
    for (int i = 0; i < 6; i++) {
        reserve[i] = 1.0 - fabs(r->k[i][STATES + c]) + OVERLOAD;
        if (reserve[i] < reserve[least])
            least = i;
    }
    for (int i = 5; i > 0; i--)
        if (reserve[i] < 0.0)
            good = NODE[i - 1], bad = NODE[i];
    if (bad < 0.0 && least > 0 && least < 5) {
        double peak = golden(r, c, NODE[least - 1], NODE[least + 1]);
        if (guard_inside(r, c, peak) < 0.0)
            good = NODE[least - 1], bad = peak;
    }
    if (bad < 0.0)
        return NOTHING;
    *theta = guard_inside(r, c, good) <= 0.0 ? good : root(r, c, good, bad, guard_inside);
    return EVENT;
}

/* Where in the step a slipping contact reaches its surface; one that starts on it must leave first. */
static Search run_crossing(Run *r, int c, double *theta)
{
    Field *f = &r->field;
    double here = ON_SURFACE*f->speed[c], mode = f->modes[c];
    double start = mode*r->here.w[c], early = mode*r->here.rate[c], end = mode*r->there.w[c], late = mode*r->there.rate[c];
    if (start > here) {
        if (end < 0.0) {
            *theta = root(r, c, 0.0, 1.0, guard_inside);
            return EVENT;
        }
        if (early < 0.0 && late > 0.0) {
            double lowest = root(r, c, 0.0, 1.0, falling_inside);
            if (guard_inside(r, c, lowest) < 0.0) {
                *theta = root(r, c, 0.0, lowest, guard_inside);
                return EVENT;
            }
        }
    } else if (end < -here) {
        static const double looks[6] = {0.5, 0.25, 0.75, 0.125, 0.03, 0.005};
        for (int i = 0; i < 6; i++)
            if (guard_inside(r, c, looks[i]) > here) {
                *theta = root(r, c, looks[i], 1.0, guard_inside);
                return EVENT;
            }
        *theta = 1.0;
        return r->length > 1e-9*r->span ? SHORTER : EVENT;
    }
    return NOTHING;
}

/* The first guard that fails in the step. */
static Search run_first_event(Run *r, int *contact, double *theta)
{
    Search first = NOTHING;
    for (int c = 0; c < CONTACTS; c++) {
        double at;
        Search found = r->field.stuck[c] ? run_overload(r, c, &at) : run_crossing(r, c, &at);
        if (found == SHORTER)
            return SHORTER;
        if (found == EVENT && (first == NOTHING || at < *theta))
            first = EVENT, *contact = c, *theta = at;
    }
    return first;
}

/* Repeats the step so that it ends on the surface: Newton's method on its length. */
static void run_locate(Run *r, int c, double theta)
{
    Field *f = &r->field;
    bool stuck = f->stuck[c];
    double h = r->length, size = stuck ? OVERLOAD : ON_SURFACE*f->speed[c], delta = fmin(1e-4, 0.5*theta);
    double slope = (guard_inside(r, c, theta) - guard_inside(r, c, theta - delta))/(delta*h), length = theta*h;
    for (int i = 0; i < 4; i++) {
        run_advance(r, length);
        double g = run_guard(r, c, r->t + length, r->end);
        if (!stuck)
            slope = f->modes[c]*W_RATE(f, c);
        double change = -g/slope;
        if (fabs(g) <= size || !(fabs(change) <= 0.1*h) || length + change <= 0.0)
            break;
        length = fmin(length + change, h);
    }
    field_held_look(f, r->t + r->length, r->end);
    run_surfaces(r, &r->there);
}

/* The largest scaled error of the step just tried: at most 1 is good. */
static double run_error(Run *r)
{
    Field *f = &r->field;
    double errors[ROOM(LOADS)], worst = 0.0;
    for (int i = 0; i < LOADS; i++) {
        errors[i] = 0.0;
        for (int j = 0; j < 7; j++)
            errors[i] += ERROR[j]*r->k[j][i];
    }
    for (int i = 0; i < LOADS; i++) {
        int c = i - STATES;
        double scaled = 0.0;
        if (i < STATES) {
            scaled = fabs(r->length*errors[i])/(r->tolerance*fmax(r->scale[i], fmax(fabs(r->x[i]), fabs(r->end[i]))));
        } else if (f->stuck[c]) {
            scaled = fabs(errors[i])/LOAD_RESOLUTION;
        } else if (SHAPED[c]) {
            double e = 0.0, speed = fmax(fmax(fabs(r->here.w[c]), fabs(r->there.w[c])), fmax(f->floors[c], 1e-9*f->scale[c]));
            for (int j = 0; j < STATES; j++)
                e += NORMAL(f, c, j)*r->length*errors[j];
            scaled = fabs(e)/(SHAPE_RESOLUTION*r->tolerance*speed);
        }
        if (!isfinite(scaled))
            return INFINITY;
        worst = fmax(worst, scaled);
    }
    return worst;
}

/* If the failed step ends across a slipping contact's surface: the time to reach it in a straight line; infinite if it does not. */
static double run_overshoot(const Run *r)
{
    double least = INFINITY;
    for (int c = 0; c < CONTACTS; c++) {
        double reach = -r->here.w[c]/r->here.rate[c];
        if (!r->field.stuck[c] && r->field.modes[c]*r->there.w[c] < 0.0 && reach > 0.0)
            least = fmin(least, reach);
    }
    return least;
}

static void run_write(Run *r, const double *x)
{
    if (OUTPUTS > 0 && r->options->outputs != NULL)
        field_outputs(&r->field, r->times[r->next], x, r->options->outputs + (size_t)r->next*OUTPUTS);
    memcpy(r->states + (size_t)r->next*STATES, x, STATES*sizeof *x);
    for (int c = 0; c < CONTACTS; c++)
        r->modes[(size_t)r->next*CONTACTS + c] = field_sign(&r->field, c);
    r->next++;
}

static Status run_accept(Run *r)
{
    double t1 = r->t + r->length;
    while (r->next < r->count && r->times[r->next] <= t1) {
        double x[ROOM(STATES)];
        run_inside(r, (r->times[r->next] - r->t)/r->length, x);
        field_keep_at_rest(&r->field, r->times[r->next], x);
        run_write(r, x);
    }
    r->t = t1, r->here = r->there;
    memcpy(r->x, r->end, sizeof r->x);
    memcpy(r->k[0], r->k[6], sizeof r->k[0]);
    for (int c = 0; c < CONTACTS; c++)
        r->field.speed[c] = fmax(r->field.speed[c], fabs(r->here.w[c]));
    field_keep_at_rest(&r->field, r->t, r->x);
    for (int i = 0; i < STATES; i++)
        if (!(fabs(r->x[i]) <= 1e24*r->scale[i]))
            return NO_BOUND;
    return FINE;
}

static void run_record(Run *r, const int *before)
{
    for (int c = 0; c < CONTACTS; c++) {
        int after = field_sign(&r->field, c);
        if (before[c] != after && r->options->event != NULL)
            r->options->event(r->t, c, before[c], after, r->options->context);
    }
}

/* New modes at the present point, and whatever else is due at the same instant. */
static Status run_pass(Run *r, int due)
{
    Field *f = &r->field;
    bool done[ROOM(CONTACTS)] = {false};
    if (r->t - r->flutter_from > 1e-4*r->span)
        r->flutter = 0, r->flutter_from = r->t;
    while (due >= 0) {
        int before[ROOM(CONTACTS)];
        if (++r->flutter > 200)
            return FLUTTER;
        for (int c = 0; c < CONTACTS; c++)
            before[c] = field_sign(f, c);
        if (f->stuck[due]) {
            field_release(f, due, r->t, r->x);
        } else {
            field_held_look(f, r->t, r->x);
            field_project(f, due, r->x);
            field_resolve(f, &due, 1, r->t, r->x);
        }
        run_record(r, before);
        run_settle(r);
        done[due] = true;
        due = -1;
        for (int c = CONTACTS - 1; c >= 0; c--)
            if (!done[c] && !f->stuck[c] && f->modes[c]*r->here.w[c] <= ON_SURFACE*f->speed[c] && f->modes[c]*r->here.rate[c] < 0.0)
                due = c;
    }
    return FINE;
}

/* Goes on behind a jump or a corner of an input, if the present point is one. */
static void run_turn_corner(Run *r)
{
    int before[ROOM(CONTACTS)];
    if (r->break_count == 0 || r->breaks[r->break_count - 1] > r->t)
        return;
    while (r->break_count > 0 && r->breaks[r->break_count - 1] <= r->t)
        r->break_count--;
    r->field.left_of = r->break_count > 0 ? r->breaks[r->break_count - 1] : INFINITY;
    for (int c = 0; c < CONTACTS; c++)
        before[c] = field_sign(&r->field, c);
    field_reconsider(&r->field, r->t, r->x);
    run_record(r, before);
    run_settle(r);
}

/* One accepted step: up to its end, the next corner of an input, or the first event in it. */
static Status run_step(Run *r)
{
    double end = r->times[r->count - 1], target = r->break_count > 0 ? fmin(r->breaks[r->break_count - 1], end) : end;
    double tiny = 1e-15*fmax(fmax(fabs(r->t), fabs(end)), r->span);
    for (;;) {
        Status status;
        double h = fmin(r->h, r->longest), theta = 0.0;
        int contact = -1;
        if (++r->steps > 2000000)
            return TOO_MANY_STEPS;
        if (target - r->t - h < 1e-3*h)
            h = target - r->t;
        run_advance(r, h);
        field_held_look(&r->field, r->t + h, r->end);
        run_surfaces(r, &r->there);
        double error = run_error(r);
        if (error <= 1.0) {
            Search found = run_first_event(r, &contact, &theta);
            if (found == NOTHING) {
                double growth = error > 0.0 ? fmin(fmax(0.9*pow(error, -0.2), 0.2), 5.0) : 5.0;
                r->h = fmax(h*growth, h < r->h ? r->h : 0.0);
                status = run_accept(r);
                run_turn_corner(r);
                return status;
            }
            if (found == EVENT) {
                if (theta > 0.0) {
                    run_locate(r, contact, theta);
                    status = run_accept(r);
                    if (status != FINE)
                        return status;
                }
                status = run_pass(r, contact);
                run_turn_corner(r);
                r->h = run_first_step(r);
                return status;
            }
            r->h = 0.5*h;
        } else {
            double shrink = isfinite(error) ? fmin(fmax(0.9*pow(error, -0.2), 0.1), 0.9) : 0.1, reach = run_overshoot(r);
            r->h = h*shrink;
            if (isfinite(reach))
                r->h = fmin(fmax(r->h, 0.5*fmin(h, reach)), 0.9*h);
        }
        if (r->h <= tiny)
            return STEP_COLLAPSED;
    }
}

static int falling(const void *a, const void *b)
{
    double left = *(const double *)a, right = *(const double *)b;
    return left < right ? 1 : left > right ? -1 : 0;
}

/* Where an input jumps or turns a corner within the run; NULL without memory. */
static double *all_breaks(const Input *inputs, const Options *options, double from, double to, int *count)
{
    size_t room = 1 + (size_t)options->break_count;
    for (int k = 0; k < INPUTS; k++)
        room += (size_t)inputs[k].count;
    double *breaks = malloc(room*sizeof *breaks);
    *count = 0;
    for (int i = 0; breaks != NULL && i < options->break_count; i++)
        breaks[(*count)++] = options->breaks[i];
    for (int k = 0; breaks != NULL && k < INPUTS; k++)
        for (int i = 0; i < inputs[k].count && inputs[k].kind != CUBIC; i++) {
            double t = inputs[k].times[i], before[2], after[2];
            read_input(&inputs[k], nextafter(t, -INFINITY), &before[0], &before[1]);
            read_input(&inputs[k], t, &after[0], &after[1]);
            if (before[inputs[k].kind == LINEAR] != after[inputs[k].kind == LINEAR])
                breaks[(*count)++] = t;
        }
    int kept = 0;
    for (int i = 0; i < *count; i++)
        if (breaks[i] > from && breaks[i] < to)
            breaks[kept++] = breaks[i];
    *count = kept;
    if (breaks != NULL)
        qsort(breaks, (size_t)kept, sizeof *breaks, falling);
    return breaks;
}

static Status run_all(const double *times, int count, const double *start, double t0, const Input *inputs, const Parameters *p,
                      const Options *options, double tolerance, const double *scale, double *states, int *modes)
{
    static const double unit = 5e-324;
    Run *r = malloc(sizeof *r);
    if (r == NULL)
        return NO_MEMORY;
    memset(r, 0, sizeof *r);
    field_new(&r->field, inputs, p);
    r->options = options, r->times = times, r->count = count, r->scale = scale, r->tolerance = tolerance;
    r->states = states, r->modes = modes, r->t = t0, r->flutter_from = t0;
    memcpy(r->x, start, STATES*sizeof *start);
    r->span = fmax(times[count - 1] - t0, unit);
    r->longest = 32.0*r->span/count;
    for (int k = 0; k < INPUTS; k++) {
        int last = inputs[k].count - 1;
        if (last > 0 && inputs[k].kind == CUBIC)
            r->longest = fmin(r->longest, 8.0*(inputs[k].times[last] - inputs[k].times[0])/last);
    }
    double *breaks = r->breaks = all_breaks(inputs, options, t0, t0 + r->span, &r->break_count);
    Status status = breaks == NULL ? NO_MEMORY : FINE;
    if (status == FINE) {
        r->field.left_of = r->break_count > 0 ? r->breaks[r->break_count - 1] : INFINITY;
        field_begin(&r->field, r->t, r->x, scale);
        run_settle(r);
        r->h = run_first_step(r);
        while (r->next < count && times[r->next] <= r->t) {
            double x[ROOM(STATES)];
            for (int i = 0; i < STATES; i++)
                x[i] = r->x[i] + (times[r->next] - r->t)*r->k[0][i];
            run_write(r, x);
        }
    }
    while (status == FINE && r->next < count)
        status = run_step(r);
    free(breaks);
    free(r);
    return status;
}

/* The motion at the given times (which do not decrease), from the state `start` at time t0. states: room for count rows of STATES numbers; modes: the
   same of CONTACTS. p NULL: PARAMETERS; options NULL: model_options(). */
Status model_simulate(const double *times, int count, const double *start, double t0, const Input *inputs, const Parameters *p,
                      const Options *options, double *states, int *modes)
{
    Options usual = model_options(), coarse;
    double scale[ROOM(STATES)];
    options = options != NULL ? options : &usual;
    p = p != NULL ? p : &PARAMETERS;
    if (count <= 0)
        return FINE;
    coarse = *options, coarse.event = NULL, coarse.outputs = NULL;
    if (options->scale != NULL) {
        memcpy(scale, options->scale, STATES*sizeof *scale);
    } else {
        /* The largest value of each state in a coarse run; friction that is singular at rest is too steep for the smallest scales. */
        static const double smallest[4] = {1e-9, 1e-6, 1e-3, 1.0};
        Status status = STEP_COLLAPSED;
        int tried = -1;
        while ((status == STEP_COLLAPSED || status == TOO_MANY_STEPS || status == FLUTTER) && tried < 3) {
            tried++;
            for (int j = 0; j < STATES; j++)
                scale[j] = smallest[tried];
            status = run_all(times, count, start, t0, inputs, p, &coarse, 1e-4, scale, states, modes);
        }
        if (status != FINE)
            return status;
        for (int j = 0; j < STATES; j++) {
            double size = 0.0;
            for (int i = 0; i < count; i++)
                size = fmax(size, fabs(states[(size_t)i*STATES + j]));
            /* What is smaller is rounding, as of a mass that sticks throughout. */
            scale[j] = size > 1e-4*smallest[tried] ? size : 1.0;
        }
    }
    return run_all(times, count, start, t0, inputs, p, options, options->tolerance, scale, states, modes);
}

#ifdef PHISINDY_MAIN
/* CSV with headings on standard input (t and the inputs; of several records, told apart by a column `record`, the one of START; other columns are
   ignored); the motion as CSV on standard output. */

static int fail(const char *what, const char *which)
{
    fprintf(stderr, "%s%s\n", what, which);
    return 1;
}

/* A line without its end, of any length; NULL at the end of the input. */
static char *line_of(FILE *file)
{
    size_t room = 256, used = 0;
    char *line = malloc(room);
    int c = 0;
    while (line != NULL && (c = getc(file)) != EOF && c != '\n') {
        if (used + 2 > room) {
            char *longer = realloc(line, room *= 2);
            if (longer == NULL)
                free(line);
            line = longer;
        }
        if (line != NULL && c != '\r')
            line[used++] = (char)c;
    }
    if (line != NULL && used == 0 && c == EOF)
        return free(line), NULL;
    if (line != NULL)
        line[used] = '\0';
    return line;
}

/* The length of a cell; one in double quotes may hold commas. */
static size_t cell_length(const char *cell)
{
    size_t length = 0;
    if (cell[0] == '"')
        for (length = 1; cell[length] != '\0' && (cell[length] != '"' || cell[length + 1] == '"'); length++)
            if (cell[length] == '"')
                length++;
    return length + strcspn(cell + length, ",");
}

/* Whether a cell holds a text, with or without quotes round it. */
static bool cell_is(const char *cell, const char *text)
{
    size_t length = cell_length(cell), quotes = cell[0] == '"' ? 1 : 0;
    return length == strlen(text) + 2*quotes && strncmp(cell + quotes, text, length - 2*quotes) == 0;
}

int main(void)
{
    static const char *statuses[] = {"", "not enough memory", "more than two million steps", "the step length collapsed",
                                     "the motion grows without bound", "a contact changes sign without end"};
    int column[1 + INPUTS], record_at = -1, count = 0, room = 0;
    double *rows = NULL;
    char *line = line_of(stdin);
    for (int k = 0; k <= INPUTS; k++) {
        const char *name = k == 0 ? "t" : INPUT_NAMES[k - 1];
        column[k] = -1;
        const char *cell = line;
        for (int at = 0; cell != NULL; at++) {
            size_t length = cell_length(cell);
            if (cell_is(cell, name))
                column[k] = at;
            if (cell_is(cell, "record"))
                record_at = at;
            cell = cell[length] == ',' ? cell + length + 1 : NULL;
        }
        if (column[k] < 0)
            return fail("standard input has no column ", name);
    }
    free(line);
    while ((line = line_of(stdin)) != NULL) {
        if (count == room) {
            double *more = realloc(rows, (size_t)(room = 2*room + 1024)*(1 + INPUTS)*sizeof *rows);
            if (more == NULL)
                return fail(statuses[NO_MEMORY], "");
            rows = more;
        }
        const char *cell = line;
        int found = 0;
        bool other = false;
        for (int at = 0; cell != NULL; at++) {
            other = other || (at == record_at && !cell_is(cell, RECORD));
            for (int k = 0; k <= INPUTS; k++)
                if (column[k] == at) {
                    char *end;
                    rows[(size_t)count*(1 + INPUTS) + k] = strtod(cell, &end);
                    if (end == cell)
                        return fail("not a number: ", cell);
                    found++;
                }
            size_t length = cell_length(cell);
            cell = cell[length] == ',' ? cell + length + 1 : NULL;
        }
        if (found <= INPUTS)
            return fail("too few columns: ", line);
        free(line);
        count += other ? 0 : 1;
    }
    if (count == 0)
        return fail("no rows on standard input", "");
    /* Columns: time, values and slopes of each input, room for the spline, the states, the outputs. */
    double *columns = malloc((size_t)count*(2 + 2*INPUTS + STATES + OUTPUTS)*sizeof *columns);
    int *modes = malloc((size_t)count*ROOM(CONTACTS)*sizeof *modes);
    if (columns == NULL || modes == NULL)
        return fail(statuses[NO_MEMORY], "");
    double *times = columns, *above = columns + (size_t)count*(1 + 2*INPUTS), *states = above + count;
    double *shown = states + (size_t)count*STATES;
    Options options = model_options();
    options.outputs = shown;
    for (int i = 0; i < count; i++)
        times[i] = rows[(size_t)i*(1 + INPUTS)];
    for (int i = 1; i < count; i++)
        if (!(times[i] > times[i - 1]))
            return fail("the times on standard input must increase", "");
    Input inputs[ROOM(INPUTS)];
    for (int k = 0; k < INPUTS; k++) {
        double *values = columns + (size_t)count*(1 + 2*k), *slopes = values + count;
        for (int i = 0; i < count; i++)
            values[i] = rows[(size_t)i*(1 + INPUTS) + 1 + k];
        if (INPUT_KINDS[k] == CUBIC)
            model_spline(count, times, values, slopes, above);
        Input sampled = {count, times, values, slopes, (Kind)INPUT_KINDS[k], NULL, NULL, NULL};
        inputs[k] = sampled;
    }
    for (int j = 0; j < STATES; j++)
        if (isnan(START[j]))
            return fail("START has no number for ", STATE_NAMES[j]);
    Status status = model_simulate(times, count, START, isnan(START_TIME) ? times[0] : START_TIME, inputs, NULL, &options, states, modes);
    if (status != FINE)
        return fail(statuses[status], "");
    printf("t");
    for (int j = 0; j < STATES; j++)
        printf(",%s", STATE_NAMES[j]);
    for (int j = 0; j < OUTPUTS; j++)
        printf(",%s", OUTPUT_NAMES[j]);
    for (int c = 0; c < CONTACTS; c++)
        printf(",mode %s", CONTACT_NAMES[c]);
    for (int i = 0; i < count; i++) {
        printf("\n%.17g", times[i]);
        for (int j = 0; j < STATES; j++)
            printf(",%.17g", states[(size_t)i*STATES + j]);
        for (int j = 0; j < OUTPUTS; j++)
            printf(",%.17g", shown[(size_t)i*OUTPUTS + j]);
        for (int c = 0; c < CONTACTS; c++)
            printf(",%d", modes[(size_t)i*CONTACTS + c]);
    }
    printf("\n");
    free(rows), free(columns), free(modes);
    return 0;
}
#endif
