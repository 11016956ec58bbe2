/* Vector table, reset and faults of a Cortex-M4F. */
#include "startup.h"

#include "platform.h"

int main(int argc, char **argv);
_Noreturn void reset(void);

enum {
    STATUS_FAULT = 3,
    MOST_WORDS = 8,
};

/* Coprocessor access control: the floating-point unit is coprocessors 10 and 11. */
static volatile uint32_t *const CPACR = (volatile uint32_t *)0xe000ed88u;

/* Any fault ends the run: without a handler the emulator would spin for ever. */
static _Noreturn void fault(void) {
    complain("processor fault\n");
    leave(STATUS_FAULT);
}

/* Fills the stack below the frame of this function. */
static void paint_stack(void) {
    volatile uint32_t *top = __builtin_frame_address(0);
    for (volatile uint32_t *word = stack_end; word < top - 16; word++) {
        *word = STACK_PAINT;
    }
}

/* Begins with the unit off: no instruction of it may stand before it is switched on. */
__attribute__((noinline)) static _Noreturn void run(void) {
    static char line[1024];
    static char *words[MOST_WORDS];
    int count = command_line(line, sizeof line, words, MOST_WORDS);
    leave(main(count, words));
}

_Noreturn void reset(void) {
    *CPACR |= 0xfu << 20;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    for (uint32_t *from = data_image, *to = data_start; to < data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *word = bss_start; word < bss_end;) {
        *word++ = 0;
    }
    paint_stack();
    run();
}

/* Stack pointer, reset, then the faults: NMI, hard, memory, bus, usage. No interrupt is used. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*handlers[6])(void);
} vectors = {stack_start, {reset, fault, fault, fault, fault, fault}};
