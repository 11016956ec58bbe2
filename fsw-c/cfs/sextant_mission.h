/*
 * What the Sextant app asks of the mission: its own functions, which this header declares and the mission
 * writes. SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * All are called by the app's task.
 */
#ifndef SEXTANT_MISSION_H
#define SEXTANT_MISSION_H

#include "cfe.h"
#include "sextant.h"

/*
 * The tables that the sensor is made of: the copies of them that serve. All but the parameters stay where
 * they are. False: there are none, and the app ends with an error.
 */
bool sextant_mission_tables(struct sextant_tables *tables);

/* APID and key of the command link, the counter that was stored, the memory of files that are sent up. */
void sextant_mission_link(struct sextant_link_configuration *configuration);

/*
 * Stores the counter of the last authentic packet where it outlasts a loss of power. Called where it has
 * moved, before the next second is flown.
 */
void sextant_mission_store_counter(uint32_t counter);

/*
 * The instruments: the detector, and what there is of rate sensor, magnetometer, shutters and meter. All are
 * zero before the call but the clock, which is that of CFE_TIME (sextant_app_clock) and may be replaced.
 * Called once; the callbacks run in every second.
 */
void sextant_mission_instruments(struct sextant_instruments *instruments);

/*
 * The clock of CFE_TIME. Local time is MET; Terrestrial Time is TAI (MET + STCF) on the mission's epoch, and
 * not synchronised unless the clock is CFE_TIME_ClockState_VALID: in flywheel the sensor's own holdover
 * serves.
 */
struct sextant_clock sextant_app_clock(void);

/*
 * Microseconds of Terrestrial Time from J2000.0 to the epoch from which CFE_TIME_GetTAI counts: that of
 * CFE_MISSION_TIME_EPOCH_... Here 1980-01-01T00:00:00 TAI: -7305.5 days + 32.184 s.
 */
#ifndef SEXTANT_APP_EPOCH_US
#define SEXTANT_APP_EPOCH_US (-631195167816000)
#endif

/* Seconds after which a frame with an orbit is kept anew in the Critical Data Store. */
#ifndef SEXTANT_APP_KEEP_SECONDS
#define SEXTANT_APP_KEEP_SECONDS 300
#endif

/* Number of the app in the performance log. */
#ifndef SEXTANT_APP_PERF_ID
#define SEXTANT_APP_PERF_ID 91
#endif

/* The app's task: the entry point of the start-up script. */
void SEXTANT_APP_Main(void);

#endif
