/* The platform of a host: files by the C library. */
#include "platform.h"

#include <stdio.h>

static FILE *stream(const struct file *file) {
    return (FILE *)file->handle;
}

bool file_open(struct file *file, const char *name, enum file_use use) {
    FILE *opened = fopen(name, use == FILE_TO_READ ? "rb" : "wb");
    file->handle = (intptr_t)opened;
    return opened != NULL;
}

bool file_seek(struct file *file, uint32_t offset) {
    return fseek(stream(file), (long)offset, SEEK_SET) == 0;
}

bool file_read(struct file *file, void *bytes, size_t length) {
    return file_read_some(file, bytes, length) == length;
}

size_t file_read_some(struct file *file, void *bytes, size_t length) {
    return fread(bytes, 1, length, stream(file));
}

bool file_write(struct file *file, const void *bytes, size_t length) {
    return fwrite(bytes, 1, length, stream(file)) == length;
}

void print(const char *text) {
    fputs(text, stdout);
}

void complain(const char *text) {
    fputs(text, stderr);
}

struct memory_figures memory_figures(void) {
    return (struct memory_figures){0};
}
