/*
 * Sextant as an application of the core Flight System. SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * In: a wake-up message once a second, ground commands whose payload is a packet of the command link,
 * requests of housekeeping; instruments and tables by the functions of sextant_mission.h. Out: a telemetry
 * frame a second, reports of the command link, housekeeping, events. Orbit, mounting and a commanded safe go
 * on after a restart of the app or of the processor: a frame is kept in the Critical Data Store.
 *
 * One task, one pipe, no memory but the static. C99, as cFE is compiled; cFE of Caelum and later.
 */
#include <stddef.h>
#include <string.h>

#include "sextant_app_msg.h"
#include "sextant_mission.h"

enum {
    /* Packets of a file that is sent up come several in a second. */
    MOST_COMMANDS = 16,
    /* One: a wake-up that comes while a second is flown late is not made up for. */
    MOST_WAKEUPS = 1,
    MOST_REQUESTS = 2,
    PIPE_DEPTH = MOST_COMMANDS + MOST_WAKEUPS + MOST_REQUESTS,
};

/* A frame as the Critical Data Store holds it; length 0: none. */
struct kept {
    uint32 length;
    uint8 frame[SEXTANT_TELEMETRY_BYTES];
};

static struct {
    CFE_SB_PipeId_t pipe;
    CFE_ES_CDSHandle_t store;
    bool stores;
    uint32 unkept_seconds;
    /* Whether a second was flown, and whether it was in commanded safe. */
    bool flown;
    bool safe;
    struct kept kept;
    struct sextant_sensor *sensor;
    struct sextant_link *link;
    struct sextant_instruments instruments;
    struct sextant_result result;
    uint32_t counter;
    struct sextant_app_housekeeping_message housekeeping;
    struct sextant_app_frame_message frame;
    struct sextant_app_report_message report;
    /* With room for their alignment, which C99 cannot ask for. */
    uint8 sensor_memory[SEXTANT_SENSOR_BYTES + SEXTANT_SENSOR_ALIGNMENT];
    uint8 link_memory[SEXTANT_LINK_BYTES + SEXTANT_SENSOR_ALIGNMENT];
} app;

/* Says in the system log why the app does not start: events may not be registered yet. */
static bool refuse(const char *what, unsigned long status) {
    CFE_ES_WriteToSysLog("SEXTANT: %s, status 0x%08lx\n", what, status);
    return false;
}

static bool subscribe(CFE_SB_MsgId_Atom_t message, uint16 most) {
    const CFE_SB_MsgId_t id = CFE_SB_ValueToMsgId(message);
    return CFE_SB_SubscribeEx(id, app.pipe, CFE_SB_DEFAULT_QOS, most) == CFE_SUCCESS;
}

static bool start_bus(void) {
    CFE_Status_t status = CFE_EVS_Register(NULL, 0, CFE_EVS_EventFilter_BINARY);
    if (status != CFE_SUCCESS) {
        return refuse("no events", (unsigned long)(uint32)status);
    }
    status = CFE_SB_CreatePipe(&app.pipe, PIPE_DEPTH, "SEXTANT_PIPE");
    if (status != CFE_SUCCESS) {
        return refuse("no pipe", (unsigned long)(uint32)status);
    }
    if (!subscribe(SEXTANT_APP_CMD_MID, MOST_COMMANDS) || !subscribe(SEXTANT_APP_WAKEUP_MID, MOST_WAKEUPS) ||
        !subscribe(SEXTANT_APP_SEND_HK_MID, MOST_REQUESTS)) {
        return refuse("a message cannot be subscribed to", 0);
    }
    CFE_MSG_Init(CFE_MSG_PTR(app.housekeeping.header), CFE_SB_ValueToMsgId(SEXTANT_APP_HK_TLM_MID),
                 sizeof app.housekeeping);
    CFE_MSG_Init(CFE_MSG_PTR(app.frame.header), CFE_SB_ValueToMsgId(SEXTANT_APP_FRAME_TLM_MID),
                 sizeof app.frame);
    CFE_MSG_Init(CFE_MSG_PTR(app.report.header), CFE_SB_ValueToMsgId(SEXTANT_APP_REPORT_TLM_MID),
                 sizeof app.report);
    return true;
}

static uint8 *aligned(uint8 *memory) {
    return memory + (SEXTANT_SENSOR_ALIGNMENT - (uintptr_t)memory % SEXTANT_SENSOR_ALIGNMENT);
}

static bool start_sensor(void) {
    struct sextant_tables tables = {0};
    struct sextant_link_configuration configuration = {0};
    if (!sextant_mission_tables(&tables)) {
        return refuse("no tables", 0);
    }
    sextant_status status =
        sextant_init(aligned(app.sensor_memory), SEXTANT_SENSOR_BYTES, &tables, &app.sensor);
    if (status != SEXTANT_STATUS_OK) {
        return refuse(sextant_status_text(status), status);
    }
    sextant_mission_link(&configuration);
    app.counter = configuration.counter;
    status = sextant_link_init(aligned(app.link_memory), SEXTANT_LINK_BYTES, &configuration, &app.link);
    if (status != SEXTANT_STATUS_OK) {
        return refuse(sextant_status_text(status), status);
    }
    app.instruments.clock = sextant_app_clock();
    sextant_mission_instruments(&app.instruments);
    return true;
}

/* Goes on from what the store holds of before a restart. Without a store an orbit begins anew after one. */
static void resume(void) {
    struct sextant_app_housekeeping *told = &app.housekeeping.payload;
    CFE_Status_t status = CFE_ES_RegisterCDS(&app.store, sizeof app.kept, "Kept");
    app.stores = status == CFE_SUCCESS || status == CFE_ES_CDS_ALREADY_EXISTS;
    if (status != CFE_ES_CDS_ALREADY_EXISTS) {
        if (app.stores) {
            CFE_ES_CopyToCDS(app.store, &app.kept);
        }
        return;
    }
    if (CFE_ES_RestoreFromCDS(&app.kept, app.store) != CFE_SUCCESS || app.kept.length == 0 ||
        app.kept.length > sizeof app.kept.frame) {
        return;
    }
    const struct sextant_bytes kept = {app.kept.frame, app.kept.length};
    bool taken = sextant_resume(app.sensor, kept) == SEXTANT_STATUS_OK;
    told->resumed = taken ? SEXTANT_APP_RESUMED_TAKEN : SEXTANT_APP_RESUMED_DROPPED;
}

static bool start(void) {
    /* Zero also where cFE starts the app again without loading it: a sensor whose task was ended in a second
     * counts as busy until its memory is zero. */
    memset(&app, 0, sizeof app);
    if (!start_bus() || !start_sensor()) {
        return false;
    }
    resume();
    static const char *const resumed[] = {"nothing was kept", "what was kept goes on", "what was kept is dropped"};
    CFE_EVS_SendEvent(SEXTANT_APP_STARTED_EID, CFE_EVS_EventType_INFORMATION, "SEXTANT: library %s, %s",
                      sextant_version(), resumed[app.housekeeping.payload.resumed]);
    return true;
}

/* Sends a message of so many bytes. */
static void publish(CFE_MSG_Message_t *message, size_t bytes) {
    CFE_MSG_SetSize(message, bytes);
    CFE_SB_TimeStampMsg(message);
    CFE_SB_TransmitMsg(message, true);
}

/* Keeps the frame of the second, where it has an orbit and the last one is old, and where commanded safe
 * begins or has ended. */
static void keep(size_t length) {
    bool old = ++app.unkept_seconds >= SEXTANT_APP_KEEP_SECONDS && app.result.orbit.known;
    bool safe = app.result.mode == SEXTANT_MODE_COMMANDED_SAFE;
    bool changed = app.flown && safe != app.safe;
    app.flown = true;
    app.safe = safe;
    if (!app.stores || !(old || changed)) {
        return;
    }
    app.unkept_seconds = 0;
    app.kept.length = (uint32)length;
    memcpy(app.kept.frame, app.frame.frame, length);
    CFE_ES_CopyToCDS(app.store, &app.kept);
}

static void send_reports(void) {
    for (;;) {
        size_t length = 0;
        sextant_status status =
            sextant_link_report(app.link, app.sensor, app.result.local_us, app.report.packet,
                                sizeof app.report.packet, &length);
        if (status != SEXTANT_STATUS_OK || length == 0) {
            return;
        }
        publish(CFE_MSG_PTR(app.report.header), offsetof(struct sextant_app_report_message, packet) + length);
        app.housekeeping.payload.reports++;
    }
}

static void fly_second(void) {
    struct sextant_app_housekeeping *told = &app.housekeeping.payload;
    size_t length = 0;
    sextant_status status =
        sextant_cycle_commanded(app.sensor, app.link, &app.instruments, app.frame.frame,
                                sizeof app.frame.frame, &length, &app.result);
    told->status = status;
    if (status != SEXTANT_STATUS_OK) {
        told->refused_seconds++;
        CFE_EVS_SendEvent(SEXTANT_APP_SECOND_EID, CFE_EVS_EventType_ERROR, "SEXTANT: no second was flown: %s",
                          sextant_status_text(status));
        return;
    }
    told->seconds++;
    told->mode = app.result.mode;
    told->faults = app.result.faults;
    publish(CFE_MSG_PTR(app.frame.header), offsetof(struct sextant_app_frame_message, frame) + length);
    send_reports();
    keep(length);
}

/* Hands a packet to the command link, and its counter to the mission. */
static void take_telecommand(CFE_MSG_Message_t *message) {
    struct sextant_app_housekeeping *told = &app.housekeeping.payload;
    const struct sextant_bytes packet = {CFE_SB_GetUserData(message), CFE_SB_GetUserDataLength(message)};
    uint32_t refusal = 0;
    uint32_t counter = app.counter;
    sextant_status status = sextant_link_receive(app.link, packet, &refusal);
    if (status != SEXTANT_STATUS_OK) {
        told->bad_messages++;
        CFE_EVS_SendEvent(SEXTANT_APP_TELECOMMAND_EID, CFE_EVS_EventType_ERROR,
                          "SEXTANT: no telecommand, %lu bytes: %s", (unsigned long)packet.length,
                          sextant_status_text(status));
        return;
    }
    if (sextant_link_counter(app.link, &counter) == SEXTANT_STATUS_OK && counter != app.counter) {
        app.counter = counter;
        sextant_mission_store_counter(counter);
    }
    if (refusal == 0) {
        told->telecommands++;
        return;
    }
    told->refused_telecommands++;
    told->refusal = refusal;
    CFE_EVS_SendEvent(SEXTANT_APP_TELECOMMAND_EID, CFE_EVS_EventType_ERROR,
                      "SEXTANT: telecommand refused, reason %lu", (unsigned long)refusal);
}

static void reset_counters(void) {
    struct sextant_app_housekeeping *told = &app.housekeeping.payload;
    *told = (struct sextant_app_housekeeping){
        .status = told->status, .mode = told->mode, .faults = told->faults, .resumed = told->resumed};
    CFE_EVS_SendEvent(SEXTANT_APP_RESET_EID, CFE_EVS_EventType_INFORMATION, "SEXTANT: counters are zero");
}

static void refuse_message(unsigned long message, unsigned long code) {
    app.housekeeping.payload.bad_messages++;
    CFE_EVS_SendEvent(SEXTANT_APP_MESSAGE_EID, CFE_EVS_EventType_ERROR,
                      "SEXTANT: message 0x%lx with function code %lu is not known", message, code);
}

static void take_command(CFE_MSG_Message_t *message) {
    CFE_MSG_FcnCode_t code = 0;
    CFE_MSG_GetFcnCode(message, &code);
    bool bare = CFE_SB_GetUserDataLength(message) == 0;
    if (code == SEXTANT_APP_TELECOMMAND_CC) {
        take_telecommand(message);
    } else if (code == SEXTANT_APP_NOOP_CC && bare) {
        CFE_EVS_SendEvent(SEXTANT_APP_NOOP_EID, CFE_EVS_EventType_INFORMATION, "SEXTANT: library %s",
                          sextant_version());
    } else if (code == SEXTANT_APP_RESET_COUNTERS_CC && bare) {
        reset_counters();
    } else {
        refuse_message(SEXTANT_APP_CMD_MID, code);
    }
}

static void take(CFE_SB_Buffer_t *buffer) {
    CFE_SB_MsgId_t id = CFE_SB_INVALID_MSG_ID;
    CFE_MSG_GetMsgId(&buffer->Msg, &id);
    switch (CFE_SB_MsgIdToValue(id)) {
    case SEXTANT_APP_WAKEUP_MID:
        fly_second();
        break;
    case SEXTANT_APP_CMD_MID:
        take_command(&buffer->Msg);
        break;
    case SEXTANT_APP_SEND_HK_MID:
        publish(CFE_MSG_PTR(app.housekeeping.header), sizeof app.housekeeping);
        break;
    default:
        refuse_message(CFE_SB_MsgIdToValue(id), 0);
        break;
    }
}

void SEXTANT_APP_Main(void) {
    CFE_ES_PerfLogEntry(SEXTANT_APP_PERF_ID);
    uint32 run_status = start() ? CFE_ES_RunStatus_APP_RUN : CFE_ES_RunStatus_APP_ERROR;
    while (CFE_ES_RunLoop(&run_status)) {
        CFE_SB_Buffer_t *buffer = NULL;
        CFE_ES_PerfLogExit(SEXTANT_APP_PERF_ID);
        CFE_Status_t status = CFE_SB_ReceiveBuffer(&buffer, app.pipe, CFE_SB_PEND_FOREVER);
        CFE_ES_PerfLogEntry(SEXTANT_APP_PERF_ID);
        if (status == CFE_SUCCESS) {
            take(buffer);
        } else {
            CFE_EVS_SendEvent(SEXTANT_APP_PIPE_EID, CFE_EVS_EventType_CRITICAL,
                              "SEXTANT: the pipe cannot be read, status 0x%08lx",
                              (unsigned long)(uint32)status);
            run_status = CFE_ES_RunStatus_APP_ERROR;
        }
    }
    CFE_ES_PerfLogExit(SEXTANT_APP_PERF_ID);
    CFE_ES_ExitApp(run_status);
}
