/* A host in C for any platform: steps a co-simulation instance and prints Reals with all their digits.
 *
 *   host LIBRARY GUID STEP COUNT REFERENCE...
 *
 * One line per communication point, the start included. Prototypes: FMI 2.0, 2.1 and 4.2.
 */
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

int main(int argc, char **argv) {
    if (argc < 6 || argc - 5 > 16 || !(library = load(argv[1]))) {
        fprintf(stderr, "cannot load the library, or wrong arguments\n");
        return 1;
    }
    double step = atof(argv[3]);
    int count = atoi(argv[4]);
    size_t n = (size_t)(argc - 5);
    unsigned references[16];
    for (size_t i = 0; i < n; i++) references[i] = (unsigned)atoi(argv[5 + i]);

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
    Component fmu = instantiate("host", 1, argv[2], "", &callbacks, 0, 0);
    if (!fmu) return 4;
    ok("fmi2SetupExperiment", setup(fmu, 0, 0.0, 0.0, 0, 0.0));
    ok("fmi2EnterInitializationMode", enter(fmu));
    ok("fmi2ExitInitializationMode", leave(fmu));
    for (int i = 0; i <= count; i++) {
        double values[16];
        ok("fmi2GetReal", get(fmu, references, n, values));
        for (size_t k = 0; k < n; k++) printf(k ? " %.17g" : "%.17g", values[k]);
        printf("\n");
        if (i < count) ok("fmi2DoStep", do_step(fmu, i * step, step, 1));
    }
    ok("fmi2Terminate", terminate(fmu));
    release(fmu);
    return 0;
}
