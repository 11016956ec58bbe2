#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::packets::try_bytes(bytes));
