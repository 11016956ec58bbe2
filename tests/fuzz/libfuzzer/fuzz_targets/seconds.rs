#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzz::seconds::try_bytes(bytes);
});
