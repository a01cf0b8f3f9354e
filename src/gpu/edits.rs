//! A test's changes to the text of shaders, for the matchers that its thread makes.

use std::cell::RefCell;

/// From the name of a kernel and its text to the text that is compiled.
type Edit = Box<dyn Fn(&str, String) -> String>;

thread_local! {
    static EDIT: RefCell<Option<Edit>> = const { RefCell::new(None) };
}

/// The text of a kernel with the test's changes.
pub(crate) fn edited(name: &str, text: String) -> String {
    EDIT.with_borrow(|edit| match edit {
        Some(edit) => edit(name, text),
        None => text,
    })
}

/// Does work while `edit` changes the text of the shaders that it compiles.
pub(crate) fn with_edit<T>(edit: impl Fn(&str, String) -> String + 'static, work: impl FnOnce() -> T) -> T {
    EDIT.set(Some(Box::new(edit)));
    let result = work();
    EDIT.set(None);
    result
}

/// [`with_edit`] that writes `to` for `from` in the text of one kernel.
pub(crate) fn with_mutant<T>([kernel, from, to]: [&'static str; 3], work: impl FnOnce() -> T) -> T {
    with_edit(move |name, text| if name == kernel { text.replace(from, to) } else { text }, work)
}
