/*
 * The Sextant app of fsw-c/cfs on the stand-in of cFE: the mission's functions on a recording, and what sends
 * the wake-ups and the telecommands.
 *
 * In: the command line FRAMES PARAMETERS TELEMETRY COMMANDS REPORTS [RESTART KEPT SPOILT]. COMMANDS: packets
 * by second, as tests/c-image reads them. RESTART: before that second the app is started again, and the
 * Critical Data Store goes to the file KEPT; the bits of its byte SPOILT are turned over then, beyond its end
 * those of none. Out: the payloads of the app's messages, telemetry and reports; its
 * housekeeping as one line of JSON on standard output, events on standard error. Status 0 done, 1 the app
 * ended with an error, 2 bad input.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cfe_host.h"
#include "commands.h"
#include "recorded.h"
#include "sextant_app_msg.h"
#include "sextant_mission.h"

/* A function code that the app does not know. */
enum { UNKNOWN_CC = 9 };

static const int64_t RANGE_US = ((int64_t)1 << 32) * 1000000;

static struct recording recording;
static struct packets packets;
static uint8_t parameters[SEXTANT_PARAMETERS_BYTES];
static size_t parameters_bytes;
static uint32_t stored_counter;
static struct file telemetry;
static struct file reports;
static uint32_t second;
static uint32_t restart_second = UINT32_MAX;
static bool asked;
static bool failed;

bool sextant_mission_tables(struct sextant_tables *tables) {
    tables->parameters = (struct sextant_bytes){parameters, parameters_bytes};
    tables->catalogue = sextant_reference_catalogue();
    tables->calibration = sextant_reference_calibration();
    return true;
}

void sextant_mission_link(struct sextant_link_configuration *configuration) {
    *configuration = commands_configuration();
    configuration->counter = stored_counter;
}

void sextant_mission_store_counter(uint32_t counter) {
    stored_counter = counter;
}

void sextant_mission_instruments(struct sextant_instruments *instruments) {
    const struct sextant_instruments recorded = recording_instruments(&recording);
    instruments->detector = recorded.detector;
    instruments->rate_sensor = recorded.rate_sensor;
    instruments->magnetometer = recorded.magnetometer;
}

/* Sends a message with a payload to the app. */
static void send(CFE_SB_MsgId_Atom_t message, CFE_MSG_FcnCode_t code, const uint8_t *payload, size_t length) {
    struct {
        CFE_MSG_CommandHeader_t header;
        uint8_t payload[SEXTANT_TELECOMMAND_BYTES];
    } sent;
    CFE_MSG_Init(CFE_MSG_PTR(sent.header), CFE_SB_ValueToMsgId(message), sizeof sent);
    CFE_MSG_SetFcnCode(CFE_MSG_PTR(sent.header), code);
    CFE_MSG_SetSize(CFE_MSG_PTR(sent.header), sizeof sent.header + length);
    memcpy(sent.payload, payload, length);
    cfe_host_send(CFE_MSG_PTR(sent.header));
}

static void send_bare(CFE_SB_MsgId_Atom_t message, CFE_MSG_FcnCode_t code) {
    send(message, code, (const uint8_t *)"", 0);
}

/* Commands that the app obeys or refuses and that fly nothing. */
static void send_others(void) {
    static const uint8_t nothing[SEXTANT_TELECOMMAND_BYTES];
    send_bare(SEXTANT_APP_CMD_MID, SEXTANT_APP_NOOP_CC);
    send(SEXTANT_APP_CMD_MID, SEXTANT_APP_RESET_COUNTERS_CC, nothing, 1);
    send_bare(SEXTANT_APP_CMD_MID, SEXTANT_APP_RESET_COUNTERS_CC);
    send_bare(SEXTANT_APP_CMD_MID, UNKNOWN_CC);
    send(SEXTANT_APP_CMD_MID, SEXTANT_APP_TELECOMMAND_CC, nothing, sizeof nothing);
    /* To another app: the bus does not deliver it. */
    send_bare(SEXTANT_APP_HK_TLM_MID, 0);
}

/* CFE_TIME as the frame of the second has it. */
static void set_time(void) {
    int64_t local_us = recording.local_us;
    if (recording.terrestrial_us == INT64_MIN) {
        cfe_host_set_time(local_us, 0, CFE_TIME_ClockState_INVALID);
        return;
    }
    int64_t stcf_us = (recording.terrestrial_us - SEXTANT_APP_EPOCH_US - local_us) % RANGE_US;
    cfe_host_set_time(local_us, stcf_us < 0 ? stcf_us + RANGE_US : stcf_us, CFE_TIME_ClockState_VALID);
}

void cfe_host_idle(void) {
    uint8_t packet[SEXTANT_TELECOMMAND_BYTES];
    size_t length;
    if (second == restart_second) {
        restart_second = UINT32_MAX;
        cfe_host_end(CFE_ES_RunStatus_SYS_RESTART);
        return;
    }
    if (second == recording.frames) {
        if (asked) {
            cfe_host_end(CFE_ES_RunStatus_APP_EXIT);
        }
        asked = true;
        send_bare(SEXTANT_APP_SEND_HK_MID, 0);
        return;
    }
    if (second == 0) {
        send_others();
    }
    recording_turn_to(&recording, second);
    set_time();
    while ((length = packets_next(&packets, second, packet)) != 0) {
        send(SEXTANT_APP_CMD_MID, SEXTANT_APP_TELECOMMAND_CC, packet, length);
    }
    /* The second one comes while the first waits, and is not made up for. */
    send_bare(SEXTANT_APP_WAKEUP_MID, 0);
    send_bare(SEXTANT_APP_WAKEUP_MID, 0);
    second++;
}

static void print_housekeeping(const struct sextant_app_housekeeping *told) {
    printf("{\"seconds\":%" PRIu32 ",\"refused_seconds\":%" PRIu32 ",\"status\":%" PRIu32, told->seconds,
           told->refused_seconds, told->status);
    printf(",\"telecommands\":%" PRIu32 ",\"refused_telecommands\":%" PRIu32 ",\"refusal\":%" PRIu32,
           told->telecommands, told->refused_telecommands, told->refusal);
    printf(",\"bad_messages\":%" PRIu32 ",\"reports\":%" PRIu32 ",\"mode\":%" PRIu32 ",\"faults\":%" PRIu32,
           told->bad_messages, told->reports, told->mode, told->faults);
    printf(",\"resumed\":%" PRIu32 ",\"counter\":%" PRIu32 "}\n", told->resumed, stored_counter);
}

void cfe_host_sent(const CFE_MSG_Message_t *message) {
    const uint8_t *payload = (const uint8_t *)message + sizeof(CFE_MSG_TelemetryHeader_t);
    size_t length = CFE_SB_GetUserDataLength(message);
    CFE_SB_MsgId_t id;
    CFE_MSG_GetMsgId(message, &id);
    switch (CFE_SB_MsgIdToValue(id)) {
    case SEXTANT_APP_FRAME_TLM_MID:
        failed |= !file_write(&telemetry, payload, length);
        break;
    case SEXTANT_APP_REPORT_TLM_MID:
        failed |= !file_write(&reports, payload, length);
        break;
    case SEXTANT_APP_HK_TLM_MID: {
        struct sextant_app_housekeeping told;
        failed |= length != sizeof told;
        memcpy(&told, payload, sizeof told);
        print_housekeeping(&told);
        break;
    }
    default:
        failed = true;
    }
}

/* Writes what the app has kept of before the restart, and spoils a byte of it. */
static bool write_kept(const char *name, size_t spoilt) {
    struct file kept;
    size_t length;
    uint8_t *store = cfe_host_store(&length);
    if (store == NULL || !file_open(&kept, name, FILE_TO_WRITE) || !file_write(&kept, store, length)) {
        return false;
    }
    if (spoilt < length) {
        store[spoilt] ^= 0xff;
    }
    return true;
}

static int refuse(const char *text) {
    complain(text);
    return 2;
}

int main(int argc, char **argv) {
    struct file table;
    if (argc != 6 && argc != 9) {
        return refuse("usage: cfs-host FRAMES PARAMETERS TELEMETRY COMMANDS REPORTS [RESTART KEPT SPOILT]\n");
    }
    const char *refusal = recording_open(&recording, argv[1]);
    if (refusal != NULL) {
        return refuse(refusal);
    }
    if (!file_open(&table, argv[2], FILE_TO_READ) || !packets_open(&packets, argv[4])) {
        return refuse("PARAMETERS or COMMANDS: cannot be read\n");
    }
    parameters_bytes = file_read_some(&table, parameters, sizeof parameters);
    if (!file_open(&telemetry, argv[3], FILE_TO_WRITE) || !file_open(&reports, argv[5], FILE_TO_WRITE)) {
        return refuse("TELEMETRY or REPORTS: cannot be written\n");
    }
    if (argc == 9) {
        restart_second = (uint32_t)strtoul(argv[6], NULL, 10);
        SEXTANT_APP_Main();
        if (cfe_host_exit_status() != CFE_ES_RunStatus_SYS_RESTART ||
            !write_kept(argv[7], strtoul(argv[8], NULL, 10))) {
            return 1;
        }
        cfe_host_restart();
    }
    SEXTANT_APP_Main();
    return failed || cfe_host_exit_status() != CFE_ES_RunStatus_APP_EXIT;
}
