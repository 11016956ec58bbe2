/*
 * A stand-in for the core Flight Executive: what the Sextant app uses of its public interface, with the same
 * names and signatures, on a host. One app, one pipe, messages in the order in which they were sent. Not for
 * flight.
 *
 * Names, signatures and numbers are those of cFE's headers of the release Draco; messages have the header of
 * CCSDS 133.0-B-2 without the extension, telemetry six bytes of time and four spare, commands function code
 * and checksum.
 */
#ifndef CFE_H
#define CFE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef uint8_t uint8;
typedef int16_t int16;
typedef uint16_t uint16;
typedef int32_t int32;
typedef uint32_t uint32;

typedef int32 CFE_Status_t;
#define CFE_SUCCESS ((CFE_Status_t)0)
#define CFE_ES_CDS_ALREADY_EXISTS ((CFE_Status_t)0x4400000d)
#define CFE_ES_ERR_RESOURCEID_NOT_VALID ((CFE_Status_t)0xc4000001)
#define CFE_SB_BAD_ARGUMENT ((CFE_Status_t)0xca000003)
#define CFE_SB_PIPE_RD_ERR ((CFE_Status_t)0xca000006)

#if defined(__GNUC__)
#define OS_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define OS_PRINTF(text, first)
#endif

/* Executive services. */
enum CFE_ES_RunStatus {
    CFE_ES_RunStatus_APP_RUN = 1,
    CFE_ES_RunStatus_APP_EXIT = 2,
    CFE_ES_RunStatus_APP_ERROR = 3,
    CFE_ES_RunStatus_SYS_RESTART = 5,
};
typedef struct {
    uint32 id;
} CFE_ES_CDSHandle_t;
bool CFE_ES_RunLoop(uint32 *RunStatus);
void CFE_ES_ExitApp(uint32 ExitStatus);
CFE_Status_t CFE_ES_WriteToSysLog(const char *SpecStringPtr, ...) OS_PRINTF(1, 2);
CFE_Status_t CFE_ES_RegisterCDS(CFE_ES_CDSHandle_t *CDSHandlePtr, size_t BlockSize, const char *Name);
CFE_Status_t CFE_ES_CopyToCDS(CFE_ES_CDSHandle_t Handle, const void *DataToCopy);
CFE_Status_t CFE_ES_RestoreFromCDS(void *RestoreToMemory, CFE_ES_CDSHandle_t Handle);
void CFE_ES_PerfLogAdd(uint32 Marker, uint32 EntryExit);
#define CFE_ES_PerfLogEntry(id) (CFE_ES_PerfLogAdd(id, 0))
#define CFE_ES_PerfLogExit(id) (CFE_ES_PerfLogAdd(id, 1))

/* Events. */
enum CFE_EVS_EventType {
    CFE_EVS_EventType_INFORMATION = 2,
    CFE_EVS_EventType_ERROR = 3,
    CFE_EVS_EventType_CRITICAL = 4,
};
#define CFE_EVS_EventFilter_BINARY 0
CFE_Status_t CFE_EVS_Register(const void *Filters, uint16 NumEventFilters, uint16 FilterScheme);
CFE_Status_t CFE_EVS_SendEvent(uint16 EventID, uint16 EventType, const char *Spec, ...) OS_PRINTF(3, 4);

/* Messages. */
typedef union CFE_MSG_Message {
    uint8 Byte[6];
} CFE_MSG_Message_t;
typedef struct CFE_MSG_CommandHeader {
    CFE_MSG_Message_t Msg;
    uint8 Sec[2];
} CFE_MSG_CommandHeader_t;
typedef struct CFE_MSG_TelemetryHeader {
    CFE_MSG_Message_t Msg;
    uint8 Sec[6];
    uint8 Spare[4];
} CFE_MSG_TelemetryHeader_t;
#define CFE_MSG_PTR(shdr) (&((shdr).Msg))
typedef size_t CFE_MSG_Size_t;
typedef uint16 CFE_MSG_FcnCode_t;
typedef uint32 CFE_SB_MsgId_Atom_t;
typedef struct {
    CFE_SB_MsgId_Atom_t Value;
} CFE_SB_MsgId_t;
#define CFE_SB_INVALID_MSG_ID ((CFE_SB_MsgId_t){0})
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t MsgId, CFE_MSG_Size_t Size);
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t *MsgPtr, CFE_MSG_Size_t *Size);
CFE_Status_t CFE_MSG_SetSize(CFE_MSG_Message_t *MsgPtr, CFE_MSG_Size_t Size);
CFE_Status_t CFE_MSG_GetMsgId(const CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t *MsgId);
CFE_Status_t CFE_MSG_GetFcnCode(const CFE_MSG_Message_t *MsgPtr, CFE_MSG_FcnCode_t *FcnCode);
CFE_Status_t CFE_MSG_SetFcnCode(CFE_MSG_Message_t *MsgPtr, CFE_MSG_FcnCode_t FcnCode);

/* Software bus. */
#define CFE_SB_PEND_FOREVER -1
typedef struct {
    uint32 id;
} CFE_SB_PipeId_t;
typedef struct {
    uint8 Priority;
    uint8 Reliability;
} CFE_SB_Qos_t;
#define CFE_SB_DEFAULT_QOS ((CFE_SB_Qos_t){0})
typedef union CFE_SB_Msg {
    CFE_MSG_Message_t Msg;
    long long int LongInt;
    long double LongDouble;
} CFE_SB_Buffer_t;
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t *PipeIdPtr, uint16 Depth, const char *PipeName);
CFE_Status_t CFE_SB_SubscribeEx(CFE_SB_MsgId_t MsgId, CFE_SB_PipeId_t PipeId, CFE_SB_Qos_t Quality,
                                uint16 MsgLim);
CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t **BufPtr, CFE_SB_PipeId_t PipeId, int32 TimeOut);
CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t *MsgPtr, bool IsOrigination);
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t *MsgPtr);
void *CFE_SB_GetUserData(CFE_MSG_Message_t *MsgPtr);
size_t CFE_SB_GetUserDataLength(const CFE_MSG_Message_t *MsgPtr);

static inline CFE_SB_MsgId_Atom_t CFE_SB_MsgIdToValue(CFE_SB_MsgId_t MsgId) {
    return MsgId.Value;
}

static inline CFE_SB_MsgId_t CFE_SB_ValueToMsgId(CFE_SB_MsgId_Atom_t MsgIdValue) {
    return (CFE_SB_MsgId_t){MsgIdValue};
}

/* Time. */
typedef struct CFE_TIME_SysTime {
    uint32 Seconds;
    uint32 Subseconds;
} CFE_TIME_SysTime_t;
enum CFE_TIME_ClockState {
    CFE_TIME_ClockState_INVALID = -1,
    CFE_TIME_ClockState_VALID = 0,
    CFE_TIME_ClockState_FLYWHEEL = 1,
};
typedef int16 CFE_TIME_ClockState_Enum_t;
CFE_TIME_SysTime_t CFE_TIME_GetMET(void);
CFE_TIME_SysTime_t CFE_TIME_GetSTCF(void);
CFE_TIME_ClockState_Enum_t CFE_TIME_GetClockState(void);

#endif
