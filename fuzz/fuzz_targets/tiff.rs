#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| gpu_stereo_fuzz::map(&[b"II*\0", b"MM\0*", b"II+\0"], data));
