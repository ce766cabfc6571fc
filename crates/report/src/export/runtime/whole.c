Options model_options(void)
{
    Options usual = {USUAL_TOLERANCE, NULL, NULL, 0, NULL, NULL, NULL};
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
