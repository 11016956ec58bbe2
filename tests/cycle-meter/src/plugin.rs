//! The door to QEMU: the plugin interface, version 1 (QEMU 7.2, `include/qemu/qemu-plugin.h`), as far as it
//! is used.
//!
//! In: blocks as QEMU translates and runs them. Out: the report, at exit. Debian ships no header, so the
//! interface is declared here; its functions are found in the emulator's own executable when it loads the
//! plugin.
//!
//! A block is summed once, when it is translated, and only its record is added up when it runs.
#![allow(unsafe_code)]

use crate::{
    block::Block,
    count::Counter,
    image::{Image, Mark},
    report,
};
use std::{
    ffi::{CStr, c_char, c_int, c_uint, c_void},
    path::PathBuf,
    sync::{Mutex, MutexGuard, OnceLock, PoisonError},
};

/// QEMU's opaque translation block.
#[repr(C)]
struct TranslationBlock {
    _opaque: [u8; 0],
}

/// QEMU's opaque instruction.
#[repr(C)]
struct TranslatedInstruction {
    _opaque: [u8; 0],
}

/// `QEMU_PLUGIN_CB_NO_REGS`: the callback touches no registers.
const NO_REGISTERS: c_int = 0;
/// `QEMU_PLUGIN_MEM_RW`: reads and writes. Reads would do, but QEMU 7.2 takes the flag for reads to mean
/// writes; the stage table is never written, so with both the answer is the same in every version.
const READS_AND_WRITES: c_int = 3;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: extern "C" fn(u64, *mut TranslationBlock));
    fn qemu_plugin_register_vcpu_tb_exec_cb(
        block: *mut TranslationBlock,
        callback: extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut TranslatedInstruction,
        callback: extern "C" fn(c_uint, u32, u64, *mut c_void),
        flags: c_int,
        access: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_atexit_cb(id: u64, callback: extern "C" fn(u64, *mut c_void), data: *mut c_void);
    fn qemu_plugin_tb_n_insns(block: *const TranslationBlock) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const TranslationBlock, index: usize) -> *mut TranslatedInstruction;
    fn qemu_plugin_insn_vaddr(instruction: *const TranslatedInstruction) -> u64;
}

/// The interface version this plugin is written for; QEMU reads it before anything else.
#[allow(non_upper_case_globals)]
#[unsafe(no_mangle)]
pub static qemu_plugin_version: c_int = 1;

/// What stays the same for the whole run, and the sums.
struct Meter {
    image: Image,
    out: PathBuf,
    /// Names of the counted functions, by their numbers.
    counted: Vec<String>,
    counter: Mutex<Counter>,
}

static METER: OnceLock<Meter> = OnceLock::new();

impl Meter {
    /// The sums. A poisoned lock is taken all the same: no callback leaves them half-way.
    fn counter(&self) -> MutexGuard<'_, Counter> {
        self.counter.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From the plugin's arguments `elf=IMAGE`, `out=FILE` and, if wanted, `refill=CYCLES` and
    /// `count=FUNCTION+FUNCTION`.
    fn from_arguments(arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let (mut elf, mut out, mut refill_cycles, mut counted) = (None, None, 2, Vec::new());
        for argument in arguments {
            match argument.split_once('=') {
                Some(("elf", path)) => elf = Some(PathBuf::from(path)),
                Some(("out", path)) => out = Some(PathBuf::from(path)),
                Some(("refill", number)) => refill_cycles = number.parse().map_err(|_| argument.clone())?,
                Some(("count", names)) => counted = names.split('+').map(str::to_owned).collect(),
                _ => return Err(format!("unknown argument `{argument}`")),
            }
        }
        let (Some(elf), Some(out)) = (elf, out) else {
            return Err(
                "usage: -plugin libcycle_meter.so,elf=IMAGE,out=FILE[,refill=CYCLES][,count=NAME+NAME]"
                    .to_owned(),
            );
        };
        let bytes = std::fs::read(&elf).map_err(|error| format!("{}: {error}", elf.display()))?;
        let image = Image::parse(&bytes, &counted).map_err(|error| format!("{}: {error}", elf.display()))?;
        Ok(Self { image, out, counted, counter: Mutex::new(Counter::new(refill_cycles)) })
    }
}

/// QEMU's first call: takes the arguments and asks to be told of blocks and of the exit.
///
/// # Safety
/// `arguments` are `count` C strings, as QEMU hands them over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    count: c_int,
    arguments: *const *const c_char,
) -> c_int {
    let strings = (0..usize::try_from(count).unwrap_or(0)).map(|index| {
        // SAFETY: the caller's promise: `count` pointers to C strings.
        unsafe { CStr::from_ptr(*arguments.add(index)) }.to_string_lossy().into_owned()
    });
    let installed = Meter::from_arguments(strings)
        .and_then(|meter| METER.set(meter).map_err(|_| "loaded twice".to_owned()));
    if let Err(error) = installed {
        // QEMU ends with an error of its own, which does not say why.
        eprintln!("cycle-meter: {error}");
        return -1;
    }
    // SAFETY: `id` is ours, and the callbacks have the types the interface asks for and live as long as the
    // library.
    unsafe {
        qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
        qemu_plugin_register_atexit_cb(id, at_exit, std::ptr::null_mut());
    }
    0
}

/// A block was translated: sum it, and ask to be told when it runs.
extern "C" fn translated(_id: u64, block: *mut TranslationBlock) {
    let Some(meter) = METER.get() else { return };
    // SAFETY: QEMU lends the block for the length of this call, and every index is below its number of
    // instructions.
    let instructions: Vec<_> = unsafe {
        (0..qemu_plugin_tb_n_insns(block)).map(|index| qemu_plugin_tb_get_insn(block, index)).collect()
    };
    // SAFETY: the instructions belong to the block and are lent with it.
    let addresses = instructions.iter().map(|instruction| unsafe { qemu_plugin_insn_vaddr(*instruction) });
    // The record must outlive the translation, whose end nobody announces: it is never freed. Code is
    // translated seldom more than once, so that is some hundred bytes a block.
    let record: *mut c_void = Block::new(&meter.image, addresses)
        .map_or(std::ptr::null_mut(), |block| std::ptr::from_mut(Box::leak(Box::new(block))).cast());
    // SAFETY: the block is lent for this call; the callback takes the record for what it is, a leaked `Block`
    // or null.
    unsafe { qemu_plugin_register_vcpu_tb_exec_cb(block, executed, NO_REGISTERS, record) };

    // SAFETY: `record` is null or the leaked block from above.
    let mark = unsafe { record.cast::<Block>().as_ref() }.and_then(|block| block.mark);
    let callback = match mark {
        Some((Mark::StageBegin, _)) => stage_begin_reads,
        Some((Mark::StageEnd, _)) => stage_end_reads,
        _ => return,
    };
    for instruction in instructions {
        // SAFETY: the instruction is lent for this call; the callback has the type the interface asks for.
        unsafe {
            qemu_plugin_register_vcpu_mem_cb(
                instruction,
                callback,
                NO_REGISTERS,
                READS_AND_WRITES,
                std::ptr::null_mut(),
            );
        }
    }
}

/// A block runs; `record` is its leaked [`Block`], or null when it is not in the image.
extern "C" fn executed(_processor: c_uint, record: *mut c_void) {
    let Some(meter) = METER.get() else { return };
    // SAFETY: `translated` registered nothing but null or a block that is never freed nor changed.
    match unsafe { record.cast::<Block>().as_ref() } {
        Some(block) => meter.counter().enter(block),
        None => meter.counter().enter_unknown(),
    }
}

/// `stage_begin` reads memory: its table entry is the stage, all else (its stack) is not.
extern "C" fn stage_begin_reads(_processor: c_uint, _info: u32, address: u64, _data: *mut c_void) {
    let Some(meter) = METER.get() else { return };
    if let Some(stage) = meter.image.stage(address) {
        meter.counter().stage_begin(stage);
    }
}

/// As [`stage_begin_reads`], for the end.
extern "C" fn stage_end_reads(_processor: c_uint, _info: u32, address: u64, _data: *mut c_void) {
    let Some(meter) = METER.get() else { return };
    if let Some(stage) = meter.image.stage(address) {
        meter.counter().stage_end(stage);
    }
}

/// The emulation ends: write the report.
extern "C" fn at_exit(_id: u64, _data: *mut c_void) {
    let Some(meter) = METER.get() else { return };
    let report = report::json(&meter.counter(), &meter.counted);
    if let Err(error) = std::fs::write(&meter.out, report) {
        eprintln!("cycle-meter: {}: {error}", meter.out.display());
    }
}
