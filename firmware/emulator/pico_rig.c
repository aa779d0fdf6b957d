/* pico_rig.c: the rig of an emulated Pico. Starts the processor's emulator as a child and answers it:
 *
 *     pico_rig name=value ... -- COMMAND ARGUMENT ...     (names: rig parameters, see parameters.c)
 *
 * The child has this program's standard input and output; it asks on descriptor 4 and hears on 3. It asks for
 * a stretch of PWM periods before they pass, as if the bridge did the same in all of them. Where it comes
 * otherwise, or a trip opens it, the child asks again, and the stretch is computed anew from a copy of how it
 * began.
 *
 *     P  stretch  the next one             ->  answer
 *     B  stretch  the same one once more   ->  answer
 *     S  u32 n  text "name=value"          ->  nothing
 *     G  f64 cycle within the stretch      ->  u32 n, text: what is so then
 *     N  begin anew                        ->  nothing
 *
 * Times are cycles of the board's clock. Little-endian, as the machine is.
 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "parameters.h"

enum { PWM_TICKS = 6250, CONVERSION = 250, MOST = 4096, LOOK = 250 };
enum { CHILD_HEARS = 3, CHILD_ASKS = 4 };
static const int INPUTS[] = {CURRENT, TERMINAL_A, SUPPLY}; /* by the converter's number */
enum { INPUT_COUNT = sizeof INPUTS / sizeof *INPUTS };

struct stretch {
    double begin, end, cut;  /* cut: all inputs of the driver fall; below 0: they do not */
    double first;            /* conversion begins */
    struct wave a, b;        /* in each period */
    int32_t enable;
    uint32_t conversions, input; /* how many, of which input the first */
};

struct edge {
    double cycle;
    int32_t count, unused;
};

struct world {
    struct rig rig;
    long long count; /* that the encoder's lines show */
};

static struct world before, after; /* of the stretch that was answered */
static struct stretch latest;
static struct edge edges[MOST];
static uint16_t codes[MOST];
static uint32_t edge_count;

static FILE *asked, *told;

/* ------------------------------------------------------------------ a stretch */

static void note_edge(struct world *w, long long step) {
    w->count += step;
    if (edge_count < MOST) {
        edges[edge_count++] = (struct edge){(double)w->rig.at, (int32_t)w->count, 0};
    }
}

static void pass(struct world *w, uint64_t until) {
    while (w->rig.at < until) {
        const uint64_t left = until - w->rig.at;
        int step;
        const uint64_t wait = rig_next_count(&w->rig, w->count, left < LOOK ? left : LOOK, &step);
        rig_advance(&w->rig, w->rig.at + (wait > 0 ? wait : 1));
        for (long long now = rig_count(&w->rig); now != w->count;) {
            note_edge(w, now > w->count ? 1 : -1);
        }
    }
}

static void drive(struct world *w, int enable, struct wave a, struct wave b) {
    const enum driver kind = (enum driver)w->rig.par.driver;
    rig_enable(&w->rig, w->rig.at, driver_closes(kind, enable, a, b));
    rig_period(&w->rig, w->rig.at, driver_level(kind, a, b, PWM_TICKS));
}

static bool is_cut(const struct world *w, const struct stretch *p) {
    return p->cut >= 0.0 && (double)w->rig.at >= p->cut;
}

static void pass_or_cut(struct world *w, const struct stretch *p, uint64_t until) {
    const struct wave low = {0, 0};
    if (p->cut >= (double)w->rig.at && p->cut <= (double)until) {
        pass(w, (uint64_t)p->cut);
        drive(w, 0, low, low);
    }
    pass(w, until);
}

/* PWM periods begin all the way. */
static void pass_periods(struct world *w, const struct stretch *p, double until, double *next_period) {
    for (; *next_period <= until && *next_period < p->end; *next_period += PWM_TICKS) {
        pass_or_cut(w, p, (uint64_t)*next_period);
        if (!is_cut(w, p)) {
            drive(w, p->enable, p->a, p->b);
        }
    }
    pass_or_cut(w, p, (uint64_t)until);
}

static void run(struct world *w, const struct stretch *p) {
    double next_period = p->begin;
    edge_count = 0;
    pass(w, (uint64_t)p->begin);
    for (uint32_t n = 0; n < p->conversions; n++) {
        const double at = p->first + (double)n * CONVERSION;
        pass_periods(w, p, at, &next_period);
        codes[n] = (uint16_t)rig_convert(&w->rig, (uint64_t)at, INPUTS[(p->input + n) % INPUT_COUNT]);
    }
    pass_periods(w, p, p->end, &next_period);
}

static int answer(void) {
    struct stretch p;
    if (fread(&p, sizeof p, 1, asked) != 1 || p.conversions > MOST || p.input >= INPUT_COUNT) {
        return 0;
    }
    latest = p;
    after = before;
    run(&after, &p);
    const uint32_t counts[2] = {p.conversions, edge_count};
    fwrite(counts, sizeof counts, 1, told);
    fwrite(edges, sizeof *edges, edge_count, told);
    fwrite(codes, sizeof *codes, p.conversions, told);
    return fflush(told) == 0;
}

/* ------------------------------------------------------------------ the rest */

static int set_one(struct world *w, const char *name, double value) {
    if (strcmp(name, "supply") == 0) {
        plant_set_supply(&w->rig.plant, value);
    } else if (strcmp(name, "locked") == 0) {
        plant_lock(&w->rig.plant, (int)value);
    } else {
        return parameter_set(&w->rig.par, name, value);
    }
    return 1;
}

static int change(void) {
    char text[256];
    double value;
    uint32_t length;
    if (fread(&length, sizeof length, 1, asked) != 1 || length >= sizeof text
        || fread(text, 1, length, asked) != length) {
        return 0;
    }
    text[length] = 0;
    if (!parameter_split(text, &value) || !set_one(&before, text, value)) {
        fprintf(stderr, "nothing is called %s\n", text);
        return 0;
    }
    return set_one(&after, text, value);
}

static int tell(void) {
    static struct world then;
    char text[512];
    struct stretch p = latest;
    if (fread(&p.end, sizeof p.end, 1, asked) != 1) {
        return 0;
    }
    p.conversions = 0;
    then = before;
    run(&then, &p);
    const struct rig *const r = &then.rig;
    const uint32_t length = (uint32_t)snprintf(
        text, sizeof text,
        "{\"closed\": %d, \"level\": %d, \"current\": %.9g, \"speed\": %.9g, \"count\": %lld, \"bus\": %.9g}",
        r->enabled, r->level, r->plant.current, r->plant.speed, then.count, r->plant.bus);
    fwrite(&length, sizeof length, 1, told);
    fwrite(text, 1, length, told);
    return fflush(told) == 0;
}

static void begin(const struct rig_params *par) {
    memset(&latest, 0, sizeof latest);
    latest.cut = -1.0;
    rig_init(&after.rig, par, PWM_TICKS);
    after.count = rig_count(&after.rig);
    before = after;
}

static void serve(const struct rig_params *par) {
    int going = 1;
    while (going) {
        switch (fgetc(asked)) {
        case 'N':
            begin(par);
            break;
        case 'P':
            before = after;
            going = answer();
            break;
        case 'B':
            going = answer();
            break;
        case 'S':
            going = change();
            break;
        case 'G':
            going = tell();
            break;
        default:
            going = 0;
        }
    }
}

/* Only returns in the parent. */
static pid_t start(char **command) {
    int to_child[2], from_child[2];
    if (pipe(to_child) != 0 || pipe(from_child) != 0) {
        return -1;
    }
    const pid_t child = fork();
    if (child == 0) {
        const int hears = dup(to_child[0]), asks = dup(from_child[1]); /* out of the way of 3 and 4 */
        dup2(hears, CHILD_HEARS);
        dup2(asks, CHILD_ASKS);
        for (int descriptor = CHILD_ASKS + 1; descriptor <= asks; descriptor++) {
            close(descriptor);
        }
        execvp(command[0], command);
        perror(command[0]);
        _exit(127);
    }
    close(to_child[0]);
    close(from_child[1]);
    close(STDIN_FILENO); /* the child's alone: it ends with them */
    close(STDOUT_FILENO);
    told = fdopen(to_child[1], "wb");
    asked = fdopen(from_child[0], "rb");
    return child;
}

int main(int argc, char **argv) {
    struct rig_params par = {.seed = 1};
    int n = 1;
    for (; n < argc && strcmp(argv[n], "--") != 0; n++) {
        double value;
        if (!parameter_split(argv[n], &value) || !parameter_set(&par, argv[n], value)) {
            fprintf(stderr, "nothing is called %s\n", argv[n]);
            return 2;
        }
    }
    if (n + 1 >= argc) {
        fprintf(stderr, "pico_rig name=value ... -- COMMAND ARGUMENT ...\n");
        return 2;
    }
    const pid_t child = start(argv + n + 1);
    if (child < 0 || !asked || !told) {
        return 1;
    }
    serve(&par);
    fclose(told);
    waitpid(child, NULL, 0);
    return 0;
}
