//! What a Thumb-2 instruction does to the stack pointer, and where it calls.
//!
//! In: an instruction's address and its two halfwords. Out: [`Effect`]. Encodings: ARMv7-M Architecture
//! Reference Manual, chapters A5 and A7.

/// What an instruction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing that counts here.
    None,
    /// It lowers the stack pointer by so many bytes.
    Lowers(u32),
    /// It lowers the stack pointer by a length that only running it tells.
    LowersUnknown,
    /// It calls or jumps to this address.
    To(u64),
    /// It calls the address in a register, or jumps to it and is no return.
    ToUnknown,
    /// It sets the program counter from a register, as the tables of a `match` do.
    ComputedJump,
}

/// Number of the stack pointer.
const SP: u16 = 13;
/// Number of the link register.
const LR: u16 = 14;

/// Bits `high..=low` of a halfword.
const fn bits(halfword: u16, high: u32, low: u32) -> u16 {
    (halfword >> low) & ((1 << (high - low + 1)) - 1)
}

/// The lowest `width` bits as a signed number.
const fn signed(value: u32, width: u32) -> i64 {
    ((value << (32 - width)) as i32 >> (32 - width)) as i64
}

/// Length of an instruction in bytes, 2 or 4: its first halfword decides.
pub const fn length(first: u16) -> u64 {
    if bits(first, 15, 11) >= 0b11101 { 4 } else { 2 }
}

/// What the instruction at `address` does; `second` is not looked at for a 16-bit one.
pub fn effect(address: u64, first: u16, second: u16) -> Effect {
    if length(first) == 2 { short(address, first) } else { long(address, first, second) }
}

/// The address that a branch at `address` reaches over `offset` bytes: the counter is 4 ahead.
fn target(address: u64, offset: i64) -> Effect {
    Effect::To(address.wrapping_add_signed(offset + 4))
}

fn short(address: u64, first: u16) -> Effect {
    let register = bits(first, 6, 3);
    match first >> 8 {
        // PUSH, LR in bit 8.
        0xb4 | 0xb5 => Effect::Lowers(4 * bits(first, 8, 0).count_ones()),
        // SUB SP, #imm7.
        0xb0 if bits(first, 7, 7) == 1 => Effect::Lowers(4 * u32::from(bits(first, 6, 0))),
        // BLX register; BX register, a return where it is the link register.
        0x47 if bits(first, 7, 7) == 1 => Effect::ToUnknown,
        0x47 if register == LR => Effect::None,
        0x47 => Effect::ToUnknown,
        // MOV PC, register; ADD PC, register.
        0x46 | 0x44 if bits(first, 7, 7) == 1 && bits(first, 2, 0) == 7 => Effect::ComputedJump,
        // B, conditional (SVC and UDF have the last two conditions); unconditional.
        0xd0..=0xdd => target(address, 2 * signed(u32::from(bits(first, 7, 0)), 8)),
        0xe0..=0xe7 => target(address, 2 * signed(u32::from(bits(first, 10, 0)), 11)),
        _ => Effect::None,
    }
}

fn long(address: u64, first: u16, second: u16) -> Effect {
    match first {
        // STMDB SP!, {..}: PUSH.W.
        0xe92d => Effect::Lowers(4 * second.count_ones()),
        // VSTMDB SP!, {..}: the last byte counts words. Bit 6 of the first halfword is part of a register.
        _ if first & 0xffbf == 0xed2d && matches!(bits(second, 11, 8), 0b1010 | 0b1011) => {
            Effect::Lowers(4 * u32::from(bits(second, 7, 0)))
        }
        // STR register, [SP, #-imm8]!
        0xf84d if bits(second, 11, 8) == 0b1101 => Effect::Lowers(u32::from(bits(second, 7, 0))),
        // STRD register, register, [SP, #-imm8]!
        0xe96d => Effect::Lowers(4 * u32::from(bits(second, 7, 0))),
        // SUBW SP, SP, #imm12 and SUB.W SP, SP, #constant.
        0xf2ad | 0xf6ad if bits(second, 11, 8) == SP => Effect::Lowers(immediate(first, second)),
        0xf1ad | 0xf5ad | 0xf1bd | 0xf5bd if bits(second, 11, 8) == SP => {
            Effect::Lowers(expanded(immediate(first, second)))
        }
        // SUB.W SP, register, register.
        _ if first & 0xffe0 == 0xeba0 && bits(second, 11, 8) == SP => Effect::LowersUnknown,
        _ if bits(first, 15, 11) == 0b11110 && bits(second, 15, 15) == 1 => branch(address, first, second),
        _ => Effect::None,
    }
}

/// The constant `i:imm3:imm8` of a data-processing instruction.
fn immediate(first: u16, second: u16) -> u32 {
    u32::from(bits(first, 10, 10)) << 11
        | u32::from(bits(second, 14, 12)) << 8
        | u32::from(bits(second, 7, 0))
}

/// The value of a modified constant (ThumbExpandImm).
fn expanded(constant: u32) -> u32 {
    let byte = constant & 0xff;
    match constant >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (0x80 | byte & 0x7f).rotate_right(constant >> 7),
    }
}

/// BL, B.W and the conditional B.W; special registers and hints stand among the latter.
fn branch(address: u64, first: u16, second: u16) -> Effect {
    let sign = u32::from(bits(first, 10, 10));
    let (j1, j2) = (u32::from(bits(second, 13, 13)), u32::from(bits(second, 11, 11)));
    if bits(second, 12, 12) == 1 || bits(second, 14, 14) == 1 {
        let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
        let high = sign << 23 | i1 << 22 | i2 << 21 | u32::from(bits(first, 9, 0)) << 11;
        return target(address, 2 * signed(high | u32::from(bits(second, 10, 0)), 24));
    }
    if bits(first, 9, 7) == 0b111 {
        return Effect::None;
    }
    let high = sign << 19 | j2 << 18 | j1 << 17 | u32::from(bits(first, 5, 0)) << 11;
    target(address, 2 * signed(high | u32::from(bits(second, 10, 0)), 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Assembly, halfwords (from LLVM's assembler), effect at address 0x1000.
    const EFFECTS: &[(&str, u16, u16, Effect)] = &[
        ("push {r4, r5, r7, lr}", 0xb5b0, 0, Effect::Lowers(16)),
        ("push {r7, lr}", 0xb580, 0, Effect::Lowers(8)),
        ("pop {r4, r7, pc}", 0xbd90, 0, Effect::None),
        ("sub sp, #16", 0xb084, 0, Effect::Lowers(16)),
        ("add sp, #16", 0xb004, 0, Effect::None),
        ("push.w {r4, r5, r6, r7, r8, lr}", 0xe92d, 0x41f0, Effect::Lowers(24)),
        ("vpush {d8, d9}", 0xed2d, 0x8b04, Effect::Lowers(16)),
        ("vpush {s16}", 0xed2d, 0x8a01, Effect::Lowers(4)),
        ("str r11, [sp, #-4]!", 0xf84d, 0xbd04, Effect::Lowers(4)),
        ("str r0, [sp, #8]", 0x9002, 0, Effect::None),
        ("sub.w sp, sp, #512", 0xf5ad, 0x7d00, Effect::Lowers(512)),
        ("sub.w sp, sp, #4352", 0xf5ad, 0x5d88, Effect::Lowers(4352)),
        ("subw sp, sp, #1060", 0xf2ad, 0x4d24, Effect::Lowers(1060)),
        ("sub.w sp, sp, r4", 0xebad, 0x0d04, Effect::LowersUnknown),
        ("sub.w r4, sp, #24", 0xf1ad, 0x0418, Effect::None),
        ("bx lr", 0x4770, 0, Effect::None),
        ("bx r3", 0x4718, 0, Effect::ToUnknown),
        ("blx r3", 0x4798, 0, Effect::ToUnknown),
        ("mov pc, r6", 0x46b7, 0, Effect::ComputedJump),
        ("b .", 0xe7fe, 0, Effect::To(0x1000)),
        ("b #+0x20 ahead of the counter", 0xe010, 0, Effect::To(0x1024)),
        ("beq .", 0xd0fe, 0, Effect::To(0x1000)),
        ("udf #0", 0xde00, 0, Effect::None),
        ("bl .", 0xf7ff, 0xfffe, Effect::To(0x1000)),
        ("bl .+4", 0xf000, 0xf800, Effect::To(0x1004)),
        ("b.w .+4", 0xf000, 0xb800, Effect::To(0x1004)),
        ("b.w .-0x1000", 0xf7fe, 0xbffe, Effect::To(0)),
        ("beq.w .+4", 0xf000, 0x8000, Effect::To(0x1004)),
        ("dsb", 0xf3bf, 0x8f4f, Effect::None),
        ("mrs r0, PRIMASK", 0xf3ef, 0x8010, Effect::None),
    ];

    #[test]
    fn effects_are_those_of_the_manual() {
        for (assembly, first, second, expected) in EFFECTS {
            assert_eq!(effect(0x1000, *first, *second), *expected, "{assembly}");
        }
    }

    #[test]
    fn modified_constants_are_expanded() {
        assert_eq!(expanded(0x0ab), 0xab);
        assert_eq!(expanded(0x1ab), 0x00ab_00ab);
        assert_eq!(expanded(0x2ab), 0xab00_ab00);
        assert_eq!(expanded(0x3ab), 0xabab_abab);
        assert_eq!(expanded(0xf80), 0x100);
    }
}
