/* encoder.c: the count, by a program of the first PIO.
 *
 * Sixteen jumps stand for the levels of A and B before and now; a move to the program counter takes the right
 * one. A round takes ten cycles at most (an edge forward), seven where nothing moved, so two edges 80 ns
 * apart are told apart. Y is the count, X the levels. Each round pushes the count if there is room, so what
 * is read after the four that may wait in the queue is new.
 */
#include "board.h"
#include "chip.h"

enum { UPDATE = 16, INCREMENT = 22, DECREMENT = 25, LAST = 26, WRAP = 24, QUEUE = 4, PATIENCE = 64 };

/* Instructions, by the data sheet's encoding. */
#define JMP(to) (to)
#define JMP_Y_DECREMENT(to) (4u << 5 | (to))
#define IN(source, bits) (0x4000u | (source) << 5 | (bits))
#define PUSH_IF_ROOM 0x8000u
#define MOV(to, from) (0xA000u | (to) << 5 | (from))
#define MOV_NOT(to, from) (0xA008u | (to) << 5 | (from))
#define SET(to, value) (0xE000u | (to) << 5 | (value))
enum { PINS = 0, X = 1, Y = 2, PC = 5, ISR = 6 };

/* By before << 2 | now, of which A is bit 0: A leads forward, 0 1 3 2. Two changes at once count for none. */
#define FORWARD JMP(INCREMENT)
#define BACKWARD JMP(DECREMENT)
#define STILL JMP(UPDATE)
static const uint16_t PROGRAM[LAST + 1] = {
    STILL, FORWARD, BACKWARD, STILL, BACKWARD, STILL, STILL, FORWARD,
    FORWARD, STILL, STILL, BACKWARD, STILL, BACKWARD, FORWARD, STILL,
    [UPDATE] = MOV(ISR, Y),
    PUSH_IF_ROOM, /* which clears ISR, full or not */
    IN(X, 2),
    IN(PINS, 2),
    MOV(X, ISR),
    MOV(PC, ISR),
    [INCREMENT] = MOV_NOT(Y, Y),
    JMP_Y_DECREMENT(WRAP),
    [WRAP] = MOV_NOT(Y, Y), /* and round to UPDATE */
    [DECREMENT] = JMP_Y_DECREMENT(UPDATE),
    [LAST] = JMP(UPDATE), /* from 0 to the largest number no jump is taken */
};

void encoder_begin(void) {
    const uint32_t pads = PAD_INPUT | PAD_UP | PAD_SCHMITT;
    REG(PAD(ENCODER_A_PIN)) = pads;
    REG(PAD(ENCODER_B_PIN)) = pads;
    reset_release(BIT(RESET_PIO0));
    for (uint32_t n = 0; n <= LAST; n++) {
        REG(PIO_INSTRUCTION(n)) = PROGRAM[n];
    }
    REG(PIO_SM0_CLKDIV) = 1u << 16;
    REG(PIO_SM0_EXECCTRL) = (uint32_t)WRAP << 12 | (uint32_t)UPDATE << 7;
    REG(PIO_SM0_SHIFTCTRL) = 0; /* to the left, and nothing by itself */
    REG(PIO_SM0_PINCTRL) = (uint32_t)ENCODER_A_PIN << 15;
    REG(PIO_SM0_INSTR) = SET(X, REG(SIO_GPIO_IN) >> ENCODER_A_PIN & 3u);
    REG(PIO_SM0_INSTR) = SET(Y, 0u);
    REG(PIO_SM0_INSTR) = JMP(UPDATE);
    REG(PIO_CTRL) = 1;
}

uint32_t encoder_read(void) {
    static uint32_t latest;
    for (int n = 0; n <= QUEUE; n++) {
        int patience = PATIENCE;
        while ((REG(PIO_FSTAT) & BIT(PIO_RX_EMPTY)) && --patience > 0) {
        }
        if (patience == 0) {
            break;
        }
        latest = REG(PIO_RXF0);
    }
    return latest;
}
