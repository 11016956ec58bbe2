/* The file of packets, and what links them: the same for a program of its own and under a framework. */
#include "commands.h"
#include "little_endian.h"

/* Reads what stands before the next packet. */
static void read_head(struct packets *packets) {
    uint8_t head[6];
    packets->more = file_read(&packets->file, head, sizeof head);
    if (packets->more) {
        packets->second = u32_at(head);
        packets->length = u16_at(head + 4);
    }
}

bool packets_open(struct packets *packets, const char *name) {
    if (!file_open(&packets->file, name, FILE_TO_READ)) {
        return false;
    }
    read_head(packets);
    return true;
}

size_t packets_next(struct packets *packets, uint32_t second, uint8_t packet[SEXTANT_TELECOMMAND_BYTES]) {
    size_t length = packets->length;
    if (!packets->more || packets->second > second) {
        return 0;
    }
    if (length > SEXTANT_TELECOMMAND_BYTES || !file_read(&packets->file, packet, length)) {
        packets->more = false;
        return 0;
    }
    read_head(packets);
    return length;
}

struct sextant_link_configuration commands_configuration(void) {
    return (struct sextant_link_configuration){
        .apid = 0x2a5,
        .keyed = true,
        .key = {0x2b, 0x7e, 0x15, 0x16, 0x28, 0xae, 0xd2, 0xa6,
                0xab, 0xf7, 0x15, 0x88, 0x09, 0xcf, 0x4f, 0x3c},
    };
}
