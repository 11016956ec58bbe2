//! What a Thumb-2 instruction costs on a Cortex-M4F.
//!
//! In: an instruction's two halfwords (the second is not looked at for a 16-bit one). Out: its length, its
//! cycles without pipeline refill, and which floating-point register it makes late or wants early. Source:
//! Cortex-M4 Technical Reference Manual (Arm 100166), tables 3-1 and 7-1; encodings: ARMv7-M Architecture
//! Reference Manual, chapter A5.
//!
//! | class | cycles |
//! |---|---|
//! | data processing, multiply, multiply-accumulate, branch not taken, IT, hint | 1 |
//! | single load or store, exclusive access, table branch, special register, CPS | 2 |
//! | N registers loaded or stored (LDM, STM, PUSH, POP, LDRD, STRD, VLDM, VSTM, VPUSH, VPOP, 64-bit VLDR, VSTR) | 1 + N |
//! | SDIV, UDIV | 12 |
//! | DSB, DMB, ISB | 4 |
//! | VADD, VSUB, VMUL, VCVT, VCMP, VMOV and the like | 1 |
//! | VMOV of two core registers, VLDR, VSTR | 2 |
//! | VMLA, VMLS, VNMLA, VNMLS, VFMA, VFMS, VFNMA, VFNMS | 3 |
//! | VDIV, VSQRT | 14 |

/// Longest integer division (the manual: 2 to 12, by the operands).
const DIVIDE: u32 = 12;
/// Barriers: 1 + B, where B is at least a pipeline refill for ISB.
const BARRIER: u32 = 4;
/// Floating-point division and square root.
const FLOAT_DIVIDE: u32 = 14;
/// Floating-point multiply-accumulate, chained or fused.
const FLOAT_ACCUMULATE: u32 = 3;

/// An instruction's halfwords, in the order they lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    first: u16,
    second: u16,
}

/// Bits `high..=low` of a halfword.
const fn bits(halfword: u16, high: u32, low: u32) -> u16 {
    (halfword >> low) & ((1 << (high - low + 1)) - 1)
}

impl Instruction {
    /// From its halfwords; `second` is whatever follows when the first is a whole instruction.
    pub const fn new(first: u16, second: u16) -> Self {
        Self { first, second }
    }

    /// Length in bytes, 2 or 4: decided by the first halfword alone.
    pub const fn length(self) -> u32 {
        if bits(self.first, 15, 11) >= 0b11101 { 4 } else { 2 }
    }

    /// Cycles, without the pipeline refill of a branch that is taken.
    pub const fn cycles(self) -> u32 {
        if self.length() == 2 { short_cycles(self.first) } else { long_cycles(self.first, self.second) }
    }

    /// Whether it calls a function: BL, or BLX of a register.
    pub const fn is_call(self) -> bool {
        if self.length() == 2 {
            bits(self.first, 15, 7) == 0x8f
        } else {
            bits(self.first, 15, 11) == 0b11110
                && bits(self.second, 15, 14) == 0b11
                && bits(self.second, 12, 12) == 1
        }
    }

    /// Words that it loads from memory; a part of a word counts whole.
    pub const fn loads(self) -> u32 {
        if self.length() == 2 { short_loads(self.first) } else { long_loads(self.first, self.second) }
    }

    /// Cycles this instruction waits for `previous`, the one before it: 1 when it wants the result of
    /// floating-point arithmetic, else 0.
    pub fn wait_for(self, previous: Self) -> u32 {
        let late = previous.float_result();
        u32::from(late.is_some_and(|register| self.wants_float(register)))
    }

    /// Whether this is a floating-point instruction (coprocessor 10 or 11).
    const fn is_float(self) -> bool {
        self.length() == 4 && bits(self.first, 15, 10) == 0b111011 && bits(self.second, 11, 9) == 0b101
    }

    /// Whether this is floating-point arithmetic (as opposed to a transfer).
    const fn is_float_arithmetic(self) -> bool {
        self.is_float() && bits(self.first, 9, 8) == 0b10 && bits(self.second, 4, 4) == 0
    }

    /// The single-precision register that arithmetic leaves its result in.
    fn float_result(self) -> Option<u16> {
        (self.is_float_arithmetic() && !self.is_comparison()).then(|| self.destination())
    }

    /// Whether this reads the single-precision `register`.
    fn wants_float(self, register: u16) -> bool {
        let [destination, left, right] = [self.destination(), self.left(), self.right()];
        match bits(self.first, 9, 8) {
            _ if !self.is_float() => false,
            // VMOV of a core register, from or to the register that stands where the left operand does.
            0b10 if bits(self.second, 4, 4) == 1 => register == left,
            0b10 if self.is_accumulation() || self.is_comparison() => {
                [destination, left, right].contains(&register)
            }
            0b10 if self.is_unary() => register == right,
            0b10 => [left, right].contains(&register),
            _ if moves_two_core_registers(self.first) => (right..right + 2).contains(&register),
            _ if bits(self.first, 4, 4) == 1 => false,
            _ => (destination..destination + float_words(self.first, self.second) as u16).contains(&register),
        }
    }

    /// Whether this floating-point arithmetic adds to its destination.
    const fn is_accumulation(self) -> bool {
        accumulates(bits(self.first, 7, 7), bits(self.first, 5, 4))
    }

    /// Whether this floating-point arithmetic has one operand (or none: VMOV of a constant).
    const fn is_unary(self) -> bool {
        bits(self.first, 7, 7) == 1 && bits(self.first, 5, 4) == 0b11
    }

    /// VCMP: its result is in the flags, and its destination field an operand.
    const fn is_comparison(self) -> bool {
        self.is_unary() && bits(self.first, 3, 1) == 0b010 && bits(self.second, 6, 6) == 1
    }

    /// Single-precision register in the destination field.
    const fn destination(self) -> u16 {
        single(bits(self.second, 15, 12), bits(self.first, 6, 6))
    }

    /// Single-precision register in the left operand's field.
    const fn left(self) -> u16 {
        single(bits(self.first, 3, 0), bits(self.second, 7, 7))
    }

    /// Single-precision register in the right operand's field.
    const fn right(self) -> u16 {
        single(bits(self.second, 3, 0), bits(self.second, 5, 5))
    }
}

/// Number of a single-precision register from its four high bits and its lowest.
const fn single(high: u16, low: u16) -> u16 {
    high << 1 | low
}

/// Cycles of a 16-bit instruction.
const fn short_cycles(word: u16) -> u32 {
    match bits(word, 15, 11) {
        // LDR (literal); load and store with register, immediate and stack pointer offset.
        0b01001..=0b10011 => 2,
        0b10110 | 0b10111 => match bits(word, 11, 8) {
            // PUSH {.., LR}, POP {.., PC}: nine registers may be listed.
            0b0100 | 0b0101 | 0b1100 | 0b1101 => 1 + bits(word, 8, 0).count_ones(),
            // CPS: 1 or 2.
            0b0110 if bits(word, 7, 5) == 0b011 => 2,
            _ => 1,
        },
        // STM, LDM.
        0b11000 | 0b11001 => 1 + bits(word, 7, 0).count_ones(),
        _ => 1,
    }
}

/// Words that a 16-bit instruction loads.
const fn short_loads(word: u16) -> u32 {
    match bits(word, 15, 11) {
        // LDR (literal); with immediate and stack pointer offset: LDR, LDRB, LDRH, LDR.
        0b01001 | 0b01101 | 0b01111 | 0b10001 | 0b10011 => 1,
        // With register offset: after STR, STRH, STRB.
        0b01010 | 0b01011 => (bits(word, 11, 9) >= 3) as u32,
        // POP {.., PC}.
        0b10111 if bits(word, 11, 9) == 0b110 => bits(word, 8, 0).count_ones(),
        // LDM.
        0b11001 => bits(word, 7, 0).count_ones(),
        _ => 0,
    }
}

/// Words that a 32-bit instruction loads: bit 4 of the first halfword is set in all loads.
const fn long_loads(first: u16, second: u16) -> u32 {
    if bits(first, 4, 4) == 0 {
        return 0;
    }
    if bits(first, 10, 10) == 1 && bits(first, 12, 11) != 0b10 {
        let transfers = bits(first, 9, 8) != 0b10 && !moves_two_core_registers(first);
        return if transfers { float_words(first, second) } else { 0 };
    }
    match bits(first, 12, 11) {
        0b01 if bits(first, 9, 9) == 1 => 0,
        0b01 if bits(first, 6, 6) == 0 => second.count_ones(),
        // Of two registers, else exclusive or a table branch.
        0b01 => double_cycles(first) - 1,
        0b11 if bits(first, 9, 7) <= 0b011 => 1,
        _ => 0,
    }
}

/// Cycles of a 32-bit instruction.
const fn long_cycles(first: u16, second: u16) -> u32 {
    // The coprocessor space; on this core it is the floating-point unit.
    if bits(first, 10, 10) == 1 && bits(first, 12, 11) != 0b10 {
        return float_cycles(first, second);
    }
    match bits(first, 12, 11) {
        0b01 if bits(first, 9, 9) == 1 => 1,
        0b01 if bits(first, 6, 6) == 0 => 1 + second.count_ones(),
        0b01 => double_cycles(first),
        0b10 => control_cycles(first, second),
        _ => match bits(first, 9, 7) {
            // Single loads and stores, and hints to preload.
            0b000..=0b011 => 2,
            // Long multiplication and division.
            0b111 if bits(first, 4, 4) == 1 && bits(first, 6, 6) == 0 && bits(second, 7, 4) == 0b1111 => {
                DIVIDE
            }
            _ => 1,
        },
    }
}

/// Load and store of two registers (with a pre-index or write-back); else exclusive access and table branch.
const fn double_cycles(first: u16) -> u32 {
    if bits(first, 8, 8) == 1 || bits(first, 5, 5) == 1 { 3 } else { 2 }
}

/// Branches, special registers, barriers, and data processing with an immediate.
const fn control_cycles(first: u16, second: u16) -> u32 {
    let control = bits(second, 15, 15) == 1 && bits(second, 14, 14) == 0 && bits(second, 12, 12) == 0;
    match bits(first, 10, 4) {
        _ if !control => 1,
        // MSR, MRS: 1 or 2.
        0b0111000 | 0b0111001 | 0b0111110 | 0b0111111 => 2,
        // CPS.W is not in ARMv7-M; 0b0111010 holds the other hints. DSB, DMB, ISB: 4, 5, 6; CLREX (2)
        // takes 1.
        0b0111011 if bits(second, 7, 4) >= 4 => BARRIER,
        _ => 1,
    }
}

/// The floating-point unit.
const fn float_cycles(first: u16, second: u16) -> u32 {
    if bits(first, 9, 8) != 0b10 {
        return if moves_two_core_registers(first) { 2 } else { 1 + float_words(first, second) };
    }
    if bits(second, 4, 4) == 1 {
        // VMOV to or from a core register, VMRS, VMSR.
        return 1;
    }
    match (bits(first, 7, 7), bits(first, 5, 4)) {
        (high, low) if accumulates(high, low) => FLOAT_ACCUMULATE,
        (1, 0b00) => FLOAT_DIVIDE,
        (1, 0b11) if bits(first, 3, 0) == 1 && bits(second, 7, 6) == 0b11 => FLOAT_DIVIDE,
        _ => 1,
    }
}

/// Whether the operation bits of floating-point arithmetic are those of the multiply-accumulate family.
const fn accumulates(high: u16, low: u16) -> bool {
    matches!((high, low), (0, 0b00 | 0b01) | (1, 0b01 | 0b10))
}

/// Whether a floating-point transfer is VMOV of two core registers.
const fn moves_two_core_registers(first: u16) -> bool {
    bits(first, 9, 5) == 0b00010
}

/// Words a floating-point load or store moves.
const fn float_words(first: u16, second: u16) -> u32 {
    let single_register = bits(first, 8, 8) == 1 && bits(first, 5, 5) == 0;
    let double = bits(second, 8, 8) == 1;
    match (single_register, double) {
        (true, false) => 1,
        (true, true) => 2,
        (false, _) => bits(second, 7, 0) as u32,
    }
}

#[cfg(test)]
mod tests;
