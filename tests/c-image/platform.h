/*
 * What the flight program needs of the machine it runs on: files, a line of text, memory figures.
 *
 * Two machines have it: a host (platform_host.c, by the C library) and the emulated on-board computer
 * (platform_obc.c, by semihosting calls).
 */
#ifndef PLATFORM_H
#define PLATFORM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How a file is opened. */
enum file_use {
    /* To read; it must exist. */
    FILE_TO_READ,
    /* To write from its beginning; what was there is lost. */
    FILE_TO_WRITE,
};

/* An open file; never closed: the end of the program does it. */
struct file {
    intptr_t handle;
};

/* Opens the file of that name; false where that cannot be done. */
bool file_open(struct file *file, const char *name, enum file_use use);

/* Moves to so many bytes from the beginning. */
bool file_seek(struct file *file, uint32_t offset);

/* Fills all of the bytes; false where the file ends before. */
bool file_read(struct file *file, void *bytes, size_t length);

/* Fills the bytes as far as the file reaches; the number read. */
size_t file_read_some(struct file *file, void *bytes, size_t length);

/* Writes all of the bytes. */
bool file_write(struct file *file, const void *bytes, size_t length);

/* Writes text to standard output; to standard error where it is a complaint. */
void print(const char *text);
void complain(const char *text);

/* What the program takes of the memory, bytes; all zero where the machine does not limit it. */
struct memory_figures {
    /* Vectors, code, constants and the initial values of data. */
    uint32_t flash_bytes;
    /* RAM that is taken from power-on. */
    uint32_t static_ram_bytes;
    /* Deepest the stack has been since power-on: what was touched. */
    uint32_t stack_bytes;
};

struct memory_figures memory_figures(void);

#endif
