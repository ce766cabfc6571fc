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
