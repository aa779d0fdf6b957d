#include "root.h"

#define STEPS 100
#define REGULA_FALSI 40 /* steps of it, then halving */
#define SOON 1e-3       /* of the interval */

double use_up(margin_at margin, const void *what, double end, double resolution)
{
    double a = 0.0, b = end, fa = margin(what, 0.0), fb;
    if (fa <= 0.0) {
        a = SOON * end;
        fa = margin(what, a);
        if (fa <= 0.0) return 0.0;
    }
    fb = margin(what, b);
    for (int n = 0; n < STEPS && b - a > resolution; n++) { /* Illinois */
        double c = n < REGULA_FALSI ? (a * fb - b * fa) / (fb - fa) : 0.5 * (a + b), fc;
        if (!(c > a && c < b)) c = 0.5 * (a + b);
        fc = margin(what, c);
        if (fc == 0.0) return c;
        if (fc < 0.0) {
            b = c, fb = fc, fa *= 0.5;
        } else {
            a = c, fa = fc, fb *= 0.5;
        }
    }
    return 0.5 * (a + b);
}
