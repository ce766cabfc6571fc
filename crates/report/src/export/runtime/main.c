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
