/* A brushed DC motor as an FMU for co-simulation, after the interface of FMI 2.0.3.
 *
 *     L di/dt = v - R i - K w        J dw/dt = K i - B w - T0 sign(w) - load
 *
 * The inputs are constant over a communication step. Each step is cut into parts that are short
 * beside the motor's time constants; the winding is solved exactly in a part, the rotor under
 * the mean torque of that part. A rotor whose friction can hold it, does not turn.
 * Values are by reference: see VARIABLES of modelDescription.xml.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

enum { R, L, K, B, J, T0, VOLTAGE, LOAD, CURRENT, SPEED, ANGLE, COUNT };
enum { OK = 0, DISCARD = 2, ERROR = 3 };
#define PARTS_A_TIME_CONSTANT 10.0
#define MOST_PARTS 10000000.0

typedef struct {
    double value[COUNT];
    double time;
} motor;

static void rotor(double *x, double drive, double h)
{
    double w = x[SPEED], net = drive - x[LOAD], sign = w > 0.0 ? 1.0 : w < 0.0 ? -1.0 : 0.0;
    if (sign == 0.0) {
        if (fabs(net) <= x[T0]) {
            return;
        }
        sign = net > 0.0 ? 1.0 : -1.0;
    }
    double decay = exp(-x[B] / x[J] * h), push = net - sign * x[T0];
    double gain = x[B] * h > 1e-9 * x[J] ? (1.0 - decay) / x[B] : h / x[J];
    double next = w * decay + push * gain;
    if (next * sign < 0.0) { /* it comes to rest on the way, and turns back in the next part */
        next = 0.0;
    }
    x[ANGLE] += 0.5 * h * (w + next);
    x[SPEED] = next;
}

static void part(double *x, double h)
{
    double i = x[CURRENT], half, settled;
    double decay = exp(-x[R] / x[L] * 0.5 * h);
    settled = (x[VOLTAGE] - x[K] * x[SPEED]) / x[R];
    half = settled + (i - settled) * decay;
    rotor(x, x[K] * half, h);
    settled = (x[VOLTAGE] - x[K] * x[SPEED]) / x[R];
    x[CURRENT] = settled + (half - settled) * decay;
}

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }
API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const void *callbacks, int visible, int logging)
{
    motor *m = type == 1 && guid && !strcmp(guid, MOTOR_GUID) ? calloc(1, sizeof *m) : NULL;
    (void)name, (void)resources, (void)callbacks, (void)visible, (void)logging;
    if (m) {
        const double start[COUNT] = MOTOR_START;
        memcpy(m->value, start, sizeof start);
    }
    return m;
}
API void fmi2FreeInstance(void *m) { free(m); }
API int fmi2SetDebugLogging(void *m, int on, size_t n, const char *const names[])
{
    (void)m, (void)on, (void)n, (void)names;
    return OK;
}
API int fmi2SetupExperiment(void *m, int known, double tolerance, double start, int ends, double stop)
{
    (void)known, (void)tolerance, (void)ends, (void)stop;
    ((motor *)m)->time = start;
    return OK;
}
API int fmi2EnterInitializationMode(void *m) { return (void)m, OK; }
API int fmi2ExitInitializationMode(void *m)
{
    const double *x = ((motor *)m)->value;
    return x[R] > 0 && x[L] > 0 && x[J] > 0 && x[B] >= 0 && x[T0] >= 0 ? OK : ERROR;
}
API int fmi2Terminate(void *m) { return (void)m, OK; }
API int fmi2Reset(void *m)
{
    const double start[COUNT] = MOTOR_START;
    memcpy(((motor *)m)->value, start, sizeof start);
    return OK;
}
API int fmi2GetReal(void *m, const unsigned r[], size_t n, double out[])
{
    for (size_t k = 0; k < n; k++) {
        if (r[k] >= COUNT) {
            return ERROR;
        }
        out[k] = ((motor *)m)->value[r[k]];
    }
    return OK;
}
API int fmi2SetReal(void *m, const unsigned r[], size_t n, const double in[])
{
    for (size_t k = 0; k < n; k++) {
        if (r[k] >= COUNT || !isfinite(in[k])) {
            return ERROR;
        }
        ((motor *)m)->value[r[k]] = in[k];
    }
    return OK;
}
API int fmi2DoStep(void *instance, double time, double step, int keep)
{
    motor *m = instance;
    double *x = m->value, slowest, parts;
    (void)keep;
    if (!(step >= 0.0)) {
        return ERROR;
    }
    slowest = fmin(x[L] / x[R], x[R] * x[J] / (x[K] * x[K] + x[R] * x[B] + 1e-300));
    parts = ceil(step * PARTS_A_TIME_CONSTANT / slowest);
    if (!(parts <= MOST_PARTS)) {
        return DISCARD;
    }
    for (long k = 0; k < (long)parts; k++) {
        part(x, step / parts);
    }
    m->time = time + step;
    return OK;
}
API int fmi2CancelStep(void *m) { return (void)m, ERROR; }

/* What no motor has: integers, truth values, texts, and the states that it does not hand out. */
#define NONE_OF(kind, type)                                                                        \
    API int fmi2Get##kind(void *m, const unsigned r[], size_t n, type out[])                       \
    {                                                                                              \
        return (void)m, (void)r, (void)out, n ? ERROR : OK;                                        \
    }                                                                                              \
    API int fmi2Set##kind(void *m, const unsigned r[], size_t n, const type in[])                  \
    {                                                                                              \
        return (void)m, (void)r, (void)in, n ? ERROR : OK;                                         \
    }
typedef const char *text;
NONE_OF(Integer, int)
NONE_OF(Boolean, int)
NONE_OF(String, text)
API int fmi2GetFMUstate(void *m, void **s) { return (void)m, (void)s, ERROR; }
API int fmi2SetFMUstate(void *m, void *s) { return (void)m, (void)s, ERROR; }
API int fmi2FreeFMUstate(void *m, void **s) { return (void)m, (void)s, ERROR; }
API int fmi2SerializedFMUstateSize(void *m, void *s, size_t *n)
{
    return (void)m, (void)s, (void)n, ERROR;
}
API int fmi2SerializeFMUstate(void *m, void *s, char *out, size_t n)
{
    return (void)m, (void)s, (void)out, (void)n, ERROR;
}
API int fmi2DeSerializeFMUstate(void *m, const char *in, size_t n, void **s)
{
    return (void)m, (void)in, (void)n, (void)s, ERROR;
}
API int fmi2GetDirectionalDerivative(void *m, const unsigned a[], size_t na, const unsigned b[],
                                     size_t nb, const double in[], double out[])
{
    return (void)m, (void)a, (void)na, (void)b, (void)nb, (void)in, (void)out, ERROR;
}
API int fmi2SetRealInputDerivatives(void *m, const unsigned r[], size_t n, const int order[],
                                    const double in[])
{
    return (void)m, (void)r, (void)order, (void)in, n ? ERROR : OK;
}
API int fmi2GetRealOutputDerivatives(void *m, const unsigned r[], size_t n, const int order[],
                                     double out[])
{
    return (void)m, (void)r, (void)order, (void)out, n ? ERROR : OK;
}
API int fmi2GetStatus(void *m, int kind, int *out) { return (void)m, (void)kind, (void)out, DISCARD; }
API int fmi2GetRealStatus(void *m, int kind, double *out)
{
    if (kind != 2) { /* the time of the last step that was done */
        return DISCARD;
    }
    *out = ((motor *)m)->time;
    return OK;
}
API int fmi2GetIntegerStatus(void *m, int kind, int *out)
{
    return (void)m, (void)kind, (void)out, DISCARD;
}
API int fmi2GetBooleanStatus(void *m, int kind, int *out)
{
    return (void)m, (void)kind, (void)out, DISCARD;
}
API int fmi2GetStringStatus(void *m, int kind, text *out)
{
    return (void)m, (void)kind, (void)out, DISCARD;
}
