#!/bin/sh
# Builds the flight library and the C program, and runs it: `tests/c-image/run.sh host|obc FRAMES PARAMETERS
# TELEMETRY [COMMANDS REPORTS]` (`cargo sil record` makes the first two). `host`: with gcc, on this machine. `obc`: with
# arm-none-eabi-gcc for the reference on-board computer, in the emulator; file names hold no spaces or
# commas there. Without files it is built only. The status is the program's own. Anything the library could
# panic at is a link error of `obc`.
#
# With LIBRARY=FILE in the environment that library is linked and none is built; with PROFILE=flight-size
# the library of `obc` is built for size.
set -eu

here=$(dirname "$0")
root=$here/../..
warnings="-std=c11 -Wall -Wextra -Wpedantic -Werror"
target=thumbv7em-none-eabihf

fail() {
    echo "c-image: $1" >&2
    exit 2
}

usage="usage: tests/c-image/run.sh host|obc [FRAMES PARAMETERS TELEMETRY [COMMANDS REPORTS]]"
[ $# -eq 1 ] || [ $# -eq 4 ] || [ $# -eq 6 ] || fail "$usage"
platform=$1
shift
target_dir=${CARGO_TARGET_DIR:-$root/target}
profile=${PROFILE:-flight}
sources="$here/main.c $here/recorded.c $here/packets.c $here/commands.c $here/platform_$platform.c"

# Where the program goes; the library, built with these options unless there is one.
in_folder() {
    built=$1
    library=${LIBRARY:-$built/libsextant.a}
    shift
    [ -n "${LIBRARY:-}" ] || (cd "$root" && cargo build --quiet --locked -p fsw-c "$@")
}

# Renamed when it is whole: another run may start the program meanwhile.
put_in_place() { mv "$built/c-image.$$" "$built/c-image"; }

case $platform in
host)
    in_folder "$target_dir/release" --release
    # shellcheck disable=SC2086 # words
    cc $warnings -O2 -I "$root/fsw-c/include" -o "$built/c-image.$$" $sources "$library" -lm -lpthread -ldl
    put_in_place
    [ $# -eq 0 ] || exec "$built/c-image" "$@"
    ;;
obc)
    command -v arm-none-eabi-gcc >/dev/null || fail "arm-none-eabi-gcc is not installed (Debian: gcc-arm-none-eabi)"
    in_folder "$target_dir/$target/$profile" --profile "$profile" --target "$target"
    # shellcheck disable=SC2086 # words
    arm-none-eabi-gcc $warnings -Os -ffreestanding -ffunction-sections -fdata-sections \
        -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -I "$root/fsw-c/include" \
        -nostdlib -Wl,--gc-sections -Wl,-z,noexecstack -L "$root" -T "$here/image.ld" \
        -o "$built/c-image.$$" $sources "$here/startup.c" "$library"
    put_in_place
    [ $# -gt 0 ] || exit 0
    command -v qemu-system-arm >/dev/null || fail "qemu-system-arm is not installed (Debian: qemu-system-arm)"
    semihosting=enable=on,target=native
    for word in c-image "$@"; do
        case $word in
        *[\ ,]*) fail "$word: a file name with a space or a comma cannot be handed to the image" ;;
        esac
        semihosting=$semihosting,arg=$word
    done
    exec qemu-system-arm -M mps2-an386 -nographic -monitor none -serial none -semihosting-config "$semihosting" \
        -kernel "$built/c-image"
    ;;
*) fail "$usage" ;;
esac
