#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| gpu_stereo_fuzz::list(data, gpu_stereo::files::lists::Kind::Csv));
