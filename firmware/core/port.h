/* port.h: what a board supplies, and nothing else about it is known to the core.
 *
 * A port defines the one object `port`, calls core_init() once, core_sample() from its sample
 * interrupt and core_poll() from its main loop (core.h). docs/porting.md leads through it.
 * With link-time optimisation the calls through this constant object cost nothing.
 */
#ifndef PORT_H
#define PORT_H

#include "core.h"

/* Bytes of memory for facts of the front end. */
#define FRONT_END_MEMORY (2 * (WIRE_WRITE_FRONT_END_SIZE + 6))

/* The interrupt state that `lock` found, for `unlock`. */
typedef uint8_t port_lock;

struct port {
    /* ---- facts, told to the host by identify; they must be true of this board */
    char board[16];                    /* name, zero-padded */
    uint32_t clock_hz;                 /* ticks in a second */
    uint16_t clock_uncertainty_ppm;    /* half width of the clock's tolerance */
    uint32_t pwm_hz;
    uint16_t dead_time_ns;
    uint8_t decay_modes;               /* bit n: WIRE_DECAY_ n is available */
    uint8_t channels;                  /* bit n: WIRE_CHANNEL_ n is measured; current and position
                                        * always are */
    uint32_t min_sample_period_ticks;  /* may be another one over another link, from read() on */
    uint32_t sample_period_step_ticks; /* ticks of one PWM period, as a rule */
    uint32_t idle_sample_period_ticks; /* until the first configure */
    uint32_t burst_sample_period_ticks; /* of a fast burst, at most 255 of them in the least common
                                         * multiple with min_sample_period_ticks; 0: there is none */
    uint16_t burst_bytes;              /* that burst_keep() fills */
    uint32_t encoder_edge_ceiling_hz;
    uint32_t position_delay_ns;        /* from when the encoder is read to the sample's tick */
    uint32_t max_current_ma;           /* below what saturates the converter; no facts of the front end
                                        * raise it */
    uint16_t max_host_silence_ms;
    uint16_t full_duty;                /* the bridge's levels reach from -full_duty to full_duty;
                                        * at most 32767 */

    /* Descriptor of a measured channel other than position; the fields are describe_channel's and
     * come zeroed, `channel` set. No scale is 0, and the supply's is positive. */
    void (*describe)(uint8_t channel, wire_describe_channel_reply_t *out);

    /* ---- fast burst; both unused without a burst_sample_period_ticks.
     * What of that descriptor is otherwise in a fast burst: kind, aperture, delay, bits, noise. */
    void (*describe_burst)(uint8_t channel, wire_describe_channel_reply_t *out);
    /* The sample period that ended was that multiple, and the readings of a fast burst in it were taken
     * beside the one for core_sample(): put what is needed of them into `burst_bytes` bytes. During
     * core_sample(), so it should be quick. */
    void (*burst_keep)(uint8_t *bytes);
    /* And take reading n out of those bytes, the oldest is 0. From the main loop, after the run. */
    void (*burst_reading)(const uint8_t *bytes, uint8_t n, struct reading *out);

    /* ---- bridge. Called from the sample interrupt; bridge_open also from the main loop, locked.
     * What a step asks for acts at the tick of the sample that is being taken, what a trip or a stop
     * asks for at once: see docs/porting.md. */
    void (*bridge_open)(void);  /* all switches off, at once; overrules what waits for its tick */
    void (*bridge_coast)(void); /* all switches off, at the tick; NULL: the tick is at once */
    void (*bridge_brake)(void);
    void (*bridge_drive)(int16_t level, uint8_t decay); /* level: -full_duty to full_duty */

    /* Drivers that the port can drive: bit n, WIRE_BRIDGE_ n; 0: half-bridges alone. Facts of a front end
     * that name another are refused. */
    uint8_t bridges;
    /* The driver that the facts name: called locked, with the bridge open, when a configuration is taken.
     * NULL: all are driven alike. Before the first call every input of a driver is low. */
    void (*set_bridge)(uint8_t bridge);

    /* ---- core_watch() sees every reading before core_sample() does, which then takes its word */
    bool watches;

    /* ---- sampling. Called locked, with the bridge open: from the next sample on, core_sample()
     * comes every so many ticks. */
    void (*set_sample_period)(uint32_t ticks);

    /* ---- link, from the main loop; neither ever waits. */
    bool (*read)(uint8_t *byte);                               /* false: nothing there */
    uint16_t (*write)(const uint8_t *bytes, uint16_t length);  /* bytes taken, perhaps 0 */

    /* ---- keep the sample interrupt out, for a few dozen instructions */
    port_lock (*lock)(void);
    void (*unlock)(port_lock before);

    /* ---- digital inputs; a contact to ground closes one, and an open line is open */
    uint8_t inputs;                   /* bit n: WIRE_INPUT_ n has a pin; 0: none, the rest is unused */
    uint8_t (*inputs_closed)(void);   /* bit n: it is closed now; from both threads, quickly */
    void (*input_pin)(uint8_t input, char pin[16]); /* as printed on the board; comes zeroed */

    /* ---- facts of the front end, of which `describe` makes descriptors (core.h has front_end_f32() and
     * others). NULL: this board keeps none, and the rest is unused. FRONT_END_MEMORY bytes that outlast
     * resets and losses of power; from the main loop. */
    uint8_t (*memory_read)(uint8_t at);
    bool (*memory_write)(uint8_t at, uint8_t byte); /* begins it; false: the last one is not over yet */
    uint8_t (*front_end_byte)(uint8_t at); /* of facts that the firmware has, as write_front_end has them */
    bool front_end_holds;                  /* where none are stored the board drives with those */

    /* ---- the processor's supply: least for its clock; 0: not known, and brown_out_mv unused */
    uint16_t brown_out_least_mv;
    uint16_t (*brown_out_mv)(void); /* where its detector resets; 0: it is off */

    /* ---- the last reset */
    uint8_t (*reset_cause)(void); /* WIRE_RESET_CAUSE_ */
    uint32_t (*boot_id)(void);    /* another number after every reset */
};

/* Constant, but for the host's port, whose facts come from its command line, a port of two links, and tests. */
#ifndef PORT_CONST
#define PORT_CONST const
#endif

extern PORT_CONST struct port port;

#endif
