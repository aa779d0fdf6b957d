/* Responses of many candidate motors to one record: batch.c says how. */
#ifndef MOTORID_BATCH_H
#define MOTORID_BATCH_H

typedef struct {
    int samples, channels;
    const double *input;       /* (samples) held input: V, or N·m */
    const unsigned char *open; /* (samples) 1: bridge open from this sample to the next; or NULL */
    const double *measured;    /* (channels, samples) */
    const int *pick;           /* (channels) which state a channel shows */
    const double *lag;         /* (channels) readings lie this part of a sample back, 0 to 1 */
    double *squares;           /* (n, channels) out: sums of squared differences */
    double *outputs;           /* (n, channels, samples) out, or NULL */
} batch_record;

void batch_lti(const batch_record *r, int n, int states, const double *discrete);
void batch_friction(const batch_record *r, int n, const double *motor);
void batch_quadratic(const batch_record *r, int n, const double *motor, double dt, int substeps);
void batch_expm(int n, int m, const double *matrices, double *out);

/* Which instructions the first three use from now on: at most these, 0 for those that every
 * processor has, 1 for AVX2. Returns those in use. They begin with the most that there are. */
int batch_instructions(int most);

#endif
