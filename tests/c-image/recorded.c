#include "recorded.h"
#include "little_endian.h"

enum {
    HEADER_BYTES = 16,
    HEAD_BYTES = 56,
    PIXEL_BYTES = 2,
    VERSION = 5,
};

/* The largest file whose offsets the host takes. */
static const uint64_t LARGEST_FILE_BYTES = INT32_MAX;

static float f32_at(const uint8_t *bytes) {
    const union {
        uint32_t bits;
        float value;
    } number = {.bits = u32_at(bytes)};
    return number.value;
}

/* Bytes of a frame with what stands before its pixels. */
static uint32_t frame_bytes(const struct sextant_geometry *geometry) {
    return HEAD_BYTES + (uint32_t)geometry->width_px * geometry->height_px * PIXEL_BYTES;
}

const char *recording_open(struct recording *recording, const char *name) {
    uint8_t header[HEADER_BYTES];
    if (!file_open(&recording->file, name, FILE_TO_READ) ||
        !file_read(&recording->file, header, sizeof header)) {
        return "FRAMES: cannot be read or is shorter than a header\n";
    }
    if (header[0] != 'S' || header[1] != 'X' || header[2] != 'T' || header[3] != 'F') {
        return "FRAMES: offset 0: does not begin with SXTF\n";
    }
    if (u16_at(header + 4) != VERSION || header[11] != 0) {
        return "FRAMES: offset 4: version is not 5\n";
    }
    recording->geometry.width_px = u16_at(header + 6);
    recording->geometry.height_px = u16_at(header + 8);
    recording->geometry.bits = header[10];
    recording->frames = u32_at(header + 12);
    recording->exposed = false;
    uint64_t area = (uint64_t)recording->geometry.width_px * recording->geometry.height_px;
    uint64_t frame = HEAD_BYTES + area * PIXEL_BYTES;
    if (area == 0 || recording->frames == 0 || recording->geometry.width_px > INT16_MAX ||
        recording->frames > (LARGEST_FILE_BYTES - HEADER_BYTES) / frame) {
        return "FRAMES: offset 6: impossible geometry or frame count\n";
    }
    return NULL;
}

void recording_turn_to(struct recording *recording, uint32_t second) {
    uint8_t head[HEAD_BYTES];
    recording->second = second;
    recording->local_us = INT64_MIN;
    recording->terrestrial_us = INT64_MIN;
    recording->rate.local_us = INT64_MIN;
    recording->field.local_us = INT64_MIN;
    if (file_seek(&recording->file, HEADER_BYTES + second * frame_bytes(&recording->geometry)) &&
        file_read(&recording->file, head, sizeof head)) {
        recording->local_us = i64_at(head);
        recording->terrestrial_us = i64_at(head + 8);
        recording->rate.local_us = i64_at(head + 16);
        for (int axis = 0; axis < 3; axis++) {
            recording->rate.rad_s[axis] = f32_at(head + 24 + 4 * axis);
        }
        recording->field.local_us = i64_at(head + 36);
        for (int axis = 0; axis < 3; axis++) {
            recording->field.ut[axis] = f32_at(head + 44 + 4 * axis);
        }
    }
}

static uint32_t start_exposure(void *context, uint32_t exposure_us) {
    struct recording *recording = context;
    (void)exposure_us;
    recording->exposed = true;
    return SEXTANT_REPLY_OK;
}

static uint32_t finish_exposure(void *context, int64_t *local_us) {
    const struct recording *recording = context;
    *local_us = recording->local_us;
    return recording->exposed ? SEXTANT_REPLY_OK : SEXTANT_REPLY_NOT_EXPOSED;
}

/* Reads consecutive pixels from column x of row y on. */
static bool read_run(struct recording *recording, uint16_t x, uint16_t y, uint16_t *pixels, size_t count) {
    uint32_t frame = HEADER_BYTES + recording->second * frame_bytes(&recording->geometry);
    uint32_t place = (uint32_t)y * recording->geometry.width_px + x;
    if (!file_seek(&recording->file, frame + HEAD_BYTES + place * PIXEL_BYTES) ||
        !file_read(&recording->file, pixels, count * PIXEL_BYTES)) {
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        pixels[i] = u16_at((const uint8_t *)&pixels[i]);
    }
    return true;
}

static uint32_t read_window(void *context, struct sextant_window window, uint16_t *pixels, size_t count) {
    struct recording *recording = context;
    if (!recording->exposed) {
        return SEXTANT_REPLY_NOT_EXPOSED;
    }
    if (window.width == recording->geometry.width_px) {
        return read_run(recording, window.x, window.y, pixels, count) ? SEXTANT_REPLY_OK : SEXTANT_REPLY_BUS;
    }
    for (uint16_t row = 0; row < window.height; row++) {
        uint16_t y = (uint16_t)(window.y + row);
        if (!read_run(recording, window.x, y, pixels + (size_t)row * window.width, window.width)) {
            return SEXTANT_REPLY_BUS;
        }
    }
    return SEXTANT_REPLY_OK;
}

static uint32_t local_time(void *context, int64_t *local_us) {
    const struct recording *recording = context;
    *local_us = recording->local_us;
    return SEXTANT_REPLY_OK;
}

/* Terrestrial Time runs as the counter does. */
static uint32_t terrestrial_time(void *context, int64_t local_us, int64_t *terrestrial_us) {
    const struct recording *recording = context;
    if (recording->terrestrial_us == INT64_MIN) {
        return SEXTANT_REPLY_NOT_SYNCHRONISED;
    }
    *terrestrial_us = recording->terrestrial_us + (local_us - recording->local_us);
    return SEXTANT_REPLY_OK;
}

static uint32_t angular_rate(void *context, struct sextant_angular_rate *reading) {
    const struct recording *recording = context;
    *reading = recording->rate;
    return recording->rate.local_us == INT64_MIN ? SEXTANT_REPLY_NO_READING : SEXTANT_REPLY_OK;
}

static uint32_t magnetic_field(void *context, struct sextant_magnetic_field_reading *reading) {
    const struct recording *recording = context;
    *reading = recording->field;
    return recording->field.local_us == INT64_MIN ? SEXTANT_REPLY_NO_READING : SEXTANT_REPLY_OK;
}

struct sextant_instruments recording_instruments(struct recording *recording) {
    return (struct sextant_instruments){
        .detector =
            {
                .context = recording,
                .geometry = recording->geometry,
                .start_exposure = start_exposure,
                .finish_exposure = finish_exposure,
                .read = read_window,
            },
        .clock =
            {
                .context = recording,
                .local_time = local_time,
                .terrestrial_time = terrestrial_time,
            },
        .rate_sensor =
            {
                .context = recording,
                .angular_rate = angular_rate,
            },
        .magnetometer =
            {
                .context = recording,
                .magnetic_field = magnetic_field,
            },
    };
}
