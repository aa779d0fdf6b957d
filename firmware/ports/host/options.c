/* options.c: see options.h. */
#include "options.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct place {
    const char *name;
    size_t offset;
    bool is_int;
    bool wanted; /* there is no sensible value when it is missing */
};

#define IN(type, field) {#field, offsetof(type, field), false, true}
#define MAYBE(type, field) {#field, offsetof(type, field), false, false}
#define FLAG(type, field) {#field, offsetof(type, field), true, false}

static const struct place BOARD[] = {
    IN(struct options, clock_hz), IN(struct options, clock_uncertainty_ppm),
    IN(struct options, pwm_hz), IN(struct options, dead_time_ns), IN(struct options, decay_modes),
    IN(struct options, min_sample_period_ticks), IN(struct options, sample_period_step_ticks),
    IN(struct options, encoder_edge_ceiling_hz), IN(struct options, max_current_ma),
    IN(struct options, max_host_silence_ms), IN(struct options, burst_sample_period_ticks),
    IN(struct options, front_end_holds), IN(struct options, reference_v),
    IN(struct options, brown_out_mv), IN(struct options, brown_out_least_mv),
    IN(struct options, true_clock_hz),
    IN(struct options, counts_per_turn), MAYBE(struct options, encoder_angle),
    MAYBE(struct options, seed), MAYBE(struct options, baud), MAYBE(struct options, first_tick),
    MAYBE(struct options, reset_cause), {0},
};

/* Every field of plant_params, as the Makefile finds them in plant.h. */
#define PLANT_double(field) IN(plant_params, field),
#define PLANT_int(field) FLAG(plant_params, field),
static const struct place PLANT[] = {
#include "plant_fields.h"
    {0},
};

static const struct place CONVERTER[] = {
    IN(struct converter, gain), IN(struct converter, true_offset),
    IN(struct converter, true_aperture), IN(struct converter, true_delay),
    IN(struct converter, unit), IN(struct converter, kind), IN(struct converter, bits),
    IN(struct converter, scale), IN(struct converter, offset), IN(struct converter, aperture_ns),
    IN(struct converter, delay_ns), IN(struct converter, filter_ns), IN(struct converter, filter2_ns),
    IN(struct converter, pwm_phase_permille),
    IN(struct converter, gain_uncertainty), IN(struct converter, offset_uncertainty),
    IN(struct converter, noise), IN(struct converter, raw_min), IN(struct converter, raw_max), {0},
};

/* Groups of values, told apart by what stands before the point. */
static const struct group {
    const char *prefix;
    size_t offset;
    const struct place *places;
} GROUPS[] = {
    {"", 0, BOARD},
    {"plant.", offsetof(struct options, plant), PLANT},
    {"current.", offsetof(struct options, converter[0]), CONVERTER},
    {"terminal_voltage.", offsetof(struct options, converter[1]), CONVERTER},
    {"supply_voltage.", offsetof(struct options, converter[2]), CONVERTER},
};

enum { GROUP_COUNT = sizeof GROUPS / sizeof GROUPS[0] };

static void put(struct options *o, const struct group *g, const struct place *place, double value) {
    char *const at = (char *)o + g->offset + place->offset;
    if (place->is_int) {
        const int whole = value != 0.0;
        memcpy(at, &whole, sizeof whole);
    } else {
        memcpy(at, &value, sizeof value);
    }
}

static bool is_missing(const struct options *o, const struct group *g, const struct place *place) {
    double value;
    memcpy(&value, (const char *)o + g->offset + place->offset, sizeof value);
    return place->wanted && isnan(value);
}

static const struct place *find(const struct group *g, const char *name, size_t length) {
    for (const struct place *place = g->places; place->name != NULL; place++) {
        if (strlen(place->name) == length && strncmp(place->name, name, length) == 0) {
            return place;
        }
    }
    return NULL;
}

/* NAME=VALUE */
static bool take_value(struct options *o, const char *text) {
    const char *const equals = strchr(text, '=');
    if (equals == NULL || equals[1] == '\0') {
        fprintf(stderr, "board: %s: write NAME=VALUE, --socket, --pty or --speed\n", text);
        return false;
    }
    char *end;
    const double value = strtod(equals + 1, &end);
    if (*end != '\0' || !isfinite(value)) {
        fprintf(stderr, "board: %s: the value is not a number\n", text);
        return false;
    }
    for (int n = 0; n < GROUP_COUNT; n++) {
        const size_t prefix = strlen(GROUPS[n].prefix);
        if (strncmp(text, GROUPS[n].prefix, prefix) == 0) {
            const char *const name = text + prefix;
            const struct place *const place = find(&GROUPS[n], name, (size_t)(equals - name));
            if (place != NULL) {
                put(o, &GROUPS[n], place, value);
                return true;
            }
        }
    }
    fprintf(stderr, "board: %s: no such value\n", text);
    return false;
}

/* --NAME and, where it takes one, its argument; 0: not understood, else arguments used. */
static int take_flag(struct options *o, int left, char **argv) {
    if (strcmp(argv[0], "--pty") == 0) {
        o->pty = true;
        return 1;
    }
    if (left < 2) {
        return 0;
    }
    if (strcmp(argv[0], "--socket") == 0) {
        char *end;
        o->socket = (int)strtol(argv[1], &end, 10);
        return *end == '\0' && o->socket >= 0 && o->socket < 65536 ? 2 : 0;
    }
    if (strcmp(argv[0], "--speed") == 0) {
        static const char *const paces[] = {"realtime", "max", "lockstep"};
        for (int pace = PACE_REALTIME; pace <= PACE_LOCKSTEP; pace++) {
            if (strcmp(argv[1], paces[pace]) == 0) {
                o->pace = (enum pace)pace;
                return 2;
            }
        }
    }
    return 0;
}

static void fill_wanted(struct options *o) {
    *o = (struct options){.socket = -1, .pace = PACE_REALTIME};
    for (int n = 0; n < GROUP_COUNT; n++) {
        for (const struct place *place = GROUPS[n].places; place->name != NULL; place++) {
            if (place->wanted) {
                put(o, &GROUPS[n], place, NAN);
            }
        }
    }
}

static bool is_complete(const struct options *o) {
    for (int n = 0; n < GROUP_COUNT; n++) {
        for (const struct place *place = GROUPS[n].places; place->name != NULL; place++) {
            if (is_missing(o, &GROUPS[n], place)) {
                fprintf(stderr, "board: %s%s is missing; board.py gives all of them\n",
                        GROUPS[n].prefix, place->name);
                return false;
            }
        }
    }
    if (o->pty == (o->socket >= 0)) {
        fprintf(stderr, "board: give --socket PORT or --pty\n");
        return false;
    }
    return true;
}

bool options_read(struct options *o, int argc, char **argv) {
    fill_wanted(o);
    for (int at = 1; at < argc;) {
        if (strncmp(argv[at], "--", 2) != 0) {
            if (!take_value(o, argv[at++])) {
                return false;
            }
            continue;
        }
        const int used = take_flag(o, argc - at, argv + at);
        if (used == 0) {
            fprintf(stderr, "board: %s: not understood\n", argv[at]);
            return false;
        }
        at += used;
    }
    return is_complete(o);
}
