/* The steps of wide_lanes.h, once for each set of instructions: what wide_step.c does for one motor,
 * in the same order, so that a lane gets the same bits.
 *
 * Whoever includes this defines KERNEL(name), the name of a function with those instructions. It has
 * no include guard, and includes nothing: a function of a system header must not get them.
 */

/* What repeats with the rotor at one moment. */
typedef struct {
    lane cogging, ripple;
} lanes_turn;

/* The forces in a step, and how warm it leaves the windings. */
typedef struct {
    lane f[NODES][FORCES], warmth;
} lanes_drive;

static inline lane each_sqrt(lane a)
{
    EACH_LANE a[l] = sqrt(a[l]);
    return a;
}

static inline lane either(lane_mask where, lane yes, lane no)
{
    return (lane)(((lane_mask)yes & where) | ((lane_mask)no & ~where));
}

static inline lane each_fabs(lane a)
{
    return either(a < 0.0, -a, a);
}

static inline lanes_turn lanes_turn_at(const lanes *g, lane position, int node, double length)
{
    const wide_run *r = &g->run[0];
    const lanes_motor *p = &g->motor;
    lanes_turn t = {{0}, {0}};
    if (!r->turns) return t;
    if (r->angle) {
        const double before = r->angle[r->n - 1];
        EACH_LANE position[l] =
            before + (r->angle[r->n] - before) * (g->at + 0.5 * node * length) / r->h;
    }
    const lane cogging = p->cogging_per_turn * position + g->cogging_phase;
    const lane ripple = p->ripple_per_turn * position + g->ripple_phase;
    if (p->cogging[0] != 0.0) EACH_LANE t.cogging[l] = sin(cogging[l]);
    if (r->ripples) EACH_LANE t.ripple[l] = cos(ripple[l]);
    return t;
}

/* The brushes' part of their drop, mean over the ripple. */
static inline lane lanes_signs(const lanes *g, lane i)
{
    const lane swing = g->swing, knee = g->motor.brush_current, square = knee * knee;
    const lane here = i / each_sqrt(i * i + square);
    const lane_mask steady = swing < 1e-3 * knee;
    int all = 1;
    EACH_LANE all &= steady[l] != 0;
    if (all) return here;
    const lane up = i + swing, down = i - swing;
    const lane mean = (each_sqrt(up * up + square) - each_sqrt(down * down + square)) / (2.0 * swing);
    return either(steady, here, mean);
}

/* What is left of K. */
static inline lane lanes_constant(const lanes *g, lane i)
{
    const lane bend = g->motor.reaction_bend;
    const lane square = i * i + g->swing * g->swing / 3.0;
    if (g->motor.reaction[0] == 0.0) return (lane){0} + 1.0;
    return 1.0 - g->motor.reaction * (each_sqrt(square + bend * bend) - bend);
}

/* What is left of L, whose current swings by that. */
static inline lane lanes_inductance(const lanes *g, lane i, lane swing)
{
    const lane knee = g->motor.saturation_current * g->motor.saturation_current;
    const lane square = i * i + swing * swing / 3.0;
    return 1.0 - g->motor.saturation * square / (square + knee);
}

/* What commutation adds to R. */
static inline lane lanes_commutation(const lanes *g, lane w)
{
    const lane none = {0}, above = each_fabs(w) - g->motor.commutation_from;
    return g->motor.commutation * either(above > none, above, none);
}

static inline lane lanes_stribeck(const lanes *g, lane w)
{
    const lanes_motor *p = &g->motor;
    lane torque = {0};
    EACH_LANE if (fabs(w[l]) < STRIBECK_REACH * p->stribeck[l]) {
        const double ratio = w[l] / p->stribeck[l];
        torque[l] = p->stiction[l] * exp(-ratio * ratio);
    }
    return torque;
}

static inline lane lanes_load(const lanes *g, lane i, lane left)
{
    const lanes_motor *p = &g->motor;
    const lane swing = g->swing, flat = each_fabs(i);
    const lane bent = 0.5 * (i * i + swing * swing) / swing;
    return p->load_friction * p->K * left * either(flat < swing, bent, flat);
}

/* What dry friction has more at a node of a step. */
static inline lane lanes_drift(const lanes *g, int node, double length)
{
    const wide_run *r = &g->run[0];
    lane more = {0};
    if (g->motor.drift[0] == 0.0) return more;
    const double time = (r->n - 1) * r->h + (g->at + 0.5 * node * length);
    EACH_LANE more[l] = g->motor.drift[l] * friction_left(g->run[l].motor, time);
    return more;
}

static inline void lanes_forces(const lanes *g, const lane *x, const lanes_turn *t, lane warmth,
                             lane drift, lane f[FORCES])
{
    const lanes_motor *p = &g->motor;
    const wide_run *r = &g->run[0];
    const lane i = x[WI], w = x[WW], left = lanes_constant(g, i);
    const double s = r->now.mode.s;
    lane volts = -p->R * warmth * i, torque = {0};
    if (p->commutation[0] != 0.0) volts = -(p->R * warmth + lanes_commutation(g, w)) * i;
    if (p->brush[0] != 0.0 && r->now.mode.circuit != OPEN) volts -= p->brush * lanes_signs(g, i);
    if (p->quadratic[0] != 0.0) torque -= p->quadratic * w * each_fabs(w);
    if (p->stiction[0] != 0.0 && s != 0.0) torque -= s * lanes_stribeck(g, w);
    if (p->load_friction[0] != 0.0 || p->drift[0] != 0.0) {
        lane dry = {0};
        if (p->load_friction[0] != 0.0) dry = lanes_load(g, i, left);
        torque -= s * (dry + drift) + p->cogging * t->cogging;
    } else if (p->cogging[0] != 0.0) torque -= p->cogging * t->cogging;
    if (r->ripples || p->reaction[0] != 0.0) {
        const lane constant = (1.0 + t->ripple * p->k_ripple) * left - 1.0;
        volts -= t->ripple * p->r_ripple * p->R * i + constant * p->K * (1.0 + p->emf) * w;
        torque += constant * p->K * i;
    }
    f[VOLTS] = volts, f[TORQUE] = torque, f[SHIELDED] = (lane){0};
    if (p->saturation[0] == 0.0 || r->now.mode.discontinuous) return;
    const lane shielded = g->shield * (i - x[WEDDY]), none = {0};
    const lane emf = s != 0.0 ? p->K * (1.0 + p->emf) * w : none;
    f[VOLTS] += (g->v - g->Rt * i - emf - shielded + volts) *
                (1.0 / lanes_inductance(g, i, g->swing) - 1.0);
    f[SHIELDED] = shielded * (1.0 / lanes_inductance(g, x[WEDDY], none) - 1.0);
}

static inline lane lanes_linear(const lanes *g, const lanes_map *m, const int rows, int r)
{
    lane y = m->g[r] * g->v + m->c[r] + m->P[0][r] * g->x[WI] + m->P[1][r] * g->x[WW];
    if (rows > PLAIN) y += m->P[EDDY][r] * g->x[WEDDY];
    if (rows > EDDIES) y += m->P[LOAD][r] * g->x[WLOAD] + m->P[TWIST][r] * g->x[WTWIST];
    return r == WQ || r == WTH ? y + g->x[r] : y;
}

static inline lane lanes_forced(const lanes_map *m, const int rows, int r, const int acts[FORCES],
                             lane linear, lane f[NODES][FORCES])
{
    for (int k = 0; k < (rows > PLAIN ? FORCES : SHIELDED); k++)
        if (acts[k])
            linear += m->F[k][BEGIN][r] * f[BEGIN][k] + m->F[k][MIDDLE][r] * f[MIDDLE][k] +
                      m->F[k][END][r] * f[END][k];
    return linear;
}

static inline void lanes_warm(const lanes *g, const lane current[NODES], double length,
                           lane warmth[NODES])
{
    const lanes_motor *p = &g->motor;
    lane rate[NODES];
    for (int n = 0; n < NODES; n++) {
        const lane square = current[n] * current[n] + g->swing * g->swing / 3.0;
        rate[n] = p->warming * (1.0 + warmth[n]) * square - p->cooling * warmth[n];
    }
    warmth[MIDDLE] =
        warmth[BEGIN] + length * (5.0 * rate[BEGIN] + 8.0 * rate[MIDDLE] - rate[END]) / 24.0;
    warmth[END] = warmth[BEGIN] + length * (rate[BEGIN] + 4.0 * rate[MIDDLE] + rate[END]) / 6.0;
}

/* From the present states through a step; nothing is kept. */
static inline void lanes_step(const lanes *g, const int rows, const lanes_level *m, lane *y,
                           lanes_drive *d)
{
    const wide_run *r = &g->run[0];
    lane to_middle[WROWS] = {{0}}, to_end[WROWS], middle[WROWS];
    lane warmth[NODES] = {g->warmth, g->warmth, g->warmth};
    lanes_turn turn[NODES];
    for (int row = 0; row < rows; row++) y[row] = to_end[row] = lanes_linear(g, &m->full, rows, row);
    d->warmth = g->warmth;
    if (!(r->acts[VOLTS] || r->acts[TORQUE] || r->acts[SHIELDED])) return;
    for (int row = 0; row < rows; row++)
        if (r->asked[row]) to_middle[row] = lanes_linear(g, &m->half, rows, row);
    for (int n = 0; n < NODES; n++) turn[n] = lanes_turn_at(g, g->x[WTH], n, m->length);
    lane drift[NODES];
    for (int n = 0; n < NODES; n++) drift[n] = lanes_drift(g, n, m->length);
    lanes_forces(g, g->x, &turn[BEGIN], warmth[BEGIN], drift[BEGIN], d->f[BEGIN]);
    for (int k = 0; k < FORCES; k++) d->f[MIDDLE][k] = d->f[END][k] = d->f[BEGIN][k];
    for (int sweep = 0; sweep < r->sweeps; sweep++) {
        for (int row = 0; row < rows; row++) {
            if (!r->asked[row]) continue;
            middle[row] = lanes_forced(&m->half, rows, row, r->acts, to_middle[row], d->f);
            y[row] = lanes_forced(&m->full, rows, row, r->acts, to_end[row], d->f);
        }
        const lane current[NODES] = {g->x[WI], middle[WI], y[WI]};
        if (r->warms) lanes_warm(g, current, m->length, warmth);
        if (r->turns && !r->angle) {
            turn[MIDDLE] = lanes_turn_at(g, middle[WTH], MIDDLE, m->length);
            turn[END] = lanes_turn_at(g, y[WTH], END, m->length);
        }
        lanes_forces(g, middle, &turn[MIDDLE], warmth[MIDDLE], drift[MIDDLE], d->f[MIDDLE]);
        lanes_forces(g, y, &turn[END], warmth[END], drift[END], d->f[END]);
    }
    d->warmth = warmth[END];
    for (int row = 0; row < rows; row++)
        y[row] = lanes_forced(&m->full, rows, row, r->acts, to_end[row], d->f);
}

/* Of motors that stand: one breaks loose in a step that ends there. */
static inline int lanes_loose(lanes *g, const lane *y)
{
    int loose = 0;
    for (int l = 0; l < LANES; l++) {
        wide_run *r = &g->run[l];
        wide_state x;
        for (int row = 0; row < WROWS; row++) x.x[row] = row < r->rows ? y[row][l] : 0.0;
        r->now.warmth = g->warmth[l], r->now.at = g->at;
        const double torque = wide_push(r, &x);
        loose |= wide_breakaway(r, x.x[WI], torque) - fabs(torque) < 0.0;
    }
    return loose;
}

/* Some motor stops or breaks loose, or its current is out. */
static inline int lanes_apart(lanes *g, const lane *y)
{
    const mode *m = &g->run[0].now.mode;
    const lane ahead = (double)m->s * y[WW], flows = m->fi * y[WI];
    int events = 0;
    if (m->s && !m->still) EACH_LANE events |= ahead[l] < 0.0;
    if (m->circuit == FREEWHEEL) EACH_LANE events |= flows[l] < 0.0;
    return events || (!m->s && !m->still && lanes_loose(g, y));
}

static inline lane lanes_shown(const lanes *g, const int rows, const lanes_row *m,
                            const lanes_drive *d, lane y)
{
    y += m->P[0] * g->x[WI] + m->P[1] * g->x[WW];
    if (rows > PLAIN) y += m->P[EDDY] * g->x[WEDDY];
    if (rows > EDDIES) y += m->P[LOAD] * g->x[WLOAD] + m->P[TWIST] * g->x[WTWIST];
    for (int f = 0; f < FORCES; f++)
        if (g->run[0].acts[f])
            for (int node = 0; node < NODES; node++) y += m->F[f][node] * d->f[node][f];
    return y;
}

static inline void lanes_read(lanes *g, const int rows, int n, int k, const lanes_level *level,
                             const lanes_drive *d)
{
    const taps *all = &g->run[0].taps;
    for (int j = 0; j < all->n; j++) {
        const tap *t = &all->tap[j];
        const lanes_row *m = &level->taps[j];
        if (m->step != k) continue;
        lane y = m->g * g->v + m->c + m->extra;
        if (t->integral) y += m->base * g->x[t->row ? WTH : WQ];
        if (t->filter >= 0) y += m->keep * g->y[t->filter];
        y = lanes_shown(g, rows, m, d, y);
        EACH_LANE g->values[l][(size_t)j * all->count + n] = y[l];
    }
    for (int j = 0; j < all->filters; j++) {
        const lanes_row *m = &level->filters[j];
        const lane y = m->keep * g->y[j] + m->base * g->x[WTH] + m->g * g->v + m->c;
        g->y[j] = lanes_shown(g, rows, m, d, y);
    }
}

static inline int lanes_steps(lanes *g, const int rows, int n, const lanes_level *m, int steps)
{
    for (int k = 0; k < steps; k++) {
        lane y[WROWS];
        lanes_drive d;
        lanes_step(g, rows, m, y, &d);
        if (lanes_apart(g, y)) return k;
        lanes_read(g, rows, n, k, m, &d);
        for (int row = 0; row < rows; row++) g->x[row] = y[row];
        g->warmth = d.warmth;
        g->at += m->length;
    }
    return steps;
}

int KERNEL(wide_lanes_steps)(lanes *g, int n, const lanes_level *m, int steps)
{
    switch (g->run[0].rows) { /* lanes_constant, so that the loops over rows unroll */
    case WROWS: return lanes_steps(g, WROWS, n, m, steps);
    case EDDIES: return lanes_steps(g, EDDIES, n, m, steps);
    default: return lanes_steps(g, PLAIN, n, m, steps);
    }
}
