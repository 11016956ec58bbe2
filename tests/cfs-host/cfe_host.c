/* The stand-in of cfe.h: one app, one pipe, one block of the Critical Data Store. */
#include "cfe_host.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum {
    MOST_MESSAGES = 32,
    MOST_SUBSCRIPTIONS = 8,
    MESSAGE_BYTES = 4096,
    STORE_BYTES = 8192,
    PIPE = 7,
    STORE = 9,
    COMMAND_BIT = 0x1000,
};

/* A message in the pipe. */
struct queued {
    _Alignas(CFE_SB_Buffer_t) uint8 bytes[MESSAGE_BYTES];
};

static struct {
    bool created;
    uint16 depth;
    /* A ring; the message that was received last stays until the next one is. */
    struct queued messages[MOST_MESSAGES];
    unsigned first;
    unsigned count;
    struct {
        CFE_SB_MsgId_Atom_t message;
        uint16 most;
    } subscriptions[MOST_SUBSCRIPTIONS];
    unsigned subscribed;
} bus;

static struct {
    bool registered;
    size_t length;
    uint8 bytes[STORE_BYTES];
} store;

static struct {
    CFE_TIME_SysTime_t met;
    CFE_TIME_SysTime_t stcf;
    CFE_TIME_ClockState_Enum_t state;
} clock_now;

static uint32 end_status;
static uint32 exit_status;

static CFE_SB_MsgId_Atom_t id_of(const CFE_MSG_Message_t *message) {
    return (CFE_SB_MsgId_Atom_t)(message->Byte[0] << 8 | message->Byte[1]);
}

static size_t size_of(const CFE_MSG_Message_t *message) {
    return (size_t)(message->Byte[4] << 8 | message->Byte[5]) + 7;
}

static size_t header_bytes(const CFE_MSG_Message_t *message) {
    bool command = (id_of(message) & COMMAND_BIT) != 0;
    return command ? sizeof(CFE_MSG_CommandHeader_t) : sizeof(CFE_MSG_TelemetryHeader_t);
}

/* Messages of that kind in the pipe. */
static unsigned waiting(CFE_SB_MsgId_Atom_t message) {
    unsigned count = 0;
    for (unsigned i = 0; i < bus.count; i++) {
        const struct queued *queued = &bus.messages[(bus.first + i) % MOST_MESSAGES];
        count += id_of((const CFE_MSG_Message_t *)queued->bytes) == message;
    }
    return count;
}

void cfe_host_send(const CFE_MSG_Message_t *message) {
    for (unsigned i = 0; i < bus.subscribed; i++) {
        if (bus.subscriptions[i].message != id_of(message)) {
            continue;
        }
        /* One place is that of the message that was received last. */
        if (bus.count < bus.depth && bus.count < MOST_MESSAGES - 1 &&
            waiting(id_of(message)) < bus.subscriptions[i].most) {
            memcpy(bus.messages[(bus.first + bus.count) % MOST_MESSAGES].bytes, message, size_of(message));
            bus.count++;
        }
        return;
    }
}

static CFE_TIME_SysTime_t time_of(int64_t us) {
    uint64_t fraction_us = (uint64_t)(us % 1000000);
    return (CFE_TIME_SysTime_t){
        .Seconds = (uint32)(us / 1000000),
        .Subseconds = (uint32)(((fraction_us << 32) + 500000) / 1000000),
    };
}

void cfe_host_set_time(int64_t met_us, int64_t stcf_us, CFE_TIME_ClockState_Enum_t state) {
    clock_now.met = time_of(met_us);
    clock_now.stcf = time_of(stcf_us);
    clock_now.state = state;
}

void cfe_host_end(uint32 run_status) {
    end_status = run_status;
}

uint32 cfe_host_exit_status(void) {
    return exit_status;
}

void cfe_host_restart(void) {
    memset(&bus, 0, sizeof bus);
    end_status = 0;
}

uint8 *cfe_host_store(size_t *length) {
    *length = store.length;
    return store.registered ? store.bytes : NULL;
}

bool CFE_ES_RunLoop(uint32 *RunStatus) {
    if (*RunStatus == CFE_ES_RunStatus_APP_RUN && bus.count == 0 && end_status == 0) {
        cfe_host_idle();
    }
    if (*RunStatus == CFE_ES_RunStatus_APP_RUN && bus.count == 0 && end_status != 0) {
        *RunStatus = end_status;
    }
    return *RunStatus == CFE_ES_RunStatus_APP_RUN;
}

void CFE_ES_ExitApp(uint32 ExitStatus) {
    exit_status = ExitStatus;
}

/* A line of text to standard error. */
static CFE_Status_t print_text(const char *format, va_list arguments) {
    vfprintf(stderr, format, arguments);
    return CFE_SUCCESS;
}

CFE_Status_t CFE_ES_WriteToSysLog(const char *SpecStringPtr, ...) {
    va_list arguments;
    va_start(arguments, SpecStringPtr);
    CFE_Status_t status = print_text(SpecStringPtr, arguments);
    va_end(arguments);
    return status;
}

CFE_Status_t CFE_EVS_Register(const void *Filters, uint16 NumEventFilters, uint16 FilterScheme) {
    (void)Filters, (void)NumEventFilters, (void)FilterScheme;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_EVS_SendEvent(uint16 EventID, uint16 EventType, const char *Spec, ...) {
    va_list arguments;
    fprintf(stderr, "event %u, type %u: ", (unsigned)EventID, (unsigned)EventType);
    va_start(arguments, Spec);
    CFE_Status_t status = print_text(Spec, arguments);
    va_end(arguments);
    fputs("\n", stderr);
    return status;
}

CFE_Status_t CFE_ES_RegisterCDS(CFE_ES_CDSHandle_t *CDSHandlePtr, size_t BlockSize, const char *Name) {
    (void)Name;
    if (BlockSize > sizeof store.bytes) {
        return CFE_ES_ERR_RESOURCEID_NOT_VALID;
    }
    CDSHandlePtr->id = STORE;
    if (store.registered && store.length == BlockSize) {
        return CFE_ES_CDS_ALREADY_EXISTS;
    }
    store.registered = true;
    store.length = BlockSize;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_ES_CopyToCDS(CFE_ES_CDSHandle_t Handle, const void *DataToCopy) {
    if (Handle.id != STORE) {
        return CFE_ES_ERR_RESOURCEID_NOT_VALID;
    }
    memcpy(store.bytes, DataToCopy, store.length);
    return CFE_SUCCESS;
}

CFE_Status_t CFE_ES_RestoreFromCDS(void *RestoreToMemory, CFE_ES_CDSHandle_t Handle) {
    if (Handle.id != STORE) {
        return CFE_ES_ERR_RESOURCEID_NOT_VALID;
    }
    memcpy(RestoreToMemory, store.bytes, store.length);
    return CFE_SUCCESS;
}

void CFE_ES_PerfLogAdd(uint32 Marker, uint32 EntryExit) {
    (void)Marker, (void)EntryExit;
}

CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t MsgId, CFE_MSG_Size_t Size) {
    memset(MsgPtr, 0, Size);
    MsgPtr->Byte[0] = (uint8)(MsgId.Value >> 8);
    MsgPtr->Byte[1] = (uint8)MsgId.Value;
    /* Not segmented. */
    MsgPtr->Byte[2] = 0xc0;
    return CFE_MSG_SetSize(MsgPtr, Size);
}

CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t *MsgPtr, CFE_MSG_Size_t *Size) {
    *Size = size_of(MsgPtr);
    return CFE_SUCCESS;
}

CFE_Status_t CFE_MSG_SetSize(CFE_MSG_Message_t *MsgPtr, CFE_MSG_Size_t Size) {
    if (Size < 7 || Size > MESSAGE_BYTES) {
        return CFE_SB_BAD_ARGUMENT;
    }
    MsgPtr->Byte[4] = (uint8)((Size - 7) >> 8);
    MsgPtr->Byte[5] = (uint8)(Size - 7);
    return CFE_SUCCESS;
}

CFE_Status_t CFE_MSG_GetMsgId(const CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t *MsgId) {
    MsgId->Value = id_of(MsgPtr);
    return CFE_SUCCESS;
}

CFE_Status_t CFE_MSG_GetFcnCode(const CFE_MSG_Message_t *MsgPtr, CFE_MSG_FcnCode_t *FcnCode) {
    *FcnCode = ((const uint8 *)MsgPtr)[offsetof(CFE_MSG_CommandHeader_t, Sec)];
    return CFE_SUCCESS;
}

CFE_Status_t CFE_MSG_SetFcnCode(CFE_MSG_Message_t *MsgPtr, CFE_MSG_FcnCode_t FcnCode) {
    ((uint8 *)MsgPtr)[offsetof(CFE_MSG_CommandHeader_t, Sec)] = (uint8)FcnCode;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t *PipeIdPtr, uint16 Depth, const char *PipeName) {
    (void)PipeName;
    bus.created = true;
    bus.depth = Depth;
    PipeIdPtr->id = PIPE;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_SB_SubscribeEx(CFE_SB_MsgId_t MsgId, CFE_SB_PipeId_t PipeId, CFE_SB_Qos_t Quality,
                                uint16 MsgLim) {
    (void)Quality;
    if (!bus.created || PipeId.id != PIPE || bus.subscribed == MOST_SUBSCRIPTIONS) {
        return CFE_SB_BAD_ARGUMENT;
    }
    bus.subscriptions[bus.subscribed].message = MsgId.Value;
    bus.subscriptions[bus.subscribed].most = MsgLim;
    bus.subscribed++;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t **BufPtr, CFE_SB_PipeId_t PipeId, int32 TimeOut) {
    (void)TimeOut;
    if (PipeId.id != PIPE || bus.count == 0) {
        return CFE_SB_PIPE_RD_ERR;
    }
    *BufPtr = (CFE_SB_Buffer_t *)bus.messages[bus.first].bytes;
    bus.first = (bus.first + 1) % MOST_MESSAGES;
    bus.count--;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t *MsgPtr, bool IsOrigination) {
    (void)IsOrigination;
    cfe_host_sent(MsgPtr);
    return CFE_SUCCESS;
}

void CFE_SB_TimeStampMsg(CFE_MSG_Message_t *MsgPtr) {
    const CFE_TIME_SysTime_t now = clock_now.met;
    const uint8 stamp[] = {
        (uint8)(now.Seconds >> 24), (uint8)(now.Seconds >> 16),    (uint8)(now.Seconds >> 8),
        (uint8)now.Seconds,         (uint8)(now.Subseconds >> 24), (uint8)(now.Subseconds >> 16),
    };
    memcpy((uint8 *)MsgPtr + offsetof(CFE_MSG_TelemetryHeader_t, Sec), stamp, sizeof stamp);
}

void *CFE_SB_GetUserData(CFE_MSG_Message_t *MsgPtr) {
    return (uint8 *)MsgPtr + header_bytes(MsgPtr);
}

size_t CFE_SB_GetUserDataLength(const CFE_MSG_Message_t *MsgPtr) {
    return size_of(MsgPtr) - header_bytes(MsgPtr);
}

CFE_TIME_SysTime_t CFE_TIME_GetMET(void) {
    return clock_now.met;
}

CFE_TIME_SysTime_t CFE_TIME_GetSTCF(void) {
    return clock_now.stcf;
}

CFE_TIME_ClockState_Enum_t CFE_TIME_GetClockState(void) {
    return clock_now.state;
}
