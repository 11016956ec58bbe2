//! The classes, on encodings from LLVM's assembler and cycles read by hand from the manual's tables.

use super::Instruction;

/// Assembly, halfwords, length in bytes, cycles without refill.
const ENCODINGS: &[(&str, u16, u16, u32, u32)] = &[
    ("movs r0, #1", 0x2001, 0, 2, 1),
    ("adds r0, r1, r2", 0x1888, 0, 2, 1),
    ("lsls r0, r1, #3", 0x00c8, 0, 2, 1),
    ("muls r0, r1, r0", 0x4348, 0, 2, 1),
    ("bx lr", 0x4770, 0, 2, 1),
    ("blx r3", 0x4798, 0, 2, 1),
    ("mov pc, r1", 0x468f, 0, 2, 1),
    ("ldr r0, [pc, #8]", 0x4802, 0, 2, 2),
    ("ldr r0, [r1, r2]", 0x5888, 0, 2, 2),
    ("str r0, [r1, r2]", 0x5088, 0, 2, 2),
    ("ldrsh r0, [r1, r2]", 0x5e88, 0, 2, 2),
    ("ldr r0, [r1, #4]", 0x6848, 0, 2, 2),
    ("str r0, [r1, #4]", 0x6048, 0, 2, 2),
    ("ldrb r0, [r1, #4]", 0x7908, 0, 2, 2),
    ("strh r0, [r1, #4]", 0x8088, 0, 2, 2),
    ("ldr r0, [sp, #4]", 0x9801, 0, 2, 2),
    ("str r0, [sp, #4]", 0x9001, 0, 2, 2),
    ("adr r0, #8", 0xa002, 0, 2, 1),
    ("add r0, sp, #8", 0xa802, 0, 2, 1),
    ("sub sp, #16", 0xb084, 0, 2, 1),
    ("cbz r0, .", 0xb100, 0, 2, 1),
    ("uxth r0, r1", 0xb288, 0, 2, 1),
    ("rev r0, r1", 0xba08, 0, 2, 1),
    ("push {r4, r5, r7, lr}", 0xb5b0, 0, 2, 5),
    ("pop {r4, r7, pc}", 0xbd90, 0, 2, 4),
    ("push {lr}", 0xb500, 0, 2, 2),
    ("cpsid i", 0xb672, 0, 2, 2),
    ("bkpt #0xab", 0xbeab, 0, 2, 1),
    ("nop", 0xbf00, 0, 2, 1),
    ("it eq", 0xbf08, 0, 2, 1),
    ("moveq r0, #1", 0x2001, 0, 2, 1),
    ("stm r0!, {r1, r2, r3}", 0xc00e, 0, 2, 4),
    ("ldm r0!, {r1, r2}", 0xc806, 0, 2, 3),
    ("beq .", 0xd0ff, 0, 2, 1),
    ("b .", 0xe7ff, 0, 2, 1),
    ("udf #0", 0xde00, 0, 2, 1),
    ("add.w r0, r1, r2, lsl #3", 0xeb01, 0x00c2, 4, 1),
    ("movw r0, #0x1234", 0xf241, 0x2034, 4, 1),
    ("movt r0, #0x1234", 0xf2c1, 0x2034, 4, 1),
    ("mvn r0, #0x80000000", 0xf06f, 0x4000, 4, 1),
    ("ubfx r0, r1, #3, #4", 0xf3c1, 0x00c3, 4, 1),
    ("ssat r0, #8, r1", 0xf301, 0x0007, 4, 1),
    ("bl .", 0xf000, 0xf800, 4, 1),
    ("b.w .", 0xf000, 0xb800, 4, 1),
    ("beq.w .", 0xf000, 0x8000, 4, 1),
    ("mrs r0, PRIMASK", 0xf3ef, 0x8010, 4, 2),
    ("msr BASEPRI, r0", 0xf380, 0x8811, 4, 2),
    ("dsb", 0xf3bf, 0x8f4f, 4, 4),
    ("dmb", 0xf3bf, 0x8f5f, 4, 4),
    ("isb", 0xf3bf, 0x8f6f, 4, 4),
    ("clrex", 0xf3bf, 0x8f2f, 4, 1),
    ("dbg #0", 0xf3af, 0x80f0, 4, 1),
    ("nop.w", 0xf3af, 0x8000, 4, 1),
    ("push.w {r4, r5, r6, r7, r8, lr}", 0xe92d, 0x41f0, 4, 7),
    ("pop.w {r4, r5, r8, pc}", 0xe8bd, 0x8130, 4, 5),
    ("stmdb r0!, {r1, r2}", 0xe920, 0x0006, 4, 3),
    ("ldmdb r0, {r1, r2, r3}", 0xe910, 0x000e, 4, 4),
    ("ldrd r0, r1, [r2, #8]", 0xe9d2, 0x0102, 4, 3),
    ("strd r0, r1, [r2, #8]!", 0xe9e2, 0x0102, 4, 3),
    ("ldrd r0, r1, [r2], #8", 0xe8f2, 0x0102, 4, 3),
    ("strd r0, r1, [r2], #-8", 0xe862, 0x0102, 4, 3),
    ("ldrex r0, [r1, #4]", 0xe851, 0x0f01, 4, 2),
    ("strex r0, r1, [r2, #4]", 0xe842, 0x1001, 4, 2),
    ("ldrexb r0, [r1]", 0xe8d1, 0x0f4f, 4, 2),
    ("strexh r0, r1, [r2]", 0xe8c2, 0x1f50, 4, 2),
    ("tbb [pc, r0]", 0xe8df, 0xf000, 4, 2),
    ("tbh [pc, r0, lsl #1]", 0xe8df, 0xf010, 4, 2),
    ("ldr.w r0, [r1, #400]", 0xf8d1, 0x0190, 4, 2),
    ("ldr.w r0, [r1, r2, lsl #2]", 0xf851, 0x0022, 4, 2),
    ("ldr r0, [r1], #4", 0xf851, 0x0b04, 4, 2),
    ("ldr.w pc, [r1, #4]", 0xf8d1, 0xf004, 4, 2),
    ("ldrsb.w r0, [r1, #40]", 0xf991, 0x0028, 4, 2),
    ("ldrh.w r8, [r1, #40]", 0xf8b1, 0x8028, 4, 2),
    ("str.w r0, [r1, r2, lsl #2]", 0xf841, 0x0022, 4, 2),
    ("strb r0, [r1, #-1]!", 0xf801, 0x0d01, 4, 2),
    ("pld [r0]", 0xf890, 0xf000, 4, 2),
    ("lsl.w r0, r1, r2", 0xfa01, 0xf002, 4, 1),
    ("uxtb.w r8, r1", 0xfa5f, 0xf881, 4, 1),
    ("clz r0, r1", 0xfab1, 0xf081, 4, 1),
    ("qadd r0, r1, r2", 0xfa82, 0xf081, 4, 1),
    ("uadd8 r0, r1, r2", 0xfa81, 0xf042, 4, 1),
    ("mul r0, r1, r8", 0xfb01, 0xf008, 4, 1),
    ("mla r0, r1, r2, r3", 0xfb01, 0x3002, 4, 1),
    ("mls r0, r1, r2, r3", 0xfb01, 0x3012, 4, 1),
    ("smulbb r0, r1, r2", 0xfb11, 0xf002, 4, 1),
    ("smmul r0, r1, r2", 0xfb51, 0xf002, 4, 1),
    ("smull r0, r1, r2, r3", 0xfb82, 0x0103, 4, 1),
    ("umull r0, r1, r2, r3", 0xfba2, 0x0103, 4, 1),
    ("smlal r0, r1, r2, r3", 0xfbc2, 0x0103, 4, 1),
    ("umlal r0, r1, r2, r3", 0xfbe2, 0x0103, 4, 1),
    ("umaal r0, r1, r2, r3", 0xfbe2, 0x0163, 4, 1),
    ("smlald r0, r1, r2, r3", 0xfbc2, 0x01c3, 4, 1),
    ("sdiv r0, r1, r2", 0xfb91, 0xf0f2, 4, 12),
    ("udiv r0, r1, r2", 0xfbb1, 0xf0f2, 4, 12),
    ("vadd.f32 s0, s1, s2", 0xee30, 0x0a81, 4, 1),
    ("vsub.f32 s0, s1, s2", 0xee30, 0x0ac1, 4, 1),
    ("vmul.f32 s0, s1, s2", 0xee20, 0x0a81, 4, 1),
    ("vnmul.f32 s0, s1, s2", 0xee20, 0x0ac1, 4, 1),
    ("vmla.f32 s0, s1, s2", 0xee00, 0x0a81, 4, 3),
    ("vmls.f32 s0, s1, s2", 0xee00, 0x0ac1, 4, 3),
    ("vnmla.f32 s0, s1, s2", 0xee10, 0x0ac1, 4, 3),
    ("vnmls.f32 s0, s1, s2", 0xee10, 0x0a81, 4, 3),
    ("vfma.f32 s0, s1, s2", 0xeea0, 0x0a81, 4, 3),
    ("vfms.f32 s0, s1, s2", 0xeea0, 0x0ac1, 4, 3),
    ("vfnma.f32 s0, s1, s2", 0xee90, 0x0ac1, 4, 3),
    ("vfnms.f32 s0, s1, s2", 0xee90, 0x0a81, 4, 3),
    ("vdiv.f32 s0, s1, s2", 0xee80, 0x0a81, 4, 14),
    ("vsqrt.f32 s0, s1", 0xeeb1, 0x0ae0, 4, 14),
    ("vabs.f32 s0, s1", 0xeeb0, 0x0ae0, 4, 1),
    ("vneg.f32 s0, s1", 0xeeb1, 0x0a60, 4, 1),
    ("vmov.f32 s0, s1", 0xeeb0, 0x0a60, 4, 1),
    ("vmov.f32 s0, #1.0", 0xeeb7, 0x0a00, 4, 1),
    ("vcmp.f32 s0, s1", 0xeeb4, 0x0a60, 4, 1),
    ("vcmp.f32 s0, #0", 0xeeb5, 0x0a40, 4, 1),
    ("vcvt.s32.f32 s0, s1", 0xeebd, 0x0ae0, 4, 1),
    ("vcvt.f32.u32 s0, s1", 0xeeb8, 0x0a60, 4, 1),
    ("vcvt.f32.s32 s0, s0, #16", 0xeeba, 0x0ac8, 4, 1),
    ("vmov s0, r1", 0xee00, 0x1a10, 4, 1),
    ("vmov r1, s0", 0xee10, 0x1a10, 4, 1),
    ("vmov s2, s3, r0, r1", 0xec41, 0x0a11, 4, 2),
    ("vmov d1, r0, r1", 0xec41, 0x0b11, 4, 2),
    ("vmov r0, r1, d1", 0xec51, 0x0b11, 4, 2),
    ("vmrs APSR_nzcv, fpscr", 0xeef1, 0xfa10, 4, 1),
    ("vmsr fpscr, r0", 0xeee1, 0x0a10, 4, 1),
    ("vldr s1, [r0, #4]", 0xedd0, 0x0a01, 4, 2),
    ("vstr s1, [r0, #4]", 0xedc0, 0x0a01, 4, 2),
    ("vldr d1, [r0, #4]", 0xed90, 0x1b01, 4, 3),
    ("vstr d1, [r0, #4]", 0xed80, 0x1b01, 4, 3),
    ("vldmia r0, {s0, s1, s2}", 0xec90, 0x0a03, 4, 4),
    ("vstmia r0!, {s0, s1, s2, s3}", 0xeca0, 0x0a04, 4, 5),
    ("vpush {d8, d9}", 0xed2d, 0x8b04, 4, 5),
    ("vpop {d8, d9}", 0xecbd, 0x8b04, 4, 5),
    ("vldmdb r0!, {s4, s5}", 0xed30, 0x2a02, 4, 3),
];

#[test]
fn every_encoding_has_its_length_and_its_cycles() {
    for (assembly, first, second, length, cycles) in ENCODINGS {
        let instruction = Instruction::new(*first, *second);
        assert_eq!((instruction.length(), instruction.cycles()), (*length, *cycles), "{assembly}");
    }
}

#[test]
fn no_encoding_costs_more_than_the_longest_transfer() {
    for first in 0..=u16::MAX {
        for second in [0, 0x0a00, 0x0b10, 0xf0f0, 0xffff] {
            assert!((1..=256).contains(&Instruction::new(first, second).cycles()), "{first:#x} {second:#x}");
        }
    }
}

/// The encoding of `assembly` in the table.
fn encoding(assembly: &str) -> Instruction {
    let found = ENCODINGS.iter().find(|row| row.0 == assembly).expect("an encoding of the table");
    Instruction::new(found.1, found.2)
}

#[test]
fn a_float_result_is_late_for_the_next_instruction_that_wants_it() {
    let add = encoding("vadd.f32 s0, s1, s2");
    let root = encoding("vsqrt.f32 s0, s1");
    let (wants_s0, makes_s0) = (encoding("vcmp.f32 s0, s1"), encoding("vabs.f32 s0, s1"));
    assert_eq!(wants_s0.wait_for(add), 1);
    assert_eq!(wants_s0.wait_for(root), 1);
    assert_eq!(encoding("vmla.f32 s0, s1, s2").wait_for(add), 1, "accumulates into s0");
    assert_eq!(encoding("vmov r1, s0").wait_for(add), 1);
    assert_eq!(encoding("vstmia r0!, {s0, s1, s2, s3}").wait_for(add), 1);
    assert_eq!(makes_s0.wait_for(add), 0, "s0 is only written");
    assert_eq!(encoding("vstr s1, [r0, #4]").wait_for(add), 0, "another register");
    assert_eq!(encoding("vldmia r0, {s0, s1, s2}").wait_for(add), 0, "a load reads none");
    assert_eq!(encoding("nop").wait_for(add), 0);
    assert_eq!(add.wait_for(encoding("vldr s1, [r0, #4]")), 0, "a load is no arithmetic");
    assert_eq!(makes_s0.wait_for(wants_s0), 0, "a comparison leaves flags");
}

#[test]
fn loads_are_told_from_stores_and_counted_by_words() {
    for (words, names) in [
        (1, ["ldr r0, [pc, #8]", "ldrsh r0, [r1, r2]", "ldrb r0, [r1, #4]", "ldr r0, [sp, #4]"].as_slice()),
        (
            0,
            &[
                "str r0, [r1, r2]",
                "strh r0, [r1, #4]",
                "push {r4, r5, r7, lr}",
                "push.w {r4, r5, r6, r7, r8, lr}",
            ],
        ),
        (0, &["adds r0, r1, r2", "uxth r0, r1", "bl .", "mrs r0, PRIMASK", "clrex", "ubfx r0, r1, #3, #4"]),
        (2, &["ldm r0!, {r1, r2}"]),
        (3, &["pop {r4, r7, pc}"]),
    ] {
        for name in names {
            let (_, first, second, ..) =
                ENCODINGS.iter().find(|(assembly, ..)| assembly == name).expect(name);
            assert_eq!(Instruction::new(*first, *second).loads(), words, "{name}");
        }
    }
    // A load takes a cycle and one a word. Hints to preload count as loads.
    for (name, first, second, _, cycles) in ENCODINGS {
        let instruction = Instruction::new(*first, *second);
        let mnemonic = name.split([' ', '.']).next().unwrap();
        let loads = [
            "vldmdb", "ldr", "ldrb", "ldrh", "ldrsb", "ldrsh", "ldm", "ldmia", "ldmdb", "pop", "ldrd",
            "vldr", "vldm", "vldmia", "vpop",
        ];
        assert_eq!(
            instruction.loads() > 0,
            loads.contains(&mnemonic) || ["ldrex", "tb", "pl"].iter().any(|hint| name.starts_with(hint)),
            "{name}"
        );
        if loads.contains(&mnemonic) {
            assert_eq!(instruction.loads() + 1, *cycles, "{name}");
        }
    }
}
