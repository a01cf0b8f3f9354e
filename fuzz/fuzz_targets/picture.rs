#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| gpu_stereo_fuzz::map(
    &[b"\x89PNG\r\n\x1a\n", b"P1", b"P2", b"P3", b"P4", b"P5", b"P6", b"P7"],
    data
));
