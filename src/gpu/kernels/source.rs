//! The whole text of a specialised kernel.

use super::constants::constants;
use super::table::{Choice, Kernel};
use crate::PixelFormat;
use crate::gpu::plan::{Exchange, Plan};
use crate::params::Params;

/// How invocations without a line of their own leave a kernel that walks lines.
const EARLY_RETURN: &str = "    if !works {\n        return;\n    }\n";

/// The whole text of a specialised kernel.
pub(crate) fn source(kernel: &Kernel, params: &Params, format: PixelFormat, plan: &Plan) -> String {
    let fragments = kernel.fragments(params, plan);
    let text = format!("{}\n{}\n", fragments.join("\n"), constants(kernel, &fragments, params, format, plan));
    // A barrier is for all invocations of a workgroup: there they walk the last line once more, and write nothing.
    let barriers = plan.exchange == Exchange::Workgroup && kernel.choices.contains(&Choice::SharedPath);
    let text = if barriers { text.replacen(EARLY_RETURN, "", 1) } else { text };
    #[cfg(test)]
    let text = crate::gpu::edits::edited(kernel.name, text);
    text
}
