//! A program short enough to be counted by hand, for the emulator; see `emulator.rs` for the count.
#![no_std]
#![no_main]

core::arch::global_asm!(
    r#"
    .section .vectors, "a"
    .word 0x20001000
    .word start

    .text
    .macro function name
    .global \name
    .type \name, %function
    .thumb_func
\name:
    .endm

    function cycle_begin
    push {{r7, lr}}
    pop {{r7, pc}}
    .size cycle_begin, . - cycle_begin
    function cycle_end
    nop
    bx lr
    .size cycle_end, . - cycle_end
    function stage_begin
    ldr r1, =STAGE_MARKS
    ldrb r1, [r1, r0]
    bx lr
    .size stage_begin, . - stage_begin
    function stage_end
    ldr r1, =STAGE_MARKS
    ldrb r1, [r1, r0]
    bx lr
    .size stage_end, . - stage_end

    function start
    // The floating-point unit on: CPACR, full access to coprocessors 10 and 11.
    ldr r0, =0xE000ED88
    movs r1, #0xF00000
    str r1, [r0]
    isb
    movs r5, #2
0:  bl cycle_begin
    // 1 instruction, 1 cycle.
    movs r4, #10
    // 20 instructions, 20 cycles and 9 refills.
1:  subs r4, #1
    bne 1b
    // Twice a number and a call: 4 instructions, 4 cycles, of which the second half is within the stage.
    movs r0, #3
    bl stage_begin
    // 7 instructions: 2 + 1 + 3 + 1 (late) + 14 + 1 (late) + 2 + 1 (late) + 5 + 12 = 42 cycles.
    vldr s0, [sp, #-4]
    vadd.f32 s1, s0, s0
    vmla.f32 s2, s1, s1
    vsqrt.f32 s3, s2
    vstr s3, [sp, #-4]
    ldm sp, {{r1, r2, r3, r6}}
    udiv r1, r2, r3
    movs r0, #3
    bl stage_end
    // A branch over a 32-bit instruction, and an instruction that its IT skips: 4 instructions, 4 cycles, a
    // refill.
    b 2f
    movw r0, #1
2:  cmp r4, #1
    it eq
    moveq r0, r4
    // 1 instruction, 1 cycle.
    bl cycle_end
    subs r5, #1
    bne 0b
    // SYS_EXIT, ADP_Stopped_ApplicationExit.
    movs r0, #0x18
    ldr r1, =0x20026
    bkpt #0xab
    b .
    .size start, . - start
    .ltorg

    .section .rodata
    .global STAGE_MARKS
    .type STAGE_MARKS, %object
    .size STAGE_MARKS, 32
STAGE_MARKS: .space 32
"#
);

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
