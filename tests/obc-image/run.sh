#!/bin/sh
# Runs the flight image in the emulator; cargo's runner for thumbv7em, so `cargo obc -- FRAMES PARAMETERS TELEMETRY` comes
# here as `run.sh IMAGE FRAMES PARAMETERS TELEMETRY` (`cargo sil record` makes the first two); COMMANDS REPORTS may follow. File names are relative to where the command is given and hold no spaces: the image
# gets its command line as one string. The status is the image's own.
#
# defmt's log is decoded to standard error where `defmt-print` is installed, and not written where it is not.
# OBC_MACHINE=mps2-an500 in the environment is a Cortex-M7; the default, mps2-an386, a Cortex-M4F.
# With BAD_PIXELS=FILE that table of bad pixels (`cargo sil defects`) lies in the memory for what is sent up.
# With CYCLE_METER=FILE in the environment the cycle meter (`cargo build --release -p cycle-meter`) writes its counts there,
# and with CYCLE_METER_COUNT=NAME+NAME the calls of these functions (`room::function`) as well;
# with STACK_DEPTH=FILE the stack analysis (`cargo build --release -p stack-depth`) writes its line there.
set -eu

fail() {
    echo "obc-image: $1" >&2
    exit 2
}

[ $# -eq 4 ] || [ $# -eq 6 ] || fail "usage: cargo obc -- FRAMES PARAMETERS TELEMETRY [COMMANDS REPORTS]"
image=$1
shift
command -v qemu-system-arm >/dev/null || fail "qemu-system-arm is not installed (Debian: qemu-system-arm)"

log=
if command -v defmt-print >/dev/null; then
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
fi

semihosting=enable=on,target=native
for word in obc-image "$@" $log; do
    case $word in
    *[\ ,]*) fail "$word: a file name with a space or a comma cannot be handed to the image" ;;
    esac
    semihosting=$semihosting,arg=$word
done

set -- -M "${OBC_MACHINE:-mps2-an386}" -nographic -monitor none -serial none -semihosting-config "$semihosting" -kernel "$image"
if [ -n "${BAD_PIXELS:-}" ]; then
    [ -r "$BAD_PIXELS" ] || fail "$BAD_PIXELS: cannot be read"
    # Where STORE of memory.x begins.
    set -- "$@" -device "loader,file=$BAD_PIXELS,addr=0x00300000,force-raw=on"
fi
# The image is TARGET_DIR/thumbv7em-none-eabihf/flight/obc-image.
release=$(dirname "$image")/../../release
if [ -n "${STACK_DEPTH:-}" ]; then
    "$release/stack-depth" "$image" >"$STACK_DEPTH" || fail "the stack's depth has no bound: see $STACK_DEPTH"
fi
if [ -n "${CYCLE_METER:-}" ]; then
    meter=$release/libcycle_meter.so
    [ -e "$meter" ] || fail "$meter: not built (cargo build --release -p cycle-meter)"
    set -- "$@" -plugin "$meter,elf=$image,out=$CYCLE_METER${CYCLE_METER_COUNT:+,count=$CYCLE_METER_COUNT}"
fi

status=0
qemu-system-arm "$@" || status=$?
if [ -n "$log" ] && [ -s "$log" ]; then
    defmt-print -e "$image" <"$log" >&2 || true
fi
exit "$status"
