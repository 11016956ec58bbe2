/*
 * Telecommands out of a file of the host, and the reports about them into another, through the command link.
 *
 * In: packets by rising second, each led by its second (u32) and its length (u16), little-endian; those of
 * tests/obc-image/src/commands.rs. Out: report packets one after the other.
 */
#ifndef COMMANDS_H
#define COMMANDS_H

#include "platform.h"
#include "sextant.h"

/* The file of packets, read packet by packet. */
struct packets {
    struct file file;
    /* Second and length of the next packet; false: there is none. */
    bool more;
    uint32_t second;
    uint16_t length;
};

/* Opens a file of packets; false where it cannot be read. */
bool packets_open(struct packets *packets, const char *name);

/*
 * Copies the next packet that is due by that second; its length, 0 where none is. A packet that is longer
 * than any, or a file that breaks off, ends the packets.
 */
size_t packets_next(struct packets *packets, uint32_t second, uint8_t packet[SEXTANT_TELECOMMAND_BYTES]);

/* APID and key of the recorded flights: the key of RFC 4493, known to all. A flight has its own. */
struct sextant_link_configuration commands_configuration(void);

/* The link between its two files. */
struct commands {
    struct packets packets;
    struct file reports;
    struct sextant_link *link;
};

/* Opens both files and makes the link; false where one cannot be opened. */
bool commands_open(struct commands *commands, const char *packets, const char *reports);

/* Hands the packets of a second to the link; false where a call was refused. */
bool commands_receive(struct commands *commands, uint32_t second);

/* Writes the reports that wait; false where one cannot be written. */
bool commands_report(struct commands *commands, struct sextant_sensor *sensor, int64_t local_us);

#endif
