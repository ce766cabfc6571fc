/* What MATLAB and GNU Octave call: one function, of which the comment at the top says what it takes and gives. */
#include "mex.h"

#define NUMBER(a, i) (mxGetPr(a)[i])

static void refuse(const char *what, const char *which)
{
    mexErrMsgIdAndTxt("phisindy:model", "%s%s", what, which);
}

/* Whether an argument is there: [] stands for what is usual. */
static bool given(int count, const mxArray *all[], int place)
{
    return place < count && !mxIsEmpty(all[place]);
}

static void need_numbers(const mxArray *a, size_t count, const char *what)
{
    if (!mxIsDouble(a) || mxIsComplex(a) || mxIsSparse(a) || mxGetNumberOfElements(a) != count)
        refuse("give real numbers, one for each of the ", what);
    for (size_t i = 0; i < count; i++)
        if (!mxIsFinite(NUMBER(a, i)))
            refuse("not a finite number among the ", what);
}

static mxArray *names_of(const char *const *names, int count)
{
    mxArray *cell = mxCreateCellMatrix(1, (mwSize)count);
    for (int k = 0; k < count; k++)
        mxSetCell(cell, (mwIndex)k, mxCreateString(names[k]));
    return cell;
}

/* Parameters are doubles alone, in the order of their names. */
static mxArray *constants_of(const Parameters *p)
{
    mxArray *all = mxCreateStructMatrix(1, 1, 0, NULL);
    for (int k = 0; k < CONSTANTS; k++) {
        mxAddField(all, CONSTANT_NAMES[k]);
        mxSetField(all, 0, CONSTANT_NAMES[k], mxCreateDoubleScalar(((const double *)p)[k]));
    }
    return all;
}

/* The constants of a structure; those that it does not have stay as they are. */
static Parameters changed_constants(const mxArray *all)
{
    Parameters p = PARAMETERS;
    if (!mxIsStruct(all) || mxGetNumberOfElements(all) != 1)
        refuse("give the constants as one structure", "");
    for (int i = 0; i < mxGetNumberOfFields(all); i++) {
        const char *name = mxGetFieldNameByNumber(all, i);
        int k = 0;
        while (k < CONSTANTS && strcmp(CONSTANT_NAMES[k], name) != 0)
            k++;
        if (k == CONSTANTS)
            refuse("there is no constant ", name);
        need_numbers(mxGetField(all, 0, name), 1, "constants");
        ((double *)&p)[k] = NUMBER(mxGetField(all, 0, name), 0);
    }
    return p;
}

/* What the model is made of. */
static mxArray *description(void)
{
    static const char *fields[] = {"states", "inputs", "outputs", "contacts", "constants", "start", "start_time"};
    mxArray *all = mxCreateStructMatrix(1, 1, 7, fields), *start = mxCreateDoubleMatrix(1, STATES, mxREAL);
    for (int j = 0; j < STATES; j++)
        NUMBER(start, j) = START[j];
    mxSetField(all, 0, "states", names_of(STATE_NAMES, STATES));
    mxSetField(all, 0, "inputs", names_of(INPUT_NAMES, INPUTS));
    mxSetField(all, 0, "outputs", names_of(OUTPUT_NAMES, OUTPUTS));
    mxSetField(all, 0, "contacts", names_of(CONTACT_NAMES, CONTACTS));
    mxSetField(all, 0, "constants", constants_of(&PARAMETERS));
    mxSetField(all, 0, "start", start);
    mxSetField(all, 0, "start_time", mxCreateDoubleScalar(START_TIME));
    return all;
}

/* Rows of integers or numbers as the columns of a matrix. */
static mxArray *matrix(int rows, int columns, const int *whole, const double *real)
{
    mxArray *made = mxCreateDoubleMatrix((mwSize)rows, (mwSize)columns, mxREAL);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++)
            NUMBER(made, (size_t)j*rows + i) = real != NULL ? real[(size_t)i*columns + j] : whole[(size_t)i*columns + j];
    return made;
}

/* [x, mode, y] = model(t, u, start, constants) */
static void motion(int results, mxArray *out[], int count, const mxArray *in[])
{
    static const char *statuses[] = {"", "not enough memory", "more than two million steps", "the step length collapsed",
                                     "the motion grows without bound", "a contact changes sign without end"};
    size_t all = mxGetNumberOfElements(in[0]);
    if (all == 0 || all > 10000000)
        refuse("give at least one time, and at most ten million", "");
    need_numbers(in[0], all, "times");
    int rows = (int)all;
    const double *times = mxGetPr(in[0]);
    for (int i = 1; i < rows; i++)
        if (!(times[i] > times[i - 1]))
            refuse("the times must increase", "");
    if (INPUTS > 0 && !given(count, in, 1))
        refuse("give the inputs, a row for each time and a column for each of them: ", INPUT_NAMES[0]);
    if (given(count, in, 1)) {
        need_numbers(in[1], all*INPUTS, "inputs at each time");
        if (mxGetM(in[1]) != all && INPUTS > 1)
            refuse("give the inputs as a matrix with a row for each time", "");
    }
    double start[ROOM(STATES)];
    if (given(count, in, 2))
        need_numbers(in[2], STATES, "states at the start");
    for (int j = 0; j < STATES; j++) {
        start[j] = given(count, in, 2) ? NUMBER(in[2], j) : START[j];
        if (isnan(start[j]))
            refuse("it is not known where this state starts, so give the start: ", STATE_NAMES[j]);
    }
    Parameters p = given(count, in, 3) ? changed_constants(in[3]) : PARAMETERS;
    /* Memory of mxMalloc is given back by MATLAB, also where a call ends with an error. */
    double *states = mxMalloc((all*(STATES + OUTPUTS + 1 + INPUTS) + 1)*sizeof *states), *shown = states + all*STATES;
    double *above = shown + all*OUTPUTS, *slopes = above + all;
    int *modes = mxMalloc(all*ROOM(CONTACTS)*sizeof *modes);
    Input inputs[ROOM(INPUTS)];
    for (int k = 0; k < INPUTS; k++) {
        const double *values = mxGetPr(in[1]) + all*(size_t)k;
        if (INPUT_KINDS[k] == CUBIC)
            model_spline(rows, times, values, slopes + all*(size_t)k, above);
        Input sampled = {rows, times, values, slopes + all*(size_t)k, (Kind)INPUT_KINDS[k], NULL, NULL, NULL};
        inputs[k] = sampled;
    }
    Options options = model_options();
    options.outputs = shown;
    double from = given(count, in, 2) || isnan(START_TIME) ? times[0] : START_TIME;
    Status status = model_simulate(times, rows, start, from, inputs, &p, &options, states, modes);
    if (status != FINE)
        refuse(statuses[status], "");
    out[0] = matrix(rows, STATES, NULL, states);
    if (results > 1)
        out[1] = matrix(rows, CONTACTS, modes, NULL);
    if (results > 2)
        out[2] = matrix(rows, OUTPUTS, NULL, shown);
    mxFree(states), mxFree(modes);
}

/* [dx, mode] = model('rates', t, x, u, mode, constants) */
static void rates_at(int results, mxArray *out[], int count, const mxArray *in[])
{
    double none[ROOM(INPUTS)] = {0.0};
    int modes[ROOM(CONTACTS)] = {0};
    if (count < 3)
        refuse("give the time and the state after 'rates'", "");
    need_numbers(in[1], 1, "times");
    need_numbers(in[2], STATES, "states");
    if (INPUTS > 0 && !given(count, in, 3))
        refuse("give the inputs after the state, first ", INPUT_NAMES[0]);
    if (given(count, in, 3))
        need_numbers(in[3], INPUTS, "inputs");
    double t = NUMBER(in[1], 0);
    const double *x = mxGetPr(in[2]), *u = given(count, in, 3) ? mxGetPr(in[3]) : none;
    Parameters p = given(count, in, 5) ? changed_constants(in[5]) : PARAMETERS;
    if (given(count, in, 4)) {
        need_numbers(in[4], CONTACTS, "contacts");
        for (int c = 0; c < CONTACTS; c++) {
            double mode = NUMBER(in[4], c);
            modes[c] = mode > 0.0 ? 1 : mode < 0.0 ? -1 : 0;
        }
    } else {
        model_modes(t, x, u, NULL, &p, NULL, modes);
    }
    out[0] = mxCreateDoubleMatrix(STATES, 1, mxREAL);
    model_rates(t, x, u, modes, NULL, &p, mxGetPr(out[0]));
    if (results > 1)
        out[1] = matrix(1, CONTACTS, modes, NULL);
}

void mexFunction(int results, mxArray *out[], int count, const mxArray *in[])
{
    char word[8] = "";
    if (count == 0)
        out[0] = description();
    else if (!mxIsChar(in[0]))
        motion(results, out, count, in);
    else if (mxGetString(in[0], word, sizeof word) == 0 && strcmp(word, "rates") == 0)
        rates_at(results, out, count, in);
    else
        refuse("the only word that is taken is 'rates'", "");
}
