/* The kernels of batch.c, LANES candidates at a time, once for each set of instructions.
 *
 * Whoever includes this defines KERNEL(name), the name of a kernel with those instructions. It has
 * no include guard, and includes nothing: a function of a system header must not get them.
 */
#define LANES 8
#define MAX_STATES 5
#define MAX_CHANNELS 4

#define EACH_LANE for (int l = 0; l < LANES; l++)

typedef struct {
    double sum[MAX_CHANNELS][LANES];
} residuals;

static inline int block_size(int n, int first) { return n - first < LANES ? n - first : LANES; }

/* The candidate of a lane; spare lanes of the last block repeat the last one. */
static inline int candidate(int first, int used, int lane)
{
    return first + (lane < used ? lane : used - 1);
}

/* Compare the states of sample k with its readings. */
static inline void observe(const batch_record *r, int k, int first, int used,
                           const double (*x)[LANES], const double (*previous)[LANES],
                           residuals *e)
{
    for (int c = 0; c < r->channels; c++) {
        const double *now = x[r->pick[c]], *before = previous[r->pick[c]];
        const double lag = r->lag[c], m = r->measured[(size_t)c * r->samples + k];
        double y[LANES];
        if (lag != 0.0)
            EACH_LANE y[l] = now[l] + lag * (before[l] - now[l]);
        else
            EACH_LANE y[l] = now[l];
        if (m == m)
            EACH_LANE e->sum[c][l] += (y[l] - m) * (y[l] - m);
        if (r->outputs)
            for (int l = 0; l < used; l++)
                r->outputs[((size_t)(first + l) * r->channels + c) * r->samples + k] = y[l];
    }
}

static inline void finish(const batch_record *r, int first, int used, const residuals *e)
{
    for (int l = 0; l < used; l++)
        for (int c = 0; c < r->channels; c++)
            r->squares[(size_t)(first + l) * r->channels + c] = e->sum[c][l];
}

/* x[k+1] = Ad x[k] + Bd u[k]; ``discrete`` (n, states, states + 1) holds Ad and Bd side by side. */
static inline void lti_blocks(const batch_record *r, int n, const double *discrete, int states)
{
    for (int first = 0; first < n; first += LANES) {
        const int used = block_size(n, first);
        double a[MAX_STATES][MAX_STATES + 1][LANES];
        double x[MAX_STATES][LANES] = {{0}}, last[MAX_STATES][LANES] = {{0}};
        residuals e = {{{0}}};
        for (int i = 0; i < states; i++)
            for (int j = 0; j <= states; j++)
                EACH_LANE a[i][j][l] =
                    discrete[((size_t)candidate(first, used, l) * states + i) * (states + 1) + j];
        for (int k = 0; k < r->samples; k++) {
            const double u = r->input[k];
            observe(r, k, first, used, x, last, &e);
            memcpy(last, x, sizeof last[0] * states);
            for (int i = 0; i < states; i++) {
                double next[LANES];
                EACH_LANE next[l] = a[i][states][l] * u;
                for (int j = 0; j < states; j++) EACH_LANE next[l] += a[i][j][l] * last[j][l];
                EACH_LANE x[i][l] = next[l];
            }
        }
        finish(r, first, used, &e);
    }
}

void KERNEL(batch_lti)(const batch_record *r, int n, int states, const double *discrete)
{
    switch (states) { /* constants, so that the loops over states unroll */
    case 2: lti_blocks(r, n, discrete, 2); break;
    case 3: lti_blocks(r, n, discrete, 3); break;
    case 4: lti_blocks(r, n, discrete, 4); break;
    case 5: lti_blocks(r, n, discrete, 5); break;
    }
}

/* One motor with Coulomb friction, discretised: columns of ``motor`` (n, MOTOR_COLUMNS). */
enum {
    II, IW, IV, IS, /* next current from current, speed, voltage, direction */
    WI, WW, WV, WS, /* next speed */
    PI, PW, PV, PS, /* turn of the shaft */
    OW, OS,         /* bridge open: next speed from speed, direction */
    OPW, OPS,       /* bridge open: turn of the shaft */
    HI, HV,         /* held by friction: next current from current, voltage */
    RI, RW, RV, RS, /* reading of the current, within the sample, as it is driven */
    RHI, RHV,       /* the same, held by friction */
    KT, T0,         /* torque constant, Coulomb torque */
    MOTOR_COLUMNS
};

/* States current, speed, position, reading of the current. Friction keeps its direction through a sample; a speed that
 * would pass zero stops there unless the torque drives it on, and stays while the torque at
 * mid-sample is within the Coulomb torque. */
void KERNEL(batch_friction)(const batch_record *r, int n, const double *motor)
{
    for (int first = 0; first < n; first += LANES) {
        const int used = block_size(n, first);
        double m[MOTOR_COLUMNS][LANES], x[4][LANES] = {{0}}, last[4][LANES] = {{0}};
        residuals e = {{{0}}};
        for (int j = 0; j < MOTOR_COLUMNS; j++)
            EACH_LANE m[j][l] = motor[(size_t)candidate(first, used, l) * MOTOR_COLUMNS + j];
        for (int k = 0; k < r->samples; k++) {
            const double v = r->input[k];
            const int open = r->open && r->open[k];
            observe(r, k, first, used, x, last, &e);
            memcpy(last, x, sizeof last);
            EACH_LANE {
                const double i = open ? 0.0 : last[0][l], w = last[1][l], p = last[2][l];
                const double held = m[HI][l] * i + m[HV][l] * v; /* the current if it stays */
                const double torque = open ? 0.0 : m[KT][l] * 0.5 * (i + held);
                const double push = torque > m[T0][l] ? 1.0 : torque < -m[T0][l] ? -1.0 : 0.0;
                const double s = w > 0.0 ? 1.0 : w < 0.0 ? -1.0 : push;
                double ni = m[II][l] * i + m[IW][l] * w + m[IV][l] * v + m[IS][l] * s;
                double nw = m[WI][l] * i + m[WW][l] * w + m[WV][l] * v + m[WS][l] * s;
                double nr = m[RI][l] * i + m[RW][l] * w + m[RV][l] * v + m[RS][l] * s;
                double np = m[PI][l] * i + m[PW][l] * w + m[PV][l] * v + m[PS][l] * s;
                if (open) {
                    ni = nr = 0.0;
                    nw = m[OW][l] * w + m[OS][l] * s;
                    np = m[OPW][l] * w + m[OPS][l] * s;
                }
                const int stuck = s == 0.0;
                x[0][l] = (stuck & !open) ? held : ni;
                const int stops = (nw * s <= 0.0) & !(torque * s < -m[T0][l]);
                x[1][l] = stuck | stops ? 0.0 : nw;
                x[2][l] = stuck ? p : p + np;
                x[3][l] = (stuck & !open) ? m[RHI][l] * i + m[RHV][l] * v : nr;
            }
        }
        finish(r, first, used, &e);
    }
}

/* Rates of the motor with load torque Ta sign(w) + Tb w + Tc w |w|. */
typedef struct {
    double resistance[LANES], per_l[LANES], constant[LANES], per_j[LANES];
    double ta[LANES], tb[LANES], tc[LANES];
} loads;

static inline void load_rates(const loads *p, double v, const double (*x)[LANES],
                              double (*dx)[LANES])
{
    EACH_LANE {
        const double i = x[0][l], w = x[1][l], ta = p->ta[l];
        const double drive = p->constant[l] * i - p->tb[l] * w - p->tc[l] * w * fabs(w);
        const double start = drive > ta ? drive - ta : drive < -ta ? drive + ta : 0.0;
        const double net = w > 0.0 ? drive - ta : w < 0.0 ? drive + ta : start;
        dx[0][l] = (v - p->resistance[l] * i - p->constant[l] * w) * p->per_l[l];
        dx[1][l] = net * p->per_j[l];
    }
}

/* A rotor at rest stays until its torque exceeds Ta: its current follows the exponential of L and
 * R up to that instant. Returns how much of h is left to move in, so that Runge-Kutta steps never
 * straddle the start. */
static double hold(const loads *p, int l, double v, double h, double *i)
{
    const double r = p->resistance[l], tau = 1.0 / (r * p->per_l[l]), final = v / r;
    const double limit = p->ta[l] / p->constant[l];
    double free_at = h, breakaway = v > 0.0 ? limit : -limit;
    if (fabs(*i) > limit)
        return h;
    if (fabs(final) > limit) {
        const double needed = -tau * log((breakaway - final) / (*i - final));
        free_at = needed < h ? needed : h;
    }
    *i = free_at < h ? breakaway : final + (*i - final) * exp(-h / tau);
    return h - free_at;
}

/* One classical Runge-Kutta step of h seconds; a speed that passes zero stops there. */
static inline void load_step(const loads *p, double v, double h, double (*x)[LANES])
{
    static const double ahead[3] = {0.5, 0.5, 1.0};
    double rate[4][2][LANES], at[2][LANES], dt[LANES];
    EACH_LANE dt[l] = x[1][l] == 0.0 ? hold(p, l, v, h, &x[0][l]) : h;
    load_rates(p, v, x, rate[0]);
    for (int stage = 0; stage < 3; stage++) {
        for (int j = 0; j < 2; j++)
            EACH_LANE at[j][l] = x[j][l] + ahead[stage] * dt[l] * rate[stage][j][l];
        load_rates(p, v, at, rate[stage + 1]);
    }
    EACH_LANE {
        const double w = x[1][l];
        const double next = w + dt[l] / 6.0 * (rate[0][1][l] + 2.0 * rate[1][1][l] +
                                               2.0 * rate[2][1][l] + rate[3][1][l]);
        x[2][l] += dt[l] * (w + dt[l] / 6.0 * (rate[0][1][l] + rate[1][1][l] + rate[2][1][l]));
        x[0][l] += dt[l] / 6.0 * (rate[0][0][l] + 2.0 * rate[1][0][l] + 2.0 * rate[2][0][l] +
                                  rate[3][0][l]);
        x[1][l] = w * next < 0.0 ? 0.0 : next;
    }
}

/* ``motor`` (n, 7): R, L, c, J, Ta, Tb, Tc; ``substeps`` Runge-Kutta steps a sample of dt s. */
void KERNEL(batch_quadratic)(const batch_record *r, int n, const double *motor, double dt,
                            int substeps)
{
    for (int first = 0; first < n; first += LANES) {
        const int used = block_size(n, first);
        loads p;
        double x[3][LANES] = {{0}}, last[3][LANES] = {{0}}; /* current, speed, position */
        residuals e = {{{0}}};
        EACH_LANE {
            const double *q = motor + 7 * (size_t)candidate(first, used, l);
            p.resistance[l] = q[0], p.per_l[l] = 1.0 / q[1], p.constant[l] = q[2];
            p.per_j[l] = 1.0 / q[3], p.ta[l] = q[4], p.tb[l] = q[5], p.tc[l] = q[6];
        }
        for (int k = 0; k < r->samples; k++) {
            observe(r, k, first, used, x, last, &e);
            memcpy(last, x, sizeof last);
            for (int s = 0; s < substeps; s++) load_step(&p, r->input[k], dt / substeps, x);
        }
        finish(r, first, used, &e);
    }
}
