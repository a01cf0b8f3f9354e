//! What is made on the device, by wgpu's own log: of one thread, since a program has one logger.

use std::cell::RefCell;

thread_local! {
    /// The calls that were logged, if anyone asked.
    static MADE: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

struct Log;

impl log::Log for Log {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.target().starts_with("wgpu_core") && MADE.with_borrow(Option::is_some)
    }

    fn log(&self, record: &log::Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        let call = text.split(|c: char| c != ':' && c != '_' && !c.is_ascii_alphanumeric()).next().unwrap_or_default();
        if call.starts_with("Device::create_") || call.starts_with("Texture::create_") {
            MADE.with_borrow_mut(|made| made.iter_mut().for_each(|made| made.push(call.into())));
        }
    }

    fn flush(&self) {}
}

/// The calls by which something is made while `work` runs.
pub(super) fn during(work: impl FnOnce()) -> Vec<String> {
    // Another test may have set it before.
    let _ = log::set_logger(&Log);
    log::set_max_level(log::LevelFilter::Trace);
    MADE.set(Some(Vec::new()));
    work();
    MADE.take().unwrap_or_default()
}
