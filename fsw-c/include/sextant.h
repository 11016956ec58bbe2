/*
 * Sextant: attitude, position and orbit from one camera, a second a call.
 *
 * The program owns all memory. It calls sextant_init once and sextant_cycle once a second; within a cycle the
 * library calls the callbacks of the instruments and nothing else. No heap, no threads, no global state: two
 * sensors in two memories are independent of each other.
 *
 * Reentrancy: calls on one sensor must not overlap. A call on a sensor that is in a cycle, from a callback, an
 * interrupt or another task, is refused with SEXTANT_STATUS_BUSY. All other functions are pure.
 *
 * Errors: a call that could not be done returns why; sextant_status_text says it in words. Null, misaligned,
 * short and overlapping memory is refused as far as a callee can see it; that a pointer points to an object of
 * its type and length is the caller's promise. A second in which an instrument fails is no error of the call:
 * its result and telemetry say so.
 *
 * Frames: pixels count x right and y down. Star path and Earth path: x along +x px, y along +y px, z out along
 * the line of sight. ICRS: inertial; positions are geocentric. Units are in the names: _px, _rad, _rad_s, _km,
 * _km_s, _us (microseconds), _s.
 */

#ifndef SEXTANT_H
#define SEXTANT_H

/* Made of fsw-c/src by cbindgen. To make it anew: SEXTANT_BLESS=1 cargo test -p fsw-c --test header */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * The detector did not serve, or not whole: what is told beside it is of the windows that it delivered.
 */
#define SEXTANT_FAULT_DETECTOR 1

/**
 * The image was not used for its instant, or is one of the last ones again.
 */
#define SEXTANT_FAULT_IMAGE 2

/**
 * The clock did not serve.
 */
#define SEXTANT_FAULT_CLOCK 4

/**
 * The rate sensor gave no reading that can be used.
 */
#define SEXTANT_FAULT_RATE_SENSOR 8

/**
 * The Earth's centre was no position for the orbit filter.
 */
#define SEXTANT_FAULT_FIX 16

/**
 * The shutters did not move: where they stand is not known.
 */
#define SEXTANT_FAULT_SHUTTER 32

/**
 * The magnetometer gave no reading that can be used.
 */
#define SEXTANT_FAULT_MAGNETOMETER 64

/**
 * Bytes of memory that hold a sensor, on any machine of 32 or 64 bits; `sextant_sensor_bytes` says how
 * many are used on this one.
 */
#define SEXTANT_SENSOR_BYTES 46464

/**
 * Alignment of that memory, bytes.
 */
#define SEXTANT_SENSOR_ALIGNMENT 8

/**
 * Bytes that hold any telemetry frame with its length.
 */
#define SEXTANT_TELEMETRY_BYTES 2560

/**
 * Bytes that hold any parameter table.
 */
#define SEXTANT_PARAMETERS_BYTES 512

/**
 * Version of the telemetry frames' layout; their first byte after the length.
 */
#define SEXTANT_TELEMETRY_VERSION 17

/**
 * Version of the parameter table that is read; its first byte.
 */
#define SEXTANT_PARAMETERS_VERSION 27

/**
 * Bytes of memory that hold a link, on any machine of 32 or 64 bits; aligned as a sensor's.
 */
#define SEXTANT_LINK_BYTES 1536

/**
 * Bytes that hold any report.
 */
#define SEXTANT_REPORT_BYTES 226

/**
 * Longest telecommand, bytes.
 */
#define SEXTANT_TELECOMMAND_BYTES 256

/**
 * Version of the list of commands that is obeyed; the first byte after the headers.
 */
#define SEXTANT_TELECOMMANDS_VERSION 2

/**
 * What a call came to. Every call that is not `OK` has changed nothing, except that a cycle refused with
 * `TELEMETRY` has been flown.
 */
enum sextant_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done.
     */
    SEXTANT_STATUS_OK = 0,
    /**
     * A pointer that is needed is null.
     */
    SEXTANT_STATUS_NULL = 1,
    /**
     * A buffer is shorter than needed, or longer than any object can be.
     */
    SEXTANT_STATUS_SIZE = 2,
    /**
     * A pointer is not aligned for what it points to.
     */
    SEXTANT_STATUS_ALIGNMENT = 3,
    /**
     * An output, or a table that is to last, lies in the sensor's memory.
     */
    SEXTANT_STATUS_OVERLAP = 4,
    /**
     * No sensor was initialised at this address, or it was copied or moved since.
     */
    SEXTANT_STATUS_NOT_A_SENSOR = 5,
    /**
     * The sensor is in a cycle: a call from one of its own callbacks, or from another task.
     */
    SEXTANT_STATUS_BUSY = 6,
    /**
     * The command is none of `sextant_command`.
     */
    SEXTANT_STATUS_COMMAND = 7,
    /**
     * A callback that is needed is null, or the detector's geometry is impossible or not that of its bad
     * pixels.
     */
    SEXTANT_STATUS_INSTRUMENTS = 8,
    /**
     * The parameter table was cut or damaged, or is none.
     */
    SEXTANT_STATUS_PARAMETERS_DAMAGED = 9,
    /**
     * The parameter table is of another version than `SEXTANT_PARAMETERS_VERSION`.
     */
    SEXTANT_STATUS_PARAMETERS_VERSION = 10,
    /**
     * A value of the parameter table is outside its range, or values contradict each other.
     */
    SEXTANT_STATUS_PARAMETERS_RANGE = 11,
    /**
     * The catalogue was cut or damaged, or is none.
     */
    SEXTANT_STATUS_CATALOGUE_DAMAGED = 12,
    /**
     * The catalogue has a layout that this library does not read.
     */
    SEXTANT_STATUS_CATALOGUE_VERSION = 13,
    /**
     * The calibration was cut or damaged, or is none.
     */
    SEXTANT_STATUS_CALIBRATION_DAMAGED = 14,
    /**
     * The calibration has a layout that this library does not read.
     */
    SEXTANT_STATUS_CALIBRATION_VERSION = 15,
    /**
     * The parameter table names a calibration, and the one given is another, of another lens, or missing.
     */
    SEXTANT_STATUS_CALIBRATION_MISMATCH = 16,
    /**
     * The telemetry frame could not be written.
     */
    SEXTANT_STATUS_TELEMETRY = 17,
    /**
     * What was kept of before a restart is no whole telemetry frame of this version with an orbit or a
     * commanded safe, or comes after the first second.
     */
    SEXTANT_STATUS_KEPT = 18,
    /**
     * The bad pixels' file was cut or damaged, or is none.
     */
    SEXTANT_STATUS_BAD_PIXELS_DAMAGED = 19,
    /**
     * The bad pixels' file has a layout that this library does not read.
     */
    SEXTANT_STATUS_BAD_PIXELS_VERSION = 20,
    /**
     * The bad pixels are those of a detector of another size than the parameter table's.
     */
    SEXTANT_STATUS_BAD_PIXELS_MISMATCH = 21,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_status sextant_status;
#else
typedef uint32_t sextant_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Mode in which a second was spent.
 */
enum sextant_mode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Detector and clock are tested before their data are used.
     */
    SEXTANT_MODE_SELF_TEST = 0,
    /**
     * Stars are identified: in windows where a filter still predicts them, else in the whole image.
     */
    SEXTANT_MODE_ACQUISITION = 1,
    /**
     * Windows about predicted stars and about the Earth's limb are read.
     */
    SEXTANT_MODE_TRACKING = 2,
    /**
     * As tracking, but no limb in the field is lit: stars alone, the orbit is propagated.
     */
    SEXTANT_MODE_ECLIPSE = 3,
    /**
     * The Sun blinds the detector: attitude by the last rate, orbit propagated.
     */
    SEXTANT_MODE_SUN_OUTAGE = 4,
    /**
     * After persistent faults or a time-out: the orbit is propagated, the self-test repeated in every
     * second.
     */
    SEXTANT_MODE_SAFE = 5,
    /**
     * By command, or without a parameter table that can be used: the orbit is propagated, no image is taken
     * until a command ends it.
     */
    SEXTANT_MODE_COMMANDED_SAFE = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_mode sextant_mode;
#else
typedef uint32_t sextant_mode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What came of the stars of a second.
 */
enum sextant_outcome
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * None were looked for, or a fault came first.
     */
    SEXTANT_OUTCOME_NONE = 0,
    /**
     * The self-test passed.
     */
    SEXTANT_OUTCOME_SELF_TEST_PASSED = 1,
    /**
     * Stars were identified, without prior knowledge or near to an attitude known before: hardly by chance.
     */
    SEXTANT_OUTCOME_IDENTIFIED = 2,
    /**
     * The search goes on in the next second with the same image.
     */
    SEXTANT_OUTCOME_SEARCHING = 3,
    /**
     * The image was not identified.
     */
    SEXTANT_OUTCOME_NOT_IDENTIFIED = 4,
    /**
     * The sensor turned too fast: its stars are streaks, and no attitude is claimed.
     */
    SEXTANT_OUTCOME_TOO_FAST = 5,
    /**
     * Predicted stars were found again.
     */
    SEXTANT_OUTCOME_TRACKED = 6,
    /**
     * Too few predicted stars were found.
     */
    SEXTANT_OUTCOME_LOST = 7,
    /**
     * The detector is blinded.
     */
    SEXTANT_OUTCOME_BLINDED = 8,
    /**
     * The star path is shut: an attitude is carried on, or where its age is 0 it is by Earth and terminator.
     */
    SEXTANT_OUTCOME_STAR_PATH_SHUT = 9,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_outcome sextant_outcome;
#else
typedef uint32_t sextant_outcome;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What came of looking for the Earth in a second.
 */
enum sextant_earth_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * It was not looked for: no attitude, stars that are lines, a blinded detector, or a shut Earth path.
     */
    SEXTANT_EARTH_STATUS_NOT_LOOKED = 0,
    /**
     * No limb that the Sun lights is in the field.
     */
    SEXTANT_EARTH_STATUS_DARK = 1,
    /**
     * The Sun lights a limb in the field, but not enough of it high enough to be measured.
     */
    SEXTANT_EARTH_STATUS_FAINT = 2,
    /**
     * The centre was found.
     */
    SEXTANT_EARTH_STATUS_FOUND = 3,
    /**
     * It was looked for and no centre came of it.
     */
    SEXTANT_EARTH_STATUS_REFUSED = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_earth_status sextant_earth_status;
#else
typedef uint32_t sextant_earth_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What Terrestrial Time of a second rests on.
 */
enum sextant_clock_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * No time: no Sun, no aberration, no Earth.
     */
    SEXTANT_CLOCK_STATE_UNKNOWN = 0,
    /**
     * The clock gave it in this second.
     */
    SEXTANT_CLOCK_STATE_SYNCHRONISED = 1,
    /**
     * The clock gave it before, at most a day ago, and local time has gone on since.
     */
    SEXTANT_CLOCK_STATE_HOLDOVER = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_clock_state sextant_clock_state;
#else
typedef uint32_t sextant_clock_state;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What the sensor can do.
 */
enum sextant_sensor_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Earth and stars are seen.
     */
    SEXTANT_SENSOR_STATE_FULL = 0,
    /**
     * The Sun is in the Earth path and blinds the detector.
     */
    SEXTANT_SENSOR_STATE_SUN_IN_EARTH_PATH = 1,
    /**
     * No lit limb is on the detector; stars are seen.
     */
    SEXTANT_SENSOR_STATE_ECLIPSE = 2,
    /**
     * The Sun is in the star path and blinds the detector.
     */
    SEXTANT_SENSOR_STATE_SUN_IN_STAR_PATH = 3,
    /**
     * The same, and its image lies on that of the Earth.
     */
    SEXTANT_SENSOR_STATE_SUN_IN_STAR_PATH_OVER_EARTH = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_sensor_state sextant_sensor_state;
#else
typedef uint32_t sextant_sensor_state;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What came of the command of a second.
 */
enum sextant_command_result
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * There was none.
     */
    SEXTANT_COMMAND_RESULT_NONE = 0,
    /**
     * It was done.
     */
    SEXTANT_COMMAND_RESULT_DONE = 1,
    /**
     * It was refused and changed nothing.
     */
    SEXTANT_COMMAND_RESULT_REFUSED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_command_result sextant_command_result;
#else
typedef uint32_t sextant_command_result;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What an area holds.
 */
enum sextant_area
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The star catalogue.
     */
    SEXTANT_AREA_CATALOGUE = 0,
    /**
     * The lens calibration.
     */
    SEXTANT_AREA_CALIBRATION = 1,
    /**
     * The detector's bad pixels and offsets of columns.
     */
    SEXTANT_AREA_BAD_PIXELS = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_area sextant_area;
#else
typedef uint32_t sextant_area;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What the spacecraft wants of a second. More can be commanded through the link.
 */
enum sextant_command
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Go on.
     */
    SEXTANT_COMMAND_CONTINUE = 0,
    /**
     * Forget the attitude and acquire anew.
     */
    SEXTANT_COMMAND_REACQUIRE = 1,
    /**
     * Forget attitude, orbit and what was learned of lens and rate sensor and begin with the self-test.
     */
    SEXTANT_COMMAND_RESTART = 2,
    /**
     * Go to safe mode, until `REACQUIRE` or `RESTART`.
     */
    SEXTANT_COMMAND_SAFE = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_command sextant_command;
#else
typedef uint32_t sextant_command;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a callback answers. Any other number counts as `BUS`.
 */
enum sextant_reply
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done.
     */
    SEXTANT_REPLY_OK = 0,
    /**
     * Any instrument: it did not answer in time.
     */
    SEXTANT_REPLY_TIMEOUT = 1,
    /**
     * Any instrument: the link to it reported an error.
     */
    SEXTANT_REPLY_BUS = 2,
    /**
     * Detector: nothing has been exposed since power-on.
     */
    SEXTANT_REPLY_NOT_EXPOSED = 3,
    /**
     * Detector: it cannot do this exposure time.
     */
    SEXTANT_REPLY_EXPOSURE = 4,
    /**
     * Clock: its correlation with Terrestrial Time is not known.
     */
    SEXTANT_REPLY_NOT_SYNCHRONISED = 5,
    /**
     * Rate sensor: there is no reading since the last one was taken.
     */
    SEXTANT_REPLY_NO_READING = 6,
    /**
     * Rate sensor: the rate is beyond its range.
     */
    SEXTANT_REPLY_SATURATED = 7,
    /**
     * Shutters: one did not arrive where it was sent.
     */
    SEXTANT_REPLY_STUCK = 8,
    /**
     * Memory of an area: no word of it begins where the part does.
     */
    SEXTANT_REPLY_ALIGNMENT = 9,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum sextant_reply sextant_reply;
#else
typedef uint32_t sextant_reply;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The command link, opaque. It lies in the memory that was given to `sextant_link_init`, at its beginning;
 * it must not be copied or moved.
 */
typedef struct sextant_link sextant_link;

/**
 * The sensor, opaque. It lies in the memory that was given to `sextant_init`, at its beginning; it must
 * not be copied or moved.
 */
typedef struct sextant_sensor sextant_sensor;

/**
 * Bytes that the caller keeps where they are.
 */
typedef struct sextant_bytes {
    /**
     * First byte; may be null where `length` is 0.
     */
    const uint8_t *data;
    /**
     * Number of bytes.
     */
    size_t length;
} sextant_bytes;

/**
 * The tables that a sensor is made of.
 */
typedef struct sextant_tables {
    /**
     * Parameter table: version, postcard body, CRC-32. Copied; it need not last.
     */
    struct sextant_bytes parameters;
    /**
     * Star catalogue of `catalog-gen`, or `sextant_reference_catalogue()`. Not copied: it must last,
     * unchanged, as long as the sensor.
     */
    struct sextant_bytes catalogue;
    /**
     * Calibration of lens and pixels, as `sil-host calibrate` writes it; empty where there is none. Used
     * where the parameter table names it, and must last then, unchanged, as long as the sensor.
     */
    struct sextant_bytes calibration;
    /**
     * Bad pixels and offsets of columns of the detector, as `sil-host defects` writes them; empty where
     * there are none. What the detector's callback reads is corrected by them. Not copied: they must last,
     * unchanged, as long as the sensor.
     */
    struct sextant_bytes bad_pixels;
} sextant_tables;

/**
 * Fixed properties of a detector.
 */
typedef struct sextant_geometry {
    /**
     * Number of columns, px, at least 1; that of the parameter table.
     */
    uint16_t width_px;
    /**
     * Number of rows, px, at least 1; that of the parameter table.
     */
    uint16_t height_px;
    /**
     * Resolution of the converter, 1 to 16: full scale is 2^bits - 1.
     */
    uint8_t bits;
} sextant_geometry;

/**
 * A rectangle of pixels. Pixels count x right and y down; the centre of the first pixel read is (0, 0).
 */
typedef struct sextant_window {
    /**
     * Column of the first pixel, px.
     */
    uint16_t x;
    /**
     * Row of the first pixel, px.
     */
    uint16_t y;
    /**
     * Number of columns, px.
     */
    uint16_t width;
    /**
     * Number of rows, px.
     */
    uint16_t height;
} sextant_window;

/**
 * The active-pixel detector. At most one exposure a cycle, then any number of windows of that image; a
 * window read twice gives the same values. All callbacks are needed.
 */
typedef struct sextant_detector {
    /**
     * Handed to every callback of the detector; may be null.
     */
    void *context;
    /**
     * Size and resolution; the same in every cycle.
     */
    struct sextant_geometry geometry;
    /**
     * Begins a new image, integrating for `exposure_us` microseconds, and returns without waiting for it.
     * Answers `OK`, `EXPOSURE`, `TIMEOUT` or `BUS`.
     */
    uint32_t (*start_exposure)(void *context,
                               uint32_t exposure_us);
    /**
     * Waits until the image that was begun can be read and writes the local time of the middle of its
     * exposure to `local_us`, microseconds since power-on (of a rolling shutter: the middle row's).
     * Answers `OK`, `NOT_EXPOSED`, `TIMEOUT` or `BUS`.
     */
    uint32_t (*finish_exposure)(void *context,
                                int64_t *local_us);
    /**
     * Reads `window` of the last image into `pixels`, row by row, raw digital numbers, right-aligned.
     * `pixels` has room for `count` = width x height values; the window lies on the detector whole.
     * Answers `OK`, `NOT_EXPOSED`, `TIMEOUT` or `BUS`; unless `OK`, the pixels are not used.
     */
    uint32_t (*read)(void *context,
                     struct sextant_window window,
                     uint16_t *pixels,
                     size_t count);
} sextant_detector;

/**
 * The on-board counter and its correlation with Terrestrial Time. Both callbacks are needed.
 */
typedef struct sextant_clock {
    /**
     * Handed to every callback of the clock; may be null.
     */
    void *context;
    /**
     * Writes the counter now to `local_us`, microseconds since power-on; never less than at the call
     * before. Answers `OK`, `TIMEOUT` or `BUS`.
     */
    uint32_t (*local_time)(void *context,
                           int64_t *local_us);
    /**
     * Writes Terrestrial Time at the local instant `local_us` of the last seconds to `terrestrial_us`,
     * microseconds since J2000.0 (2000-01-01T12:00:00 TT). An error of a millisecond displaces a low
     * satellite by 8 m. Answers `OK`, `NOT_SYNCHRONISED`, `TIMEOUT` or `BUS`.
     */
    uint32_t (*terrestrial_time)(void *context,
                                 int64_t local_us,
                                 int64_t *terrestrial_us);
} sextant_clock;

/**
 * A reading of the body's rate.
 */
typedef struct sextant_angular_rate {
    /**
     * Middle of the time it was taken over, local time, microseconds since power-on.
     */
    int64_t local_us;
    /**
     * Rate of the body against inertial space about the x, y, z axes of the Earth path, rad/s, as the
     * sensor has it: bias, scale and alignment are not corrected.
     */
    float rad_s[3];
} sextant_angular_rate;

/**
 * The rate sensor (gyro). Asked only where the parameter table says how good it is.
 */
typedef struct sextant_rate_sensor {
    /**
     * Handed to the callback; may be null.
     */
    void *context;
    /**
     * Writes the newest reading. Answers `OK`, `NO_READING`, `SATURATED`, `TIMEOUT` or `BUS`. Null: none
     * on board.
     */
    uint32_t (*angular_rate)(void *context,
                             struct sextant_angular_rate *reading);
} sextant_rate_sensor;

/**
 * Receives the marks between which the stages of a cycle are measured; stage 0 scan, 1 identify, 2
 * predict, 3 windows, 4 confirm, 5 limb, 6 centre, 7 orbit, 8 search, 9 streaks, 10
 * image.
 */
typedef struct sextant_meter {
    /**
     * Handed to the callbacks; may be null.
     */
    void *context;
    /**
     * A stage begins; null where nothing is measured.
     */
    void (*begin)(void *context,
                  uint32_t stage);
    /**
     * A stage ends; null where nothing is measured.
     */
    void (*end)(void *context,
                uint32_t stage);
    /**
     * Whether the last cycle took longer than it may, by a timer of your own: asked once as a cycle begins,
     * which tells it as an event. Null: it did not.
     */
    bool (*overran)(void *context);
} sextant_meter;

/**
 * The shutters of the two paths and the filter of the Earth path. Moved only where the parameter table says
 * which there are.
 */
typedef struct sextant_shutter {
    /**
     * Handed to the callback; may be null.
     */
    void *context;
    /**
     * Opens the star path, the Earth path or both and shuts the other; `clear`: the Earth path's filter is
     * to be out of the way, else in it. Returns when they stand so. Called in every cycle before the
     * exposure. Answers `OK`, `STUCK`, `TIMEOUT` or `BUS`. Null: none on board.
     */
    uint32_t (*open)(void *context,
                     bool star_path,
                     bool earth_path,
                     bool clear);
} sextant_shutter;

/**
 * A reading of the magnetic flux density.
 */
typedef struct sextant_magnetic_field_reading {
    /**
     * Middle of the time it was taken over, local time, microseconds since power-on.
     */
    int64_t local_us;
    /**
     * Flux density along the x, y, z axes of the Earth path, microtesla, as the sensor has it: the
     * spacecraft's own field is in it.
     */
    float ut[3];
} sextant_magnetic_field_reading;

/**
 * The magnetometer. Asked only where the parameter table says how good it is.
 */
typedef struct sextant_magnetometer {
    /**
     * Handed to the callback; may be null.
     */
    void *context;
    /**
     * Writes the newest reading. Answers `OK`, `NO_READING`, `SATURATED`, `TIMEOUT` or `BUS`. Null: none
     * on board.
     */
    uint32_t (*magnetic_field)(void *context,
                               struct sextant_magnetic_field_reading *reading);
} sextant_magnetometer;

/**
 * The instruments, lent for one cycle. The callbacks run on the caller's stack, within `sextant_cycle`.
 */
typedef struct sextant_instruments {
    /**
     * The detector behind both paths.
     */
    struct sextant_detector detector;
    /**
     * Local time and Terrestrial Time.
     */
    struct sextant_clock clock;
    /**
     * The body's rate; all zero where there is none.
     */
    struct sextant_rate_sensor rate_sensor;
    /**
     * The stages' marks; all zero where nothing is measured.
     */
    struct sextant_meter meter;
    /**
     * The shutters of the paths; all zero where there are none.
     */
    struct sextant_shutter shutter;
    /**
     * The magnetic field; all zero where there is no magnetometer.
     */
    struct sextant_magnetometer magnetometer;
} sextant_instruments;

/**
 * An attitude and how far to trust it. All zero where it is not known.
 */
typedef struct sextant_attitude {
    /**
     * Whether there is one.
     */
    bool known;
    /**
     * ICRS to star path, x, y, z, w (scalar last): b = A(q) r turns a direction r of the ICRS into the
     * sensor's frame, x along +x px, y along +y px, z out along the line of sight.
     */
    float quaternion[4];
    /**
     * Standard deviations about x, y, z of the star path, rad.
     */
    float sigma_rad[3];
    /**
     * Whole seconds since the image from which it was found was taken; 0: that of this second.
     */
    uint32_t age_s;
} sextant_attitude;

/**
 * How the sensor turns. All zero where it is not known.
 */
typedef struct sextant_rate {
    /**
     * Whether it is known.
     */
    bool known;
    /**
     * It may as well be the opposite one: it rests on the streaks of a single image.
     */
    bool either_sense;
    /**
     * Rate of the star path against the stars, in its own frame, rad/s.
     */
    float rad_s[3];
    /**
     * Standard deviations about x, y, z, rad/s; zero where the rate comes of the attitude's filter.
     */
    float sigma_rad_s[3];
} sextant_rate;

/**
 * The Earth as seen in this second. All zero where it was not found.
 */
typedef struct sextant_earth {
    /**
     * Unit vector to the Earth's centre, Earth path.
     */
    float direction[3];
    /**
     * Standard deviation of the direction, the greater of the two across it, rad.
     */
    float sigma_rad;
    /**
     * Distance of the Earth's centre, km.
     */
    float distance_km;
    /**
     * Standard deviation of the distance, km.
     */
    float sigma_km;
    /**
     * Covariance of the centre, direction times distance, Earth path, km²: the lower left half of the matrix
     * with its diagonal, row by row.
     */
    float covariance_km2[6];
} sextant_earth;

/**
 * Kepler's elements of an orbit, osculating, ICRS axes. All zero where they are not known.
 */
typedef struct Elements {
    /**
     * Whether there are any: not those of an open orbit or of an eccentricity above 0.97.
     */
    bool known;
    /**
     * Semi-major axis, km.
     */
    double semi_major_axis_km;
    /**
     * Eccentricity.
     */
    float eccentricity;
    /**
     * Inclination to the ICRS equator, rad, 0 to pi.
     */
    float inclination_rad;
    /**
     * Right ascension of the ascending node, rad, 0 to 2 pi; 0 in the equator's plane.
     */
    float node_rad;
    /**
     * Argument of perigee, rad, 0 to 2 pi; 0 on a circle.
     */
    float perigee_rad;
    /**
     * True anomaly, rad, 0 to 2 pi; on a circle it counts from the node.
     */
    float anomaly_rad;
} Elements;

/**
 * Position and velocity at the instant of the second. All zero where they are not known.
 */
typedef struct sextant_orbit {
    /**
     * Whether they are known.
     */
    bool known;
    /**
     * Whether the filter has converged.
     */
    bool settled;
    /**
     * Seconds since the last observation of the Earth that was accepted.
     */
    uint32_t since_fix_s;
    /**
     * Position, ICRS axes, geocentric, km.
     */
    double position_km[3];
    /**
     * Velocity, ICRS axes, km/s.
     */
    double velocity_km_s[3];
    /**
     * Standard deviations of the position along the ICRS axes, km.
     */
    float sigma_position_km[3];
    /**
     * Standard deviations of the velocity along the ICRS axes, km/s.
     */
    float sigma_velocity_km_s[3];
    /**
     * Standard deviations of the position: radial, along, cross, km.
     */
    float sigma_hill_km[3];
    /**
     * By what the Earth path is turned against the mounting of the parameters, rad: a rotation vector in the
     * Earth path; 0 where it is not estimated.
     */
    float misalignment_rad[3];
    /**
     * Its standard deviations, rad.
     */
    float misalignment_sigma_rad[3];
    /**
     * The same orbit in Kepler's elements.
     */
    struct Elements elements;
} sextant_orbit;

/**
 * The attitude against local vertical and local horizontal (z down to the Earth's centre, y against the
 * orbit's normal, x along the flight). All zero where attitude or orbit are not known.
 */
typedef struct Local {
    /**
     * Whether it is known.
     */
    bool known;
    /**
     * LVLH to star path, x, y, z, w.
     */
    float quaternion[4];
    /**
     * Angle between the Earth path's line of sight and the Earth's centre, rad, 0 to pi.
     */
    float nadir_rad;
    /**
     * Angle about the vertical, from the flight's direction towards LVLH y, to the Earth path's x axis, rad.
     */
    float yaw_rad;
} Local;

/**
 * The sensor's next change of state: an outage that begins or ends. All zero where none is foreseen within a
 * revolution.
 */
typedef struct sextant_next_state {
    /**
     * Whether one is foreseen.
     */
    bool known;
    /**
     * What the sensor can do then.
     */
    sextant_sensor_state state;
    /**
     * Seconds until then.
     */
    uint32_t in_s;
    /**
     * Standard deviation of these, s.
     */
    float sigma_s;
    /**
     * Seconds that it lasts; 0 where its end is not foreseen.
     */
    uint32_t lasts_s;
} sextant_next_state;

/**
 * What the magnetometer reads, and how far it is to be believed; along the axes of the Earth path. All zero
 * without one, without a reading and where the orbit is not known.
 */
typedef struct sextant_magnetic_field {
    /**
     * Whether there is a reading.
     */
    bool known;
    /**
     * Whether the attitude of this second rests on it.
     */
    bool used;
    /**
     * The reading less the zero, microtesla: the Earth's field.
     */
    float field_ut[3];
    /**
     * The zero as stars and orbit have shown it, microtesla: the spacecraft's own field.
     */
    float zero_ut[3];
    /**
     * Standard deviation of the zero, an axis, microtesla.
     */
    float zero_sigma_ut;
} sextant_magnetic_field;

/**
 * The main results of a second.
 */
typedef struct sextant_result {
    /**
     * Cycles since start, from 0.
     */
    uint32_t cycle;
    /**
     * Mode in which the second was spent.
     */
    sextant_mode mode;
    /**
     * What came of the stars.
     */
    sextant_outcome outcome;
    /**
     * What came of looking for the Earth.
     */
    sextant_earth_status earth_status;
    /**
     * What Terrestrial Time rests on.
     */
    sextant_clock_state clock;
    /**
     * What did not serve: a sum of `SEXTANT_FAULT_...`, 0 where all did.
     */
    uint32_t faults;
    /**
     * Instant of the image, or of the second where none was used: local time, microseconds since power-on.
     */
    int64_t local_us;
    /**
     * The same in Terrestrial Time, microseconds since J2000.0; 0 where the clock has never given it
     * (`clock` then is `UNKNOWN`).
     */
    int64_t terrestrial_us;
    /**
     * Star-like spots in the image or its windows.
     */
    uint32_t detections;
    /**
     * Stars that were recognised.
     */
    uint32_t stars;
    /**
     * The attitude by this second's image alone, or predicted where that gave none.
     */
    struct sextant_attitude attitude;
    /**
     * The attitude that the filter makes of all images so far, at the same instant.
     */
    struct sextant_attitude filtered;
    /**
     * The rate.
     */
    struct sextant_rate rate;
    /**
     * The Earth, where `earth_status` is `FOUND`.
     */
    struct sextant_earth earth;
    /**
     * The orbit.
     */
    struct sextant_orbit orbit;
    /**
     * The attitude against the local vertical.
     */
    struct Local local;
    /**
     * The sensor's next change of state.
     */
    struct sextant_next_state next_state;
    /**
     * What the magnetometer reads.
     */
    struct sextant_magnetic_field magnetic_field;
    /**
     * What came of the command.
     */
    sextant_command_result command;
    /**
     * Reason code of a command that was refused, as reports tell it; else 0.
     */
    uint32_t refusal;
    /**
     * Exposure that the image was asked for with, us; 0 where the second needed no image.
     */
    uint32_t exposure_us;
    /**
     * Whether the star path was to be shut.
     */
    bool star_path_shut;
    /**
     * Whether the Earth path was to be shut.
     */
    bool earth_path_shut;
    /**
     * Whether the Earth path's filter was to be out of the way.
     */
    bool earth_path_clear;
    /**
     * How many stars were seen through the Earth path that do not contradict each other; 0: none, or none
     * were looked for.
     */
    uint8_t earth_path_stars;
    /**
     * Whether `sensor_state` is known: the Sun by attitude and time, the limb by what is seen of it or by
     * the orbit.
     */
    bool sensor_state_known;
    /**
     * What the sensor can do in this second; `FULL` where it is not known.
     */
    sextant_sensor_state sensor_state;
} sextant_result;

/**
 * Non-volatile memory of catalogue, calibration and bad pixels that are sent up by telecommand. Of each
 * there are two copies: the one that serves, which nothing writes, and a spare one, which serves from the
 * next start on once it was marked as whole. Those that serve are given to `sextant_init`. All zero where
 * there is none.
 */
typedef struct sextant_areas {
    /**
     * Handed to both callbacks; may be null.
     */
    void *context;
    /**
     * The spare copy of the catalogue, mapped into the address space; its length is the longest file.
     * Length 0: no catalogue is taken.
     */
    struct sextant_bytes catalogue;
    /**
     * The same of the calibration.
     */
    struct sextant_bytes calibration;
    /**
     * The same of the bad pixels.
     */
    struct sextant_bytes bad_pixels;
    /**
     * Writes `length` bytes of a file to the spare copy of `area` (a `sextant_area`), `offset` bytes from
     * its beginning. Parts come one behind the other; with that at 0 a new file begins and the mark of the
     * one before is gone. Answers `OK`, `ALIGNMENT` where a part cannot begin there, `TIMEOUT` or `BUS`.
     */
    uint32_t (*write)(void *context,
                      uint32_t area,
                      size_t offset,
                      const uint8_t *part,
                      size_t length);
    /**
     * Marks the spare copy of `area`, whose first `length` bytes have the CRC-32 (ISO-HDLC) `crc`, as whole.
     * Answers `OK`, `TIMEOUT` or `BUS`.
     */
    uint32_t (*mark_whole)(void *context,
                           uint32_t area,
                           size_t length,
                           uint32_t crc);
} sextant_areas;

/**
 * What a link is made of.
 */
typedef struct sextant_link_configuration {
    /**
     * APID of the packets, both ways: 11 bits.
     */
    uint16_t apid;
    /**
     * Whether every packet must carry a tag by `key`.
     */
    bool keyed;
    /**
     * The key: AES-128 of the CMAC. Copied.
     */
    uint8_t key[16];
    /**
     * Counter of the last packet, as `sextant_link_counter` gave it before power was lost; else 0.
     */
    uint32_t counter;
    /**
     * Memory of the files that are sent up; all zero where there is none.
     */
    struct sextant_areas areas;
} sextant_link_configuration;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Says a status in words: a static string in English, one line without its end. Never null; for a number
 * that is no status it says so.
 */
const char *sextant_status_text(uint32_t status);

/**
 * The library's version, "major.minor.patch": a static string.
 */
const char *sextant_version(void);

/**
 * Bytes of memory that a sensor uses on this machine; at most `SEXTANT_SENSOR_BYTES`.
 */
size_t sextant_sensor_bytes(void);

/**
 * Alignment of that memory, bytes; equal to `SEXTANT_SENSOR_ALIGNMENT`.
 */
size_t sextant_sensor_alignment(void);

/**
 * The catalogue of the reference field, 24 x 19 deg. A program that does not call this does not link it.
 */
struct sextant_bytes sextant_reference_catalogue(void);

/**
 * The calibration of the reference camera. A program that does not call this does not link it.
 */
struct sextant_bytes sextant_reference_calibration(void);

/**
 * Makes a sensor that knows nothing yet in memory of the caller; one that was there is forgotten.
 *
 * - `memory`: `memory_bytes` bytes, at least `sextant_sensor_bytes()`, aligned to
 *   `SEXTANT_SENSOR_ALIGNMENT`, in use until the last cycle. It must not be copied or moved. Zero it
 *   before the first call (a static object is): a sensor that was in a cycle when its task was ended
 *   counts as busy until its memory is zeroed.
 * - `tables`: what the sensor is made of.
 * - `sensor`: where the sensor's handle is written.
 *
 * Returns `OK`; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments; `PARAMETERS_...`,
 * `CATALOGUE_...`, `CALIBRATION_...`, `BAD_PIXELS_...` for the tables; `BUSY`. Unless `OK`, memory and
 * handle are as before: a sensor that was there flies on with its old tables.
 */
sextant_status sextant_init(void *memory,
                            size_t memory_bytes,
                            const struct sextant_tables *tables,
                            struct sextant_sensor **sensor);

/**
 * Flies one second: exposes, reads, measures, and reports. To be called once a second.
 *
 * - `sensor`: the handle of `sextant_init`.
 * - `instruments`: lent for this call; its callbacks run within it.
 * - `command`: one of `sextant_command`.
 * - `telemetry`: where the telemetry frame is written, led by its length (two bytes, little-endian), so
 *   that frames one after the other are a stream.
 * - `telemetry_bytes`: its room, at least `SEXTANT_TELEMETRY_BYTES`.
 * - `telemetry_length`: where the number of bytes written is written.
 * - `result`: where the main results are written.
 *
 * Returns `OK`, also for a second in which an instrument failed: `result->faults` says so. `NULL`, `SIZE`,
 * `ALIGNMENT`, `OVERLAP`, `COMMAND`, `INSTRUMENTS` for the arguments; `NOT_A_SENSOR`, `BUSY`. Unless `OK`
 * nothing was flown and nothing written.
 */
sextant_status sextant_cycle(struct sextant_sensor *sensor,
                             const struct sextant_instruments *instruments,
                             uint32_t command,
                             uint8_t *telemetry,
                             size_t telemetry_bytes,
                             size_t *telemetry_length,
                             struct sextant_result *result);

/**
 * Makes a link in memory of the caller; one that was there is forgotten.
 *
 * - `memory`: `memory_bytes` bytes, at least `SEXTANT_LINK_BYTES`, aligned to `SEXTANT_SENSOR_ALIGNMENT`, in
 *   use until the last call. It must not be copied or moved. Zero it before the first call (a static object
 *   is).
 * - `configuration`: APID, key and counter; memory of the areas, which is used until the last call.
 * - `link`: where the link's handle is written.
 *
 * Returns `OK`; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments; `BUSY`. Unless `OK`, memory and
 * handle are as before.
 */
sextant_status sextant_link_init(void *memory,
                                 size_t memory_bytes,
                                 const struct sextant_link_configuration *configuration,
                                 struct sextant_link **link);

/**
 * Takes one telecommand packet. What came of it is reported by `sextant_link_report`.
 *
 * - `link`: the handle of `sextant_link_init`.
 * - `packet`: its bytes, from the first to the last, no more; at most `SEXTANT_TELECOMMAND_BYTES`.
 * - `refusal`: where 0 is written for an accepted packet, else the reason code.
 *
 * Returns `OK`, also for a packet that is refused; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments;
 * `NOT_A_SENSOR`, `BUSY`. Unless `OK` nothing is changed.
 */
sextant_status sextant_link_receive(struct sextant_link *link,
                                    struct sextant_bytes packet,
                                    uint32_t *refusal);

/**
 * Counter of the last packet whose tag was right. A program with a key stores it where it outlasts a loss of
 * power after every packet, before the next cycle.
 *
 * Returns `OK`; `NULL`, `ALIGNMENT`, `OVERLAP` for the arguments; `NOT_A_SENSOR`, `BUSY`.
 */
sextant_status sextant_link_counter(struct sextant_link *link,
                                    uint32_t *counter);

/**
 * Flies one second as `sextant_cycle`, with the command that waits in the link, and goes on with the check
 * of a file that was sent up.
 *
 * Returns what `sextant_cycle` returns. Unless `OK` nothing was flown, and the command waits on.
 */
sextant_status sextant_cycle_commanded(struct sextant_sensor *sensor,
                                       struct sextant_link *link,
                                       const struct sextant_instruments *instruments,
                                       uint8_t *telemetry,
                                       size_t telemetry_bytes,
                                       size_t *telemetry_length,
                                       struct sextant_result *result);

/**
 * Writes the next report packet, to be called until there is none.
 *
 * - `link`: the handle of `sextant_link_init`.
 * - `sensor`: the handle of `sextant_init`: a dump sends its parameter table.
 * - `local_us`: the on-board counter now, microseconds; the time of the packet.
 * - `report`, `report_bytes`: where it is written, at least `SEXTANT_REPORT_BYTES`.
 * - `report_length`: where its length is written; 0 where no report waits.
 *
 * Returns `OK`; `NULL`, `SIZE`, `ALIGNMENT`, `OVERLAP` for the arguments; `NOT_A_SENSOR`, `BUSY`. Unless
 * `OK` nothing is written.
 */
sextant_status sextant_link_report(struct sextant_link *link,
                                   struct sextant_sensor *sensor,
                                   int64_t local_us,
                                   uint8_t *report,
                                   size_t report_bytes,
                                   size_t *report_length);

/**
 * Goes on from before a restart: with the orbit and the mounting of the paths, and in safe where that was
 * commanded. Call it after `sextant_init`, before the first cycle.
 *
 * - `kept`: what a cycle before the restart wrote as telemetry, its length before it. Keep one that has an
 *   orbit every few minutes, and one whenever the mode becomes or was `COMMANDED_SAFE`, in memory that a
 *   restart leaves; frames of another version are refused.
 *
 * The orbit is told once Terrestrial Time is known and the gap is crossed. One that is older than two hours
 * then is forgotten with an event, and begins anew; the mounting stays.
 *
 * Returns `OK`; `KEPT` where `kept` is no whole frame with an orbit or a commanded safe, or a second was
 * flown already; `NULL`, `SIZE`, `ALIGNMENT`, `NOT_A_SENSOR`, `BUSY`. Unless `OK` nothing has changed.
 */
sextant_status sextant_resume(struct sextant_sensor *sensor,
                              struct sextant_bytes kept);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SEXTANT_H */
