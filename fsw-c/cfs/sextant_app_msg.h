/*
 * Messages of the Sextant app on the software bus. SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * The numbers are to be made unique in the mission: define them before this header, or by the build.
 */
#ifndef SEXTANT_APP_MSG_H
#define SEXTANT_APP_MSG_H

#include "cfe.h"
#include "sextant.h"

/* In: ground commands, the request of housekeeping, and the wake-up, once a second. */
#ifndef SEXTANT_APP_CMD_MID
#define SEXTANT_APP_CMD_MID 0x18e0
#define SEXTANT_APP_SEND_HK_MID 0x18e1
#define SEXTANT_APP_WAKEUP_MID 0x18e2
#endif

/* Out: housekeeping, a telemetry frame a second, reports of the command link. */
#ifndef SEXTANT_APP_HK_TLM_MID
#define SEXTANT_APP_HK_TLM_MID 0x08e0
#define SEXTANT_APP_FRAME_TLM_MID 0x08e1
#define SEXTANT_APP_REPORT_TLM_MID 0x08e2
#endif

/* Function codes of ground commands. The payload of a telecommand is a packet of the command link, whole. */
#define SEXTANT_APP_NOOP_CC 0
#define SEXTANT_APP_RESET_COUNTERS_CC 1
#define SEXTANT_APP_TELECOMMAND_CC 2

/* Event numbers. */
#define SEXTANT_APP_STARTED_EID 1
#define SEXTANT_APP_PIPE_EID 2
#define SEXTANT_APP_MESSAGE_EID 3
#define SEXTANT_APP_NOOP_EID 4
#define SEXTANT_APP_RESET_EID 5
#define SEXTANT_APP_TELECOMMAND_EID 6
#define SEXTANT_APP_SECOND_EID 7

/* What came of what was kept of before a restart. */
enum sextant_app_resumed {
    /* Nothing was kept. */
    SEXTANT_APP_RESUMED_NO = 0,
    /* It goes on; an orbit that is too old is forgotten with an event in telemetry. */
    SEXTANT_APP_RESUMED_TAKEN = 1,
    /* It was damaged or of another version: it was dropped. */
    SEXTANT_APP_RESUMED_DROPPED = 2,
};

struct sextant_app_housekeeping {
    /* Seconds that were flown, and that were refused: the last one's status says why. */
    uint32 seconds;
    uint32 refused_seconds;
    uint32 status;
    /* Packets of the command link that were accepted and refused; the last reason code. */
    uint32 telecommands;
    uint32 refused_telecommands;
    uint32 refusal;
    /* Messages that are none of the app's, of an unknown function code, or of a wrong length. */
    uint32 bad_messages;
    /* Reports that were sent. */
    uint32 reports;
    /* Of the last second: a sextant_mode, and a sum of SEXTANT_FAULT_... */
    uint32 mode;
    uint32 faults;
    /* A sextant_app_resumed. */
    uint32 resumed;
};

struct sextant_app_housekeeping_message {
    CFE_MSG_TelemetryHeader_t header;
    struct sextant_app_housekeeping payload;
};

/* A telemetry frame with its length before it. The message is as long as the frame. */
struct sextant_app_frame_message {
    CFE_MSG_TelemetryHeader_t header;
    uint8 frame[SEXTANT_TELEMETRY_BYTES];
};

/* A report packet. The message is as long as the packet. */
struct sextant_app_report_message {
    CFE_MSG_TelemetryHeader_t header;
    uint8 packet[SEXTANT_REPORT_BYTES];
};

#endif
