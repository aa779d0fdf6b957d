#include "guard.h"

#include <math.h>

int stretches_fit(int count, const mr_stretch *stretches, int n_stretches)
{
    int last = 0;
    if (count < 1 || n_stretches < 1 || stretches[0].start > 1) return 0;
    for (int k = 0; k < n_stretches; k++) {
        if (stretches[k].start < last || stretches[k].start > count) return 0;
        last = stretches[k].start;
    }
    return 1;
}

static int span_fits(double span, double most)
{
    return span >= 0.0 && span <= most; /* NaN does neither */
}

int outputs_fit(double period, const mr_output *outputs, int n_outputs)
{
    const double most = MOST_INTERVALS * period;
    if (!(period > 0.0 && isfinite(most)) || n_outputs < 1) return 0;
    for (int j = 0; j < n_outputs; j++) {
        const mr_output *o = &outputs[j];
        if (!span_fits(o->aperture, most) || !span_fits(o->delay, most)) return 0;
        if (!(o->filter >= 0.0 && isfinite(o->filter))) return 0;
        if (!(o->pwm_phase <= 1.0) || o->quantity < MR_CURRENT || o->quantity > MR_POSITION)
            return 0;
    }
    return 1;
}
