/*
 * The platform of the emulated on-board computer: files by Arm semihosting calls, one breakpoint
 * instruction each; memory figures by the linker's symbols and the painted stack.
 */
#include "platform.h"
#include "startup.h"

/* Numbers of the calls (Arm semihosting specification). */
enum call {
    SYS_OPEN = 0x01,
    SYS_WRITE = 0x05,
    SYS_READ = 0x06,
    SYS_SEEK = 0x0a,
    SYS_GET_CMDLINE = 0x15,
    SYS_EXIT_EXTENDED = 0x20,
};

/* Modes of SYS_OPEN, and the name that is standard output or, to append, standard error. */
enum mode {
    MODE_READ_BINARY = 1,
    MODE_WRITE_BINARY = 5,
    MODE_APPEND_BINARY = 9,
};
static const char CONSOLE[] = ":tt";

/* ADP_Stopped_ApplicationExit, the only reason that lets the status through. */
static const uintptr_t APPLICATION_EXIT = 0x20026;

static intptr_t call_host(enum call number, const void *block) {
    register intptr_t answer __asm__("r0") = number;
    register const void *arguments __asm__("r1") = block;
    __asm__ volatile("bkpt 0xab" : "+r"(answer) : "r"(arguments) : "memory");
    return answer;
}

static uintptr_t length_of(const char *text) {
    uintptr_t length = 0;
    while (text[length] != '\0') {
        length++;
    }
    return length;
}

static bool open_mode(struct file *file, const char *name, enum mode mode) {
    const uintptr_t block[] = {(uintptr_t)name, mode, length_of(name)};
    file->handle = call_host(SYS_OPEN, block);
    return file->handle != -1;
}

bool file_open(struct file *file, const char *name, enum file_use use) {
    return open_mode(file, name, use == FILE_TO_READ ? MODE_READ_BINARY : MODE_WRITE_BINARY);
}

bool file_seek(struct file *file, uint32_t offset) {
    const uintptr_t block[] = {(uintptr_t)file->handle, offset};
    return call_host(SYS_SEEK, block) == 0;
}

bool file_read(struct file *file, void *bytes, size_t length) {
    return file_read_some(file, bytes, length) == length;
}

size_t file_read_some(struct file *file, void *bytes, size_t length) {
    const uintptr_t block[] = {(uintptr_t)file->handle, (uintptr_t)bytes, length};
    /* The answer is the number of bytes left over, beyond the length in an error. */
    size_t left = (size_t)call_host(SYS_READ, block);
    return left <= length ? length - left : 0;
}

bool file_write(struct file *file, const void *bytes, size_t length) {
    const uintptr_t block[] = {(uintptr_t)file->handle, (uintptr_t)bytes, length};
    return call_host(SYS_WRITE, block) == 0;
}

static void write_text(enum mode mode, const char *text) {
    struct file console;
    if (open_mode(&console, CONSOLE, mode)) {
        (void)file_write(&console, text, length_of(text));
    }
}

void print(const char *text) {
    write_text(MODE_WRITE_BINARY, text);
}

void complain(const char *text) {
    write_text(MODE_APPEND_BINARY, text);
}

int command_line(char *line, size_t room, char **words, int most) {
    uintptr_t block[] = {(uintptr_t)line, room};
    int count = 0;
    if (call_host(SYS_GET_CMDLINE, block) != 0) {
        return 0;
    }
    for (char *letter = line; *letter != '\0' && count < most;) {
        words[count++] = letter;
        while (*letter != '\0' && *letter != ' ') {
            letter++;
        }
        while (*letter == ' ') {
            *letter++ = '\0';
        }
    }
    return count;
}

_Noreturn void leave(int status) {
    const uintptr_t block[] = {APPLICATION_EXIT, (uintptr_t)status};
    for (;;) {
        call_host(SYS_EXIT_EXTENDED, block);
    }
}

struct memory_figures memory_figures(void) {
    const uint32_t *word = stack_end;
    while (word < stack_start && *(const volatile uint32_t *)word == STACK_PAINT) {
        word++;
    }
    return (struct memory_figures){
        /* Flash begins at address 0, and the initial values of data are the last thing in it. */
        .flash_bytes = (uint32_t)((uintptr_t)data_image + ((uintptr_t)data_end - (uintptr_t)data_start)),
        .static_ram_bytes = (uint32_t)((uintptr_t)stack_end - (uintptr_t)ram_start),
        .stack_bytes = (uint32_t)((uintptr_t)stack_start - (uintptr_t)word),
    };
}
