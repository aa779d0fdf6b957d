/* main.c: an emulated board for another process, by a small protocol on standard input and output.
 * Time moves only while a request asks for it, so equal requests give equal answers.
 *
 *     emulator ELF MCU BOOT name=value ...     (BOOT: a bootloader's hex file, or "" for none;
 *                                               names: rig parameters, see parameters.c)
 *
 *     R  f64 until (s)  u32 n  n bytes   hear the bytes, run until then  ->  f64 now, u32 n, n bytes
 *     S  u32 n  text "name=value"        change something now            ->  f64 now, u32 0
 *     M                                  what was timed since the last M ->  f64 now, u32 n, text
 *     G                                  what is so now                  ->  f64 now, u32 n, text
 *
 * Little-endian, as the machine is.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "board.h"
#include "parameters.h"

enum { PWM_TICKS = 800, ROOM = 1 << 16 };
static const double BOARD_HZ = 16e6; /* nominal: time is told by the board's clock */

/* ------------------------------------------------------------------ requests */

static int take_bytes(void *into, size_t length) { return fread(into, 1, length, stdin) == length; }

static int answer(FILE *out, const struct board *b, const void *bytes, uint32_t length) {
    const double now = (double)board_cycle(b) / BOARD_HZ;
    fwrite(&now, sizeof now, 1, out);
    fwrite(&length, sizeof length, 1, out);
    fwrite(bytes, 1, length, out);
    return fflush(out) == 0;
}

static int run(struct board *b, FILE *out) {
    static uint8_t bytes[ROOM];
    double until;
    uint32_t length;
    if (!take_bytes(&until, sizeof until) || !take_bytes(&length, sizeof length) || length > ROOM
        || !take_bytes(bytes, length)) {
        return 0;
    }
    board_hear(b, bytes, length);
    if (!board_run(b, (uint64_t)ceil(until * BOARD_HZ))) {
        fprintf(stderr, "the emulated processor crashed\n");
        return 0;
    }
    return answer(out, b, bytes, (uint32_t)board_take(b, bytes, sizeof bytes));
}

static int change(struct board *b, struct rig *rig, FILE *out) {
    char text[256];
    double value;
    int place;
    uint32_t length;
    if (!take_bytes(&length, sizeof length) || length >= sizeof text || !take_bytes(text, length)) {
        return 0;
    }
    text[length] = 0;
    if (!parameter_split(text, &value)) {
        return 0;
    }
    rig_advance(rig, board_cycle(b));
    if (strcmp(text, "supply") == 0) {
        plant_set_supply(&rig->plant, value);
    } else if (strcmp(text, "locked") == 0) {
        plant_lock(&rig->plant, (int)value);
    } else if (strcmp(text, "encoder") == 0) {
        board_force_encoder(b, (int)value);
    } else if (strcmp(text, "reset") == 0) {
        board_reset(b, (int)value);
    } else if (strcmp(text, "power") == 0) {
        board_power(b, (uint32_t)value);
    } else if (strcmp(text, "wander") == 0) {
        board_wander(b);
    } else if (strcmp(text, "r2") == 0) {
        board_leave_r2(b, (int)value);
    } else if (strcmp(text, "hang") == 0) {
        return board_hang(b, 0) && answer(out, b, "", 0);
    } else if (strcmp(text, "stall") == 0) {
        return board_hang(b, 1) && answer(out, b, "", 0);
    } else if (strcmp(text, "unstall") == 0) {
        board_go_on(b);
    } else if (strcmp(text, "complain") == 0) {
        board_complain(b, (int)value);
    } else if (strcmp(text, "inputs") == 0) {
        board_close_inputs(b, (int)value);
    } else if (strcmp(text, "efuse") == 0) {
        board_set_fuse(b, (int)value);
    } else if (sscanf(text, "eeprom[%d]", &place) == 1) {
        board_write_eeprom(b, place, (uint8_t)value);
    } else if (strcmp(text, "chatter") == 0) {
        board_chatter(b, value);
    } else if (!parameter_set(&rig->par, text, value)) {
        fprintf(stderr, "nothing is called %s\n", text);
        return 0;
    }
    return answer(out, b, "", 0);
}

static int tell(struct board *b, struct rig *rig, FILE *out) {
    char text[1024];
    const struct board_facts f = board_facts(b);
    rig_advance(rig, board_cycle(b));
    const int length = snprintf(
        text, sizeof text,
        "{\"enabled\": %d, \"level\": %d, \"changed\": %.9f, \"current\": %.9g, \"speed\": %.9g,"
        " \"count\": %lld, \"bus\": %.9g, \"resets\": %" PRIu64 ", \"asleep\": %.9f,"
        " \"edges\": %" PRIu64 ", \"stack_left\": %d, \"a\": [%d, %d], \"b\": [%d, %d], \"enable\": %d, \"recalled\": %d}",
        rig->enabled, rig->level, (double)rig->opened_at / BOARD_HZ, rig->plant.current,
        rig->plant.speed, rig_count(rig), rig->plant.bus, f.resets, (double)f.asleep / BOARD_HZ,
        f.edges, f.stack_left, f.inputs[0].from, f.inputs[0].to, f.inputs[1].from,
        f.inputs[1].to, f.enable, f.recalled);
    return answer(out, b, text, (uint32_t)length);
}

static int tell_times(struct board *b, FILE *out) {
    char text[2048];
    const int length = meter_tell(board_meter(b), board_cycle(b), text, sizeof text);
    meter_clear(board_meter(b), board_cycle(b));
    return answer(out, b, text, (uint32_t)length);
}

static void serve(struct board *b, struct rig *rig, FILE *out) {
    int going = 1;
    while (going) {
        switch (getchar()) {
        case 'R':
            going = run(b, out);
            break;
        case 'S':
            going = change(b, rig, out);
            break;
        case 'M':
            going = tell_times(b, out);
            break;
        case 'G':
            going = tell(b, rig, out);
            break;
        default:
            going = 0;
        }
    }
}

int main(int argc, char **argv) {
    static struct rig rig;
    struct rig_params par = {.seed = 1};
    if (argc < 4) {
        fprintf(stderr, "emulator ELF MCU BOOT name=value ...\n");
        return 2;
    }
    for (int n = 4; n < argc; n++) {
        double value;
        if (!parameter_split(argv[n], &value) || !parameter_set(&par, argv[n], value)) {
            fprintf(stderr, "nothing is called %s\n", argv[n]);
            return 2;
        }
    }
    FILE *const out = fdopen(dup(STDOUT_FILENO), "wb"); /* libsimavr chats on standard output */
    if (!out || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) {
        return 1;
    }
    rig_init(&rig, &par, PWM_TICKS);
    struct board *const b = board_new(argv[1], argv[2], &rig);
    if (!b || (argv[3][0] && !board_boot(b, argv[3]))) {
        return 1;
    }
    serve(b, &rig, out);
    return 0;
}
