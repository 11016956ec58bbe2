/*
 * The flight library in a C program: one cycle a recorded frame, its telemetry to a file.
 *
 * In: the command line FRAMES PARAMETERS TELEMETRY [COMMANDS REPORTS]; without the last two no command link
 * is made. Out: telemetry, reports of the link, one line of figures on standard output (a JSON object), and
 * the status 0 done, 1 a second could not be flown, 2 bad input or usage. The same program runs on a host and
 * on the emulated on-board computer. No heap; what lasts as long as the flight is static.
 */
#include "commands.h"
#include "platform.h"
#include "recorded.h"
#include "sextant.h"

enum status {
    STATUS_DONE = 0,
    STATUS_FAILED = 1,
    STATUS_INPUT = 2,
};

static _Alignas(SEXTANT_SENSOR_ALIGNMENT) uint8_t sensor_memory[SEXTANT_SENSOR_BYTES];
static uint8_t telemetry[SEXTANT_TELEMETRY_BYTES];
static uint8_t parameters[SEXTANT_PARAMETERS_BYTES];
static struct recording recording;
static struct commands commands;
static struct sextant_result result;

/* What a flight came to. */
struct flight {
    uint32_t seconds;
    /* Seconds that were not flown, or whose telemetry was not written. */
    uint32_t failed;
    /* Seconds with an attitude, with an orbit; the last ones. */
    uint32_t attitudes;
    uint32_t orbits;
    struct sextant_attitude attitude;
    struct sextant_orbit orbit;
};

/* Prints a number in hexadecimal digits. */
static void print_hexadecimal(uint64_t number, unsigned digits) {
    char text[17];
    text[digits] = '\0';
    for (unsigned i = digits; i > 0; i--) {
        text[i - 1] = "0123456789abcdef"[number & 0xf];
        number >>= 4;
    }
    print(text);
}

/* Prints a member of the line of figures: its name with what is before it, and its number. */
static void print_figure(const char *name, uint32_t number) {
    char text[11];
    char *digit = text + sizeof text - 1;
    *digit = '\0';
    do {
        *--digit = (char)('0' + number % 10);
        number /= 10;
    } while (number != 0);
    print(name);
    print(digit);
}

/* The bits of the last attitude and position, by which a reader of the telemetry checks the struct. */
static void print_last(const struct flight *flight) {
    print(",\"quaternion_bits\":[");
    for (int i = 0; i < 4; i++) {
        const union {
            float value;
            uint32_t bits;
        } component = {.value = flight->attitude.quaternion[i]};
        print(i == 0 ? "\"" : ",\"");
        print_hexadecimal(component.bits, 8);
        print("\"");
    }
    print("],\"position_bits\":[");
    for (int i = 0; i < 3; i++) {
        const union {
            double value;
            uint64_t bits;
        } component = {.value = flight->orbit.position_km[i]};
        print(i == 0 ? "\"" : ",\"");
        print_hexadecimal(component.bits, 16);
        print("\"");
    }
    print("]");
}

static void print_figures(const struct flight *flight) {
    struct memory_figures memory = memory_figures();
    print_figure("{\"seconds\":", flight->seconds);
    print_figure(",\"failed\":", flight->failed);
    print_figure(",\"attitudes\":", flight->attitudes);
    print_figure(",\"orbits\":", flight->orbits);
    print_figure(",\"mode\":", result.mode);
    print_last(flight);
    print_figure(",\"sensor_bytes\":", (uint32_t)sextant_sensor_bytes());
    print_figure(",\"flash_bytes\":", memory.flash_bytes);
    print_figure(",\"static_ram_bytes\":", memory.static_ram_bytes);
    print_figure(",\"stack_bytes\":", memory.stack_bytes);
    print("}\n");
}

/* Says on standard error why nothing is flown. */
static int refuse(const char *text) {
    complain(text);
    return STATUS_INPUT;
}

/* Makes the sensor of a parameter table's file; null where it was refused, which is said. */
static struct sextant_sensor *make_sensor(const char *name) {
    struct file file;
    if (!file_open(&file, name, FILE_TO_READ)) {
        complain("PARAMETERS: cannot be read\n");
        return NULL;
    }
    const struct sextant_tables tables = {
        .parameters = {parameters, file_read_some(&file, parameters, sizeof parameters)},
        .catalogue = sextant_reference_catalogue(),
        .calibration = sextant_reference_calibration(),
    };
    struct sextant_sensor *sensor = NULL;
    sextant_status status = sextant_init(sensor_memory, sizeof sensor_memory, &tables, &sensor);
    if (status != SEXTANT_STATUS_OK) {
        complain("PARAMETERS: ");
        complain(sextant_status_text(status));
        complain("\n");
    }
    return sensor;
}

/* Flies a second, with the commands of its packets where there is a link; false where not all was done. */
static bool fly_second(struct sextant_sensor *sensor, const struct sextant_instruments *instruments,
                       uint32_t second, struct file *output) {
    size_t length = 0;
    if (commands.link == NULL) {
        return sextant_cycle(sensor, instruments, SEXTANT_COMMAND_CONTINUE, telemetry, sizeof telemetry,
                             &length, &result) == SEXTANT_STATUS_OK &&
               file_write(output, telemetry, length);
    }
    return commands_receive(&commands, second) &&
           sextant_cycle_commanded(sensor, commands.link, instruments, telemetry, sizeof telemetry, &length,
                                   &result) == SEXTANT_STATUS_OK &&
           file_write(output, telemetry, length) && commands_report(&commands, sensor, result.local_us);
}

/* Flies all seconds of the recording. */
static struct flight fly(struct sextant_sensor *sensor, struct file *output) {
    const struct sextant_instruments instruments = recording_instruments(&recording);
    struct flight flight = {0};
    for (uint32_t second = 0; second < recording.frames; second++) {
        recording_turn_to(&recording, second);
        flight.seconds++;
        flight.failed += !fly_second(sensor, &instruments, second, output);
        if (result.attitude.known) {
            flight.attitudes++;
            flight.attitude = result.attitude;
        }
        if (result.orbit.known) {
            flight.orbits++;
            flight.orbit = result.orbit;
        }
    }
    return flight;
}

int main(int argc, char **argv) {
    struct file output;
    if (argc != 4 && argc != 6) {
        return refuse("usage: c-image FRAMES PARAMETERS TELEMETRY [COMMANDS REPORTS]\n");
    }
    const char *refusal = recording_open(&recording, argv[1]);
    if (refusal != NULL) {
        return refuse(refusal);
    }
    struct sextant_sensor *sensor = make_sensor(argv[2]);
    if (sensor == NULL) {
        return STATUS_INPUT;
    }
    if (!file_open(&output, argv[3], FILE_TO_WRITE)) {
        return refuse("TELEMETRY: cannot be written\n");
    }
    if (argc == 6 && !commands_open(&commands, argv[4], argv[5])) {
        return refuse("COMMANDS: cannot be read, or REPORTS: cannot be written\n");
    }
    struct flight flight = fly(sensor, &output);
    print_figures(&flight);
    return flight.failed == 0 ? STATUS_DONE : STATUS_FAILED;
}
