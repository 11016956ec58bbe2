#include "commands.h"

static _Alignas(SEXTANT_SENSOR_ALIGNMENT) uint8_t link_memory[SEXTANT_LINK_BYTES];
static uint8_t packet[SEXTANT_TELECOMMAND_BYTES];
static uint8_t report[SEXTANT_REPORT_BYTES];

bool commands_open(struct commands *commands, const char *packets, const char *reports) {
    const struct sextant_link_configuration configuration = commands_configuration();
    return packets_open(&commands->packets, packets) &&
           file_open(&commands->reports, reports, FILE_TO_WRITE) &&
           sextant_link_init(link_memory, sizeof link_memory, &configuration, &commands->link) ==
               SEXTANT_STATUS_OK;
}

bool commands_receive(struct commands *commands, uint32_t second) {
    bool received = true;
    size_t length;
    while ((length = packets_next(&commands->packets, second, packet)) != 0) {
        uint32_t refusal;
        const struct sextant_bytes bytes = {packet, length};
        received &= sextant_link_receive(commands->link, bytes, &refusal) == SEXTANT_STATUS_OK;
    }
    return received;
}

bool commands_report(struct commands *commands, struct sextant_sensor *sensor, int64_t local_us) {
    for (;;) {
        size_t length = 0;
        if (sextant_link_report(commands->link, sensor, local_us, report, sizeof report, &length) !=
            SEXTANT_STATUS_OK) {
            return false;
        }
        if (length == 0) {
            return true;
        }
        if (!file_write(&commands->reports, report, length)) {
            return false;
        }
    }
}
