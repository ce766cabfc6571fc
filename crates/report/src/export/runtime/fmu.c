/* The functions of FMI 3.0 (https://fmi-standard.org/docs/3.0/): model exchange, and co-simulation with the steps above. */

#include <stdint.h>

#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

/* Of several models in one program each has its prefix. */
#ifdef FMI3_FUNCTION_PREFIX
#define JOINED(prefix, name) prefix##name
#define PREFIXED(prefix, name) JOINED(prefix, name)
#define API(name) PREFIXED(FMI3_FUNCTION_PREFIX, name)
#else
#define API(name) name
#endif

typedef enum { FMI_OK, FMI_WARNING, FMI_DISCARD, FMI_ERROR, FMI_FATAL } FmiStatus;
typedef uint32_t Reference; /* of a variable, as modelDescription.xml has it */
typedef void (*Logger)(void *environment, FmiStatus status, const char *category, const char *message);

/* References, kind after kind. */
enum {
    AT_TIME = 0,
    AT_STATE = 1,
    AT_RATE = AT_STATE + STATES,
    AT_INPUT = AT_RATE + STATES,
    AT_SLOPE = AT_INPUT + INPUTS,
    AT_OUTPUT = AT_SLOPE + INPUTS,
    AT_PARAMETER = AT_OUTPUT + OUTPUTS,
    AT_INDICATOR = AT_PARAMETER + PARAMETER_COUNT,
    AT_MODE = AT_INDICATOR + CONTACTS, /* the only integers */
    AT_END = AT_MODE + CONTACTS
};

/* Phases of an instance, one bit each. */
enum { MADE = 1, STARTING = 2, EVENTS = 4, CONTINUOUS = 8, STEPPING = 16, OVER = 32, ANY = 63 };

/* An input: its value at a time, and how fast it goes on from there. */
typedef struct {
    double value, slope, since;
} Held;

/* All that changes. It is copied as a whole; connect() sets the pointers in it. */
typedef struct {
    Run run;
    Parameters parameters;
    Held held[ROOM(INPUTS)];
    double begin[ROOM(CONTACTS)]; /* w of each contact when the present event was reached */
    double outputs[ROOM(OUTPUTS)], end;
    double coarse; /* the tolerance of an importer's own steps, where it tells one */
    double sampled[ROOM(STATES)];
    int sampled_modes[ROOM(CONTACTS)];
    bool fresh;   /* rates, surfaces and outputs are those of the present point */
    bool changed; /* an input or a parameter is not what it was in the last step or event */
    int phase;
} Present;

typedef struct {
    Present now;
    Input inputs[ROOM(INPUTS)];
    Options options;
    bool exchange; /* model exchange, else co-simulation */
    Logger log;
    void *environment;
} Instance;

static double held_value(double t, void *context)
{
    const Held *u = context;
    return u->slope != 0.0 ? u->value + u->slope*(t - u->since) : u->value;
}

static double held_slope(double t, void *context) { return (void)t, ((const Held *)context)->slope; }

static FmiStatus refuse(const Instance *i, const char *what)
{
    if (i != NULL && i->log != NULL)
        i->log(i->environment, FMI_ERROR, "logStatusError", what);
    return FMI_ERROR;
}

/* Returns from a function that may not be called in the present phase. */
#define NEED(phases) \
    Instance *i = instance; \
    if (i == NULL) \
        return FMI_ERROR; \
    if ((i->now.phase & (phases)) == 0) \
        return refuse(i, "this function may not be called now: the standard asks for another state of the instance")

static FmiStatus ended(const Instance *i, Status status)
{
    static const char *why[] = {"", "not enough memory", "more than two million steps", "the step length collapsed",
                                "the motion grows without bound", "a contact changes sign without end"};
    return status == FINE ? FMI_OK : refuse(i, why[status]);
}

/* Points into the instance itself, which a copied state has from another place. */
static void connect(Instance *i)
{
    Run *r = &i->now.run;
    r->field.inputs = i->inputs, r->field.parameters = &i->now.parameters;
    r->options = &i->options, r->scale = NOMINAL;
    r->times = &i->now.end, r->states = i->now.sampled, r->modes = i->now.sampled_modes;
    r->breaks = NULL, r->break_count = 0;
    for (int k = 0; k < INPUTS; k++) {
        Input held = {0, NULL, NULL, NULL, HOLD, held_value, held_slope, &i->now.held[k]};
        i->inputs[k] = held;
    }
}

/* Everything as modelDescription.xml says. */
static void reset(Instance *i)
{
    memset(&i->now, 0, sizeof i->now);
    i->now.parameters = PARAMETERS;
    field_new(&i->now.run.field, i->inputs, &i->now.parameters);
    memcpy(i->now.run.x, START, STATES*sizeof *START);
    i->now.run.tolerance = USUAL_TOLERANCE;
    i->now.run.span = i->now.run.longest = 1.0;
    i->now.changed = true, i->now.phase = MADE;
    connect(i);
}

/* Rates, surfaces and outputs at the present point; before the start is fixed also the modes. */
static void look(Instance *i)
{
    Run *r = &i->now.run;
    if (i->now.fresh)
        return;
    for (int k = 0; k < INPUTS; k++)
        i->now.held[k].since = r->t;
    if ((i->now.phase & (MADE | STARTING)) != 0) {
        field_new(&r->field, i->inputs, &i->now.parameters);
        field_begin(&r->field, r->t, r->x, NOMINAL);
    }
    run_settle(r);
    if (OUTPUTS > 0)
        field_outputs(&r->field, r->t, r->x, i->now.outputs);
    i->now.fresh = true;
}

/* How far behind its surface an importer meets a contact that came to rest: half of the margin by which friction goes on smoothly there, or what
   the importer's own steps may be wrong by. */
static double behind(const Instance *i, int c)
{
    const Field *f = &i->now.run.field;
    return fmax(0.5*f->margins[c], i->now.coarse*f->scale[c]);
}

/* Positive while the mode of a contact may last. */
static double indicator(const Instance *i, int c)
{
    const Run *r = &i->now.run;
    const Field *f = &r->field;
    if (f->stuck[c])
        return 1.0 - fabs(r->k[0][STATES + c]) + OVERLOAD;
    return (f->modes[c]*r->here.w[c] + behind(i, c))/f->scale[c];
}

/* A contact whose mode lasts no longer; -1 for none. */
static int due(const Instance *i)
{
    for (int c = 0; c < CONTACTS; c++)
        if (!(indicator(i, c) > 0.0))
            return c;
    return -1;
}

/* What an input tore off or carried across its surface since the event was reached slips; what sticks is decided anew. */
static void tear(Instance *i)
{
    Run *r = &i->now.run;
    Field *f = &r->field;
    field_look(f, r->t, r->x);
    for (int c = 0; c < CONTACTS; c++) {
        double w = W(f, c), far = TORN*f->speed[c];
        if (fabs(w - i->now.begin[c]) > far && (f->stuck[c] ? fabs(w) > far : w*f->modes[c] < -far))
            f->stuck[c] = false, f->modes[c] = copysign(1.0, w);
    }
    field_resolve(f, NULL, 0, r->t, r->x);
}

EXPORTED const char *API(fmi3GetVersion)(void) { return "3.0"; }

EXPORTED FmiStatus API(fmi3SetDebugLogging)(void *instance, bool on, size_t count, const char *const categories[])
{
    (void)on, (void)count, (void)categories;
    return instance != NULL ? FMI_OK : FMI_ERROR;
}

static void *made(const char *token, bool exchange, void *environment, Logger log)
{
    Instance *i = NULL;
    if (token == NULL || strcmp(token, TOKEN) != 0) {
        if (log != NULL)
            log(environment, FMI_ERROR, "logStatusError", "the instantiation token is that of another model");
        return NULL;
    }
    i = calloc(1, sizeof *i);
    if (i == NULL)
        return NULL;
    i->options.tolerance = USUAL_TOLERANCE;
    i->exchange = exchange, i->log = log, i->environment = environment;
    reset(i);
    return i;
}

EXPORTED void *API(fmi3InstantiateModelExchange)(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                                 void *environment, Logger log)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    return made(token, true, environment, log);
}

EXPORTED void *API(fmi3InstantiateCoSimulation)(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                                bool events, bool early, const Reference required[], size_t count,
                                                void *environment, Logger log, void (*update)(void))
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)count, (void)update;
    return made(token, false, environment, log);
}

EXPORTED void *API(fmi3InstantiateScheduledExecution)(const char *name, const char *token, const char *resources, bool visible,
                                                      bool logging, void *environment, Logger log, void (*clock)(void),
                                                      void (*lock)(void), void (*unlock)(void))
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock, (void)lock, (void)unlock;
    if (log != NULL)
        log(environment, FMI_ERROR, "logStatusError", "the model has no clocks: there is no scheduled execution");
    return NULL;
}

EXPORTED void API(fmi3FreeInstance)(void *instance) { free(instance); }

EXPORTED FmiStatus API(fmi3EnterInitializationMode)(void *instance, bool has_tolerance, double tolerance, double start, bool has_stop,
                                                    double stop)
{
    NEED(MADE);
    Run *r = &i->now.run;
    if (!isfinite(start) || (has_stop && !(stop >= start)))
        return refuse(i, "the start and stop times are no times");
    if (has_tolerance && tolerance > 0.0)
        r->tolerance = i->now.coarse = fmin(fmax(tolerance, 1e-13), 1e-3);
    r->t = r->flutter_from = start;
    r->span = has_stop && stop > start ? stop - start : 1.0;
    i->now.phase = STARTING, i->now.fresh = false;
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3ExitInitializationMode)(void *instance)
{
    NEED(STARTING);
    i->now.fresh = false;
    look(i);
    i->now.phase = i->exchange ? EVENTS : STEPPING;
    memcpy(i->now.begin, i->now.run.here.w, sizeof i->now.begin);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3Terminate)(void *instance)
{
    NEED(EVENTS | CONTINUOUS | STEPPING);
    i->now.phase = OVER;
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3Reset)(void *instance)
{
    NEED(ANY);
    reset(i);
    return FMI_OK;
}

/* Reading and writing variables. */

EXPORTED FmiStatus API(fmi3GetFloat64)(void *instance, const Reference of[], size_t count, double values[], size_t room)
{
    NEED(ANY);
    if (count != room || (count > 0 && (of == NULL || values == NULL)))
        return refuse(i, "as many values as variables");
    Run *r = &i->now.run;
    for (size_t n = 0; n < count; n++) {
        int v = of[n] < AT_MODE ? (int)of[n] : -1;
        if (v >= AT_RATE && !(v >= AT_INPUT && v < AT_OUTPUT) && !(v >= AT_PARAMETER && v < AT_INDICATOR))
            look(i);
        if (v < 0)
            return refuse(i, "there is no such variable of type Float64");
        else if (v >= AT_INDICATOR)
            values[n] = indicator(i, v - AT_INDICATOR);
        else if (v >= AT_PARAMETER)
            memcpy(&values[n], (const char *)&i->now.parameters + (size_t)(v - AT_PARAMETER)*sizeof(double), sizeof(double));
        else if (v >= AT_OUTPUT)
            values[n] = i->now.outputs[v - AT_OUTPUT];
        else if (v >= AT_SLOPE)
            values[n] = i->now.held[v - AT_SLOPE].slope;
        else if (v >= AT_INPUT)
            values[n] = i->now.held[v - AT_INPUT].value;
        else if (v >= AT_RATE)
            values[n] = r->k[0][v - AT_RATE];
        else
            values[n] = v >= AT_STATE ? r->x[v - AT_STATE] : r->t;
    }
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3SetFloat64)(void *instance, const Reference of[], size_t count, const double values[], size_t room)
{
    NEED(MADE | STARTING | EVENTS | CONTINUOUS | STEPPING);
    if (count != room || (count > 0 && (of == NULL || values == NULL)))
        return refuse(i, "as many values as variables");
    for (size_t n = 0; n < count; n++) {
        int v = of[n] < AT_MODE ? (int)of[n] : -1;
        double *to = NULL;
        if (!isfinite(values[n]))
            return refuse(i, "a value is not a number");
        if (v >= AT_STATE && v < AT_RATE && (i->now.phase & (MADE | STARTING)) != 0)
            to = &i->now.run.x[v - AT_STATE];
        else if (v >= AT_INPUT && v < AT_SLOPE)
            to = &i->now.held[v - AT_INPUT].value;
        else if (v >= AT_SLOPE && v < AT_OUTPUT)
            to = &i->now.held[v - AT_SLOPE].slope;
        else if (v >= AT_PARAMETER && v < AT_INDICATOR && i->now.phase != CONTINUOUS)
            to = (double *)&i->now.parameters + (v - AT_PARAMETER);
        if (to == NULL)
            return refuse(i, "there is no variable of type Float64 that may be set now under this reference");
        i->now.changed = i->now.changed || *to != values[n];
        i->now.fresh = i->now.fresh && *to == values[n];
        *to = values[n];
    }
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3GetInt32)(void *instance, const Reference of[], size_t count, int32_t values[], size_t room)
{
    NEED(ANY);
    if (count != room || (count > 0 && (of == NULL || values == NULL)))
        return refuse(i, "as many values as variables");
    look(i);
    for (size_t n = 0; n < count; n++) {
        if (of[n] < AT_MODE || of[n] >= AT_END)
            return refuse(i, "there is no such variable of type Int32");
        values[n] = field_sign(&i->now.run.field, (int)of[n] - AT_MODE);
    }
    return FMI_OK;
}

/* The model has no variables of these types. */
static FmiStatus none_of(void *instance, size_t count)
{
    NEED(ANY);
    return count == 0 ? FMI_OK : refuse(i, "the model has no variable of this type that could be read or set");
}

#define NO_SETTER(name, type) \
    EXPORTED FmiStatus API(fmi3Set##name)(void *instance, const Reference of[], size_t count, const type values[], size_t room) \
    { \
        return (void)of, (void)values, (void)room, none_of(instance, count); \
    }
#define NO_VALUES(name, type) \
    EXPORTED FmiStatus API(fmi3Get##name)(void *instance, const Reference of[], size_t count, type values[], size_t room) \
    { \
        return (void)of, (void)values, (void)room, none_of(instance, count); \
    } \
    NO_SETTER(name, type)

NO_VALUES(Float32, float)
NO_VALUES(Int8, int8_t)
NO_VALUES(UInt8, uint8_t)
NO_VALUES(Int16, int16_t)
NO_VALUES(UInt16, uint16_t)
NO_SETTER(Int32, int32_t)
NO_VALUES(UInt32, uint32_t)
NO_VALUES(Int64, int64_t)
NO_VALUES(UInt64, uint64_t)
NO_VALUES(Boolean, bool)

EXPORTED FmiStatus API(fmi3GetString)(void *instance, const Reference of[], size_t count, const char *values[], size_t room)
{
    return (void)of, (void)values, (void)room, none_of(instance, count);
}

EXPORTED FmiStatus API(fmi3SetString)(void *instance, const Reference of[], size_t count, const char *const values[], size_t room)
{
    return (void)of, (void)values, (void)room, none_of(instance, count);
}

EXPORTED FmiStatus API(fmi3GetBinary)(void *instance, const Reference of[], size_t count, size_t sizes[], const uint8_t *values[],
                                      size_t room)
{
    return (void)of, (void)sizes, (void)values, (void)room, none_of(instance, count);
}

EXPORTED FmiStatus API(fmi3SetBinary)(void *instance, const Reference of[], size_t count, const size_t sizes[],
                                      const uint8_t *const values[], size_t room)
{
    return (void)of, (void)sizes, (void)values, (void)room, none_of(instance, count);
}

EXPORTED FmiStatus API(fmi3GetClock)(void *instance, const Reference of[], size_t count, bool values[])
{
    return (void)of, (void)values, none_of(instance, count);
}

EXPORTED FmiStatus API(fmi3SetClock)(void *instance, const Reference of[], size_t count, const bool values[])
{
    return (void)of, (void)values, none_of(instance, count);
}

/* What a model without arrays, clocks and derivatives of its own is asked for in vain. */
static FmiStatus lacks(void *instance, const char *what)
{
    NEED(ANY);
    return refuse(i, what);
}

EXPORTED FmiStatus API(fmi3GetNumberOfVariableDependencies)(void *instance, Reference of, size_t *count)
{
    return (void)of, (void)count, lacks(instance, "dependencies stand in modelDescription.xml");
}

EXPORTED FmiStatus API(fmi3GetVariableDependencies)(void *instance, Reference of, size_t elements[], Reference on[], size_t parts[],
                                                    int kinds[], size_t room)
{
    (void)of, (void)elements, (void)on, (void)parts, (void)kinds, (void)room;
    return lacks(instance, "dependencies stand in modelDescription.xml");
}

EXPORTED FmiStatus API(fmi3GetDirectionalDerivative)(void *instance, const Reference of[], size_t count, const Reference by[], size_t known,
                                                     const double seed[], size_t seeds, double out[], size_t room)
{
    (void)of, (void)count, (void)by, (void)known, (void)seed, (void)seeds, (void)out, (void)room;
    return lacks(instance, "the model gives no directional derivatives");
}

EXPORTED FmiStatus API(fmi3GetAdjointDerivative)(void *instance, const Reference of[], size_t count, const Reference by[], size_t known,
                                                 const double seed[], size_t seeds, double out[], size_t room)
{
    (void)of, (void)count, (void)by, (void)known, (void)seed, (void)seeds, (void)out, (void)room;
    return lacks(instance, "the model gives no adjoint derivatives");
}

EXPORTED FmiStatus API(fmi3GetOutputDerivatives)(void *instance, const Reference of[], size_t count, const int32_t orders[],
                                                 double values[], size_t room)
{
    (void)of, (void)count, (void)orders, (void)values, (void)room;
    return lacks(instance, "the model gives no derivatives of outputs");
}

EXPORTED FmiStatus API(fmi3EnterConfigurationMode)(void *instance) { return lacks(instance, "the model has no structural parameters"); }
EXPORTED FmiStatus API(fmi3ExitConfigurationMode)(void *instance) { return lacks(instance, "the model has no structural parameters"); }

#define NO_CLOCK(name, type) \
    EXPORTED FmiStatus API(fmi3##name)(void *instance, const Reference of[], size_t count, type values[]) \
    { \
        return (void)of, (void)count, (void)values, lacks(instance, "the model has no clocks"); \
    }
#define NO_FRACTION(name, type) \
    EXPORTED FmiStatus API(fmi3##name)(void *instance, const Reference of[], size_t count, type counters[], type resolutions[]) \
    { \
        return (void)of, (void)count, (void)counters, (void)resolutions, lacks(instance, "the model has no clocks"); \
    }

NO_CLOCK(GetShiftDecimal, double)
NO_CLOCK(SetShiftDecimal, const double)
NO_CLOCK(SetIntervalDecimal, const double)
NO_FRACTION(GetShiftFraction, uint64_t)
NO_FRACTION(SetShiftFraction, const uint64_t)
NO_FRACTION(SetIntervalFraction, const uint64_t)

EXPORTED FmiStatus API(fmi3GetIntervalDecimal)(void *instance, const Reference of[], size_t count, double intervals[], int qualifiers[])
{
    return (void)of, (void)count, (void)intervals, (void)qualifiers, lacks(instance, "the model has no clocks");
}

EXPORTED FmiStatus API(fmi3GetIntervalFraction)(void *instance, const Reference of[], size_t count, uint64_t counters[],
                                                uint64_t resolutions[], int qualifiers[])
{
    (void)of, (void)count, (void)counters, (void)resolutions, (void)qualifiers;
    return lacks(instance, "the model has no clocks");
}

EXPORTED FmiStatus API(fmi3ActivateModelPartition)(void *instance, Reference clock, double time)
{
    return (void)clock, (void)time, lacks(instance, "the model has no clocks");
}

/* States of the instance as a whole. */

EXPORTED FmiStatus API(fmi3GetFMUState)(void *instance, void **state)
{
    NEED(ANY);
    if (state == NULL)
        return refuse(i, "no place for the state");
    if (*state == NULL)
        *state = malloc(sizeof(Present));
    if (*state == NULL)
        return refuse(i, "not enough memory");
    memcpy(*state, &i->now, sizeof(Present));
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3SetFMUState)(void *instance, void *state)
{
    NEED(ANY);
    if (state == NULL)
        return refuse(i, "no state");
    memcpy(&i->now, state, sizeof(Present));
    connect(i);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3FreeFMUState)(void *instance, void **state)
{
    NEED(ANY);
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3SerializedFMUStateSize)(void *instance, void *state, size_t *size)
{
    NEED(ANY);
    if (state == NULL || size == NULL)
        return refuse(i, "no state");
    *size = sizeof(Present);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3SerializeFMUState)(void *instance, void *state, uint8_t bytes[], size_t size)
{
    NEED(ANY);
    if (state == NULL || bytes == NULL || size != sizeof(Present))
        return refuse(i, "no state, or room of another size");
    memcpy(bytes, state, sizeof(Present));
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3DeserializeFMUState)(void *instance, const uint8_t bytes[], size_t size, void **state)
{
    NEED(ANY);
    if (state == NULL || bytes == NULL || size != sizeof(Present))
        return refuse(i, "no state of this model");
    if (*state == NULL)
        *state = malloc(sizeof(Present));
    if (*state == NULL)
        return refuse(i, "not enough memory");
    memcpy(*state, bytes, sizeof(Present));
    return FMI_OK;
}

/* Model exchange. */

EXPORTED FmiStatus API(fmi3EnterEventMode)(void *instance)
{
    NEED(CONTINUOUS);
    look(i);
    memcpy(i->now.begin, i->now.run.here.w, sizeof i->now.begin);
    i->now.changed = false, i->now.phase = EVENTS;
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3EvaluateDiscreteStates)(void *instance)
{
    NEED(STARTING | EVENTS);
    look(i);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3UpdateDiscreteStates)(void *instance, bool *again, bool *terminate, bool *nominals, bool *values,
                                                 bool *timed, double *next)
{
    NEED(EVENTS);
    Run *r = &i->now.run;
    double before[ROOM(STATES)];
    Status status = FINE;
    memcpy(before, r->x, sizeof before);
    look(i);
    if (i->now.changed)
        tear(i);
    field_keep_at_rest(&r->field, r->t, r->x);
    i->now.fresh = false, i->now.changed = false;
    look(i);
    /* How often a mode changes is up to the importer's steps: only within one event has it an end. */
    r->flutter = 0, r->flutter_from = r->t;
    for (int round = 0, c = due(i); status == FINE && c >= 0 && round < 4*CONTACTS; round++, c = due(i)) {
        status = run_pass(r, c);
        i->now.fresh = false;
        look(i);
    }
    memcpy(i->now.begin, r->here.w, sizeof i->now.begin);
    if (again != NULL)
        *again = false;
    if (terminate != NULL)
        *terminate = false;
    if (nominals != NULL)
        *nominals = false;
    if (values != NULL)
        *values = memcmp(before, r->x, sizeof before) != 0;
    if (timed != NULL)
        *timed = false;
    if (next != NULL)
        *next = 0.0;
    return ended(i, status);
}

EXPORTED FmiStatus API(fmi3EnterContinuousTimeMode)(void *instance)
{
    NEED(EVENTS);
    if (!i->exchange)
        return refuse(i, "co-simulation has no continuous-time mode");
    i->now.phase = CONTINUOUS;
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3CompletedIntegratorStep)(void *instance, bool final, bool *event, bool *terminate)
{
    NEED(CONTINUOUS);
    Field *f = &i->now.run.field;
    bool left = false;
    (void)final;
    look(i);
    for (int c = 0; c < CONTACTS; c++) {
        double w = fabs(i->now.run.here.w[c]);
        f->speed[c] = fmax(f->speed[c], w);
        left = left || (f->stuck[c] && w > TORN*f->speed[c]);
    }
    /* What sticks and is carried along by an input whose slope was not told has drifted off: an event brings it back. */
    if (event != NULL)
        *event = left;
    if (terminate != NULL)
        *terminate = false;
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3SetTime)(void *instance, double time)
{
    NEED(EVENTS | CONTINUOUS);
    if (!isfinite(time))
        return refuse(i, "the time is not a number");
    i->now.fresh = i->now.fresh && i->now.run.t == time;
    i->now.run.t = time;
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3SetContinuousStates)(void *instance, const double states[], size_t count)
{
    NEED(CONTINUOUS);
    if (count != STATES || states == NULL)
        return refuse(i, "one number for each continuous state");
    i->now.fresh = false;
    memcpy(i->now.run.x, states, STATES*sizeof *states);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3GetContinuousStates)(void *instance, double states[], size_t count)
{
    NEED(STARTING | EVENTS | CONTINUOUS | STEPPING | OVER);
    if (count != STATES || states == NULL)
        return refuse(i, "one number for each continuous state");
    memcpy(states, i->now.run.x, STATES*sizeof *states);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3GetContinuousStateDerivatives)(void *instance, double rates[], size_t count)
{
    NEED(STARTING | EVENTS | CONTINUOUS | STEPPING | OVER);
    if (count != STATES || rates == NULL)
        return refuse(i, "one number for each continuous state");
    look(i);
    memcpy(rates, i->now.run.k[0], STATES*sizeof *rates);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3GetEventIndicators)(void *instance, double values[], size_t count)
{
    NEED(STARTING | EVENTS | CONTINUOUS | STEPPING | OVER);
    if (count != CONTACTS || (CONTACTS > 0 && values == NULL))
        return refuse(i, "one number for each contact");
    look(i);
    for (int c = 0; c < CONTACTS; c++)
        values[c] = indicator(i, c);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3GetNominalsOfContinuousStates)(void *instance, double nominals[], size_t count)
{
    NEED(ANY);
    if (count != STATES || nominals == NULL)
        return refuse(i, "one number for each continuous state");
    memcpy(nominals, NOMINAL, STATES*sizeof *nominals);
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3GetNumberOfEventIndicators)(void *instance, size_t *count)
{
    NEED(ANY);
    if (count == NULL)
        return FMI_ERROR;
    *count = CONTACTS;
    return FMI_OK;
}

EXPORTED FmiStatus API(fmi3GetNumberOfContinuousStates)(void *instance, size_t *count)
{
    NEED(ANY);
    if (count == NULL)
        return FMI_ERROR;
    *count = STATES;
    return FMI_OK;
}

/* Co-simulation. */

EXPORTED FmiStatus API(fmi3EnterStepMode)(void *instance) { return lacks(instance, "the model has no event mode in co-simulation"); }

EXPORTED FmiStatus API(fmi3DoStep)(void *instance, double from, double length, bool final, bool *event, bool *terminate, bool *early,
                                   double *last)
{
    NEED(STEPPING);
    Run *r = &i->now.run;
    Status status = FINE;
    (void)final;
    if (!isfinite(from) || !(length > 0.0 && isfinite(length)))
        return refuse(i, "a communication step is longer than zero");
    if (fabs(from - r->t) > 1e-9*fmax(r->span, fmax(fabs(r->t), length)))
        return refuse(i, "the step does not begin where the last one ended");
    for (int k = 0; k < INPUTS; k++)
        i->now.held[k].since = r->t;
    i->now.end = from + length, r->longest = length;
    r->count = 1, r->next = 0, r->steps = 0;
    if (i->now.changed) {
        field_reconsider(&r->field, r->t, r->x);
        run_settle(r);
        r->h = run_first_step(r);
    }
    while (status == FINE && r->next < r->count)
        status = run_step(r);
    i->now.fresh = i->now.changed = false;
    for (int k = 0; k < INPUTS; k++) {
        /* An input that went on by its slope starts anew with what is set next. */
        i->now.changed = i->now.changed || i->now.held[k].slope != 0.0;
    }
    if (event != NULL)
        *event = false;
    if (terminate != NULL)
        *terminate = false;
    if (early != NULL)
        *early = false;
    if (last != NULL)
        *last = r->t;
    return ended(i, status);
}
