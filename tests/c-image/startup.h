/* What happens on the on-board computer before and after main; symbols of the linker script (image.ld). */
#ifndef STARTUP_H
#define STARTUP_H

#include <stddef.h>
#include <stdint.h>

/* The stack is filled with this before main, so that its depth can be seen. */
#define STACK_PAINT 0xccccccccu

/* The RAM's beginning, the initial values of data in flash and their place, zeroed data, both ends of the
 * stack. */
extern uint32_t ram_start[], data_image[], data_start[], data_end[], bss_start[], bss_end[];
extern uint32_t stack_end[], stack_start[];

/* The command line of the emulator cut into words, at most so many; their number. */
int command_line(char *line, size_t room, char **words, int most);

/* Ends the emulation with a status. */
_Noreturn void leave(int status);

#endif
