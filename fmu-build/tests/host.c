/* A host in C for any platform: steps a co-simulation instance and prints Reals with all their digits.
 *
 *   host LIBRARY VERSION GUID STEP COUNT REFERENCE...
 *
 * VERSION is 2 or 3, GUID the instantiation token for 3. One line per communication point, the start included. By FMI 3.0 steps
 * return at every event, which is handled in Event Mode. Prototypes: FMI 2.0, 2.1 and 4.2; FMI 3.0.2, 2.2, 2.3 and 4.2.
 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void logger(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    (void)environment;
    fprintf(stderr, "%s: status %d, %s: %s\n", instance, status, category, message);
}

static void *library;

static void *function(const char *name) {
    void *found = find(library, name);
    if (!found) {
        fprintf(stderr, "the library has no %s\n", name);
        exit(2);
    }
    return found;
}

static void ok(const char *call, int status) {
    if (status != 0) {
        fprintf(stderr, "%s returned %d\n", call, status);
        exit(3);
    }
}

/* What is stepped: an instance of either version. */
typedef struct {
    double step;
    int count;
    size_t n;
    unsigned references[16];
} Task;

static void print_row(const double *values, size_t n) {
    for (size_t k = 0; k < n; k++) printf(k ? " %.17g" : "%.17g", values[k]);
    printf("\n");
}

static int run_fmi2(const char *guid, const Task *task) {
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) =
        (Component(*)(const char *, int, const char *, const char *, const Callbacks *, int, int))function("fmi2Instantiate");
    int (*setup)(Component, int, double, double, int, double) =
        (int (*)(Component, int, double, double, int, double))function("fmi2SetupExperiment");
    int (*enter)(Component) = (int (*)(Component))function("fmi2EnterInitializationMode");
    int (*leave)(Component) = (int (*)(Component))function("fmi2ExitInitializationMode");
    int (*do_step)(Component, double, double, int) = (int (*)(Component, double, double, int))function("fmi2DoStep");
    int (*get)(Component, const unsigned *, size_t, double *) =
        (int (*)(Component, const unsigned *, size_t, double *))function("fmi2GetReal");
    int (*terminate)(Component) = (int (*)(Component))function("fmi2Terminate");
    void (*release)(Component) = (void (*)(Component))function("fmi2FreeInstance");

    Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    Component fmu = instantiate("host", 1, guid, "", &callbacks, 0, 0);
    if (!fmu) return 4;
    ok("fmi2SetupExperiment", setup(fmu, 0, 0.0, 0.0, 0, 0.0));
    ok("fmi2EnterInitializationMode", enter(fmu));
    ok("fmi2ExitInitializationMode", leave(fmu));
    for (int i = 0; i <= task->count; i++) {
        double values[16];
        ok("fmi2GetReal", get(fmu, task->references, task->n, values));
        print_row(values, task->n);
        if (i < task->count) ok("fmi2DoStep", do_step(fmu, i * task->step, task->step, 1));
    }
    ok("fmi2Terminate", terminate(fmu));
    release(fmu);
    return 0;
}

static void logger3(void *environment, int status, const char *category, const char *message) {
    (void)environment;
    fprintf(stderr, "status %d, %s: %s\n", status, category, message);
}

typedef void (*Logger3)(void *, int, const char *, const char *);
typedef Component (*Instantiate3)(const char *, const char *, const char *, bool, bool, bool, bool, const unsigned *, size_t, void *,
                                  Logger3, void *);

static int run_fmi3(const char *token, const Task *task) {
    Instantiate3 instantiate = (Instantiate3)function("fmi3InstantiateCoSimulation");
    int (*enter)(Component, bool, double, double, bool, double) =
        (int (*)(Component, bool, double, double, bool, double))function("fmi3EnterInitializationMode");
    int (*leave)(Component) = (int (*)(Component))function("fmi3ExitInitializationMode");
    int (*enter_events)(Component) = (int (*)(Component))function("fmi3EnterEventMode");
    int (*update)(Component, bool *, bool *, bool *, bool *, bool *, double *) =
        (int (*)(Component, bool *, bool *, bool *, bool *, bool *, double *))function("fmi3UpdateDiscreteStates");
    int (*enter_steps)(Component) = (int (*)(Component))function("fmi3EnterStepMode");
    int (*do_step)(Component, double, double, bool, bool *, bool *, bool *, double *) =
        (int (*)(Component, double, double, bool, bool *, bool *, bool *, double *))function("fmi3DoStep");
    int (*get)(Component, const unsigned *, size_t, double *, size_t) =
        (int (*)(Component, const unsigned *, size_t, double *, size_t))function("fmi3GetFloat64");
    int (*terminate)(Component) = (int (*)(Component))function("fmi3Terminate");
    void (*release)(Component) = (void (*)(Component))function("fmi3FreeInstance");

    Component fmu = instantiate("host", token, "", false, false, true, true, NULL, 0, NULL, logger3, NULL);
    if (!fmu) return 4;
    ok("fmi3EnterInitializationMode", enter(fmu, false, 0.0, 0.0, false, 0.0));
    ok("fmi3ExitInitializationMode", leave(fmu));
    bool again, ends, nominals, jumped, known, event = true, terminates = false, early = false;
    double next, time = 0.0;
    for (int i = 0; i <= task->count; i++) {
        double values[16], end = i * task->step;
        /* The start is in Event Mode already. */
        for (bool first = i == 0; first || time < end; first = false) {
            if (!first) ok("fmi3DoStep", do_step(fmu, time, end - time, true, &event, &terminates, &early, &time));
            if (!first && !event && early) return 5;
            if (event) {
                if (!first) ok("fmi3EnterEventMode", enter_events(fmu));
                ok("fmi3UpdateDiscreteStates", update(fmu, &again, &ends, &nominals, &jumped, &known, &next));
                if (again || ends || nominals || terminates) return 6;
                if (known && !(next > time)) return 7;
                ok("fmi3EnterStepMode", enter_steps(fmu));
            }
        }
        ok("fmi3GetFloat64", get(fmu, task->references, task->n, values, task->n));
        print_row(values, task->n);
    }
    ok("fmi3Terminate", terminate(fmu));
    release(fmu);
    return 0;
}

int main(int argc, char **argv) {
    if (argc < 7 || argc - 6 > 16 || !(library = load(argv[1]))) {
        fprintf(stderr, "cannot load the library, or wrong arguments\n");
        return 1;
    }
    Task task = {.step = atof(argv[4]), .count = atoi(argv[5]), .n = (size_t)(argc - 6)};
    for (size_t i = 0; i < task.n; i++) task.references[i] = (unsigned)atoi(argv[6 + i]);
    return atoi(argv[2]) == 3 ? run_fmi3(argv[3], &task) : run_fmi2(argv[3], &task);
}
