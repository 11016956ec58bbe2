/*
 * A detector, a clock, a rate sensor and a magnetometer that play frames recorded in a file (`cargo sil record`), as
 * instruments of the library.
 *
 * The file is that of tests/obc-image/src/recorded.rs, version 5, little-endian: magic "SXTF", version,
 * width and height (u16 each), bits (u8), zero (u8), number of frames (u32); then frame by frame local time
 * and Terrestrial Time of the middle of the exposure (i64 each, microseconds; the least i64: not known),
 * local time of the gyro's reading (i64; the least: none) and its rates (f32, rad/s), the same of the
 * magnetometer (uT), and the pixels row by row (u16). A frame is that of the second the recording was turned to; exposure times
 * are not looked at.
 */
#ifndef RECORDED_H
#define RECORDED_H

#include "platform.h"
#include "sextant.h"

/* A recording that is being played. */
struct recording {
    struct file file;
    struct sextant_geometry geometry;
    uint32_t frames;
    /* The second that is played, and both times of its frame. */
    uint32_t second;
    int64_t local_us;
    int64_t terrestrial_us;
    /* What the gyro read; the least local time where there is none. */
    struct sextant_angular_rate rate;
    /* What the magnetometer read, in the same way. */
    struct sextant_magnetic_field_reading field;
    /* Whether an image was begun. */
    bool exposed;
};

/* Opens a recording; null, or why it was refused. */
const char *recording_open(struct recording *recording, const char *name);

/* Turns to a second. A file that breaks off gives an instant before all others, which the sensor reports. */
void recording_turn_to(struct recording *recording, uint32_t second);

/* Its detector, clock, rate sensor and magnetometer. Nothing is measured. */
struct sextant_instruments recording_instruments(struct recording *recording);

#endif
