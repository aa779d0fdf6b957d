/* iron.c: see iron.h. It shares nothing with the fit's model. */
#include "iron.h"

#include <math.h>

double iron_reaction(const plant_params *m, double current)
{
    double bend = m->reaction_bend;
    if (m->reaction == 0.0)
        return 1.0;
    return 1.0 - m->reaction * (sqrt(current * current + bend * bend) - bend) / m->reaction_current;
}

double iron_slope(const plant_params *m, double current)
{
    double ratio;
    if (m->saturation == 0.0)
        return 1.0;
    ratio = current / m->saturation_current;
    return 1.0 - m->saturation * ratio * ratio / (1.0 + ratio * ratio);
}

double iron_eddy(const plant_params *m, double current, double eddy_current, double *rate)
{
    double volts;
    *rate = 0.0;
    if (m->eddy_share == 0.0)
        return 0.0;
    volts = m->eddy_resistance * (current - eddy_current);
    *rate = volts / (m->eddy_share * m->inductance * iron_slope(m, eddy_current));
    return volts;
}

static double field_energy(const plant_params *m, double current)
{
    double square = current * current, knee, lost = 0.0;
    if (m->saturation != 0.0) {
        knee = m->saturation_current * m->saturation_current;
        lost = m->saturation * (square - knee * log1p(square / knee));
    }
    return 0.5 * m->inductance * (square - lost);
}

double iron_energy(const plant_params *m, double current, double eddy_current)
{
    return (1.0 - m->eddy_share) * field_energy(m, current)
           + m->eddy_share * field_energy(m, eddy_current);
}

double iron_time_constant(const plant_params *m, double resistance)
{
    double left = m->inductance * (1.0 - m->saturation), rate;
    if (m->eddy_share == 0.0)
        return left / resistance;
    rate = (resistance + m->eddy_resistance) / (left * (1.0 - m->eddy_share));
    return 1.0 / (rate + m->eddy_resistance / (left * m->eddy_share));
}
