/* Little-endian numbers in the files of a recording. */
#ifndef LITTLE_ENDIAN_H
#define LITTLE_ENDIAN_H

#include <stdint.h>

static inline uint16_t u16_at(const uint8_t *bytes) {
    return (uint16_t)(bytes[0] | bytes[1] << 8);
}

static inline uint32_t u32_at(const uint8_t *bytes) {
    return u16_at(bytes) | (uint32_t)u16_at(bytes + 2) << 16;
}

static inline int64_t i64_at(const uint8_t *bytes) {
    return (int64_t)(u32_at(bytes) | (uint64_t)u32_at(bytes + 4) << 32);
}

#endif
