/* The clock of CFE_TIME as an instrument. SPDX-License-Identifier: MIT OR Apache-2.0 */
#include "sextant_mission.h"

/* Seconds of CFE_TIME are 32 bits and wrap. */
static const int64_t RANGE_US = ((int64_t)1 << 32) * 1000000;

/* To the nearest microsecond; a subsecond is 2^-32 s. */
static int64_t microseconds(CFE_TIME_SysTime_t time) {
    return (int64_t)time.Seconds * 1000000 +
           (int64_t)(((uint64_t)time.Subseconds * 1000000 + ((uint64_t)1 << 31)) >> 32);
}

static uint32_t local_time(void *context, int64_t *local_us) {
    (void)context;
    *local_us = microseconds(CFE_TIME_GetMET());
    return SEXTANT_REPLY_OK;
}

static uint32_t terrestrial_time(void *context, int64_t local_us, int64_t *terrestrial_us) {
    (void)context;
    if (CFE_TIME_GetClockState() != CFE_TIME_ClockState_VALID) {
        return SEXTANT_REPLY_NOT_SYNCHRONISED;
    }
    *terrestrial_us = (local_us + microseconds(CFE_TIME_GetSTCF())) % RANGE_US + SEXTANT_APP_EPOCH_US;
    return SEXTANT_REPLY_OK;
}

struct sextant_clock sextant_app_clock(void) {
    return (struct sextant_clock){.local_time = local_time, .terrestrial_time = terrestrial_time};
}
