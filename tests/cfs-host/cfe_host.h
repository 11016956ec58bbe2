/* What drives an app on the stand-in of cfe.h: the other side of the software bus. */
#ifndef CFE_HOST_H
#define CFE_HOST_H

#include "cfe.h"

/* Sends a message to the app's pipe; dropped where the app has not subscribed to it or has enough of it. */
void cfe_host_send(const CFE_MSG_Message_t *message);

/* Sets MET and STCF, microseconds, and the clock's state. */
void cfe_host_set_time(int64_t met_us, int64_t stcf_us, CFE_TIME_ClockState_Enum_t state);

/* Has CFE_ES_RunLoop end the app with a status once the pipe is empty. */
void cfe_host_end(uint32 run_status);

/* The status with which the app ended. */
uint32 cfe_host_exit_status(void);

/* Forgets pipe and subscriptions; the Critical Data Store stays, as it does when cFE starts an app again. */
void cfe_host_restart(void);

/* What the Critical Data Store holds; null where it was never registered. */
uint8 *cfe_host_store(size_t *length);

/*
 * Given by the program: called where the app waits and no message is there. It sends some, or ends the app.
 */
void cfe_host_idle(void);

/* Given by the program: a message that the app sent. */
void cfe_host_sent(const CFE_MSG_Message_t *message);

#endif
