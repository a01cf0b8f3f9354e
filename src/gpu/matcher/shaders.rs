//! The text of the kernels that a matcher runs.

use std::collections::HashMap;

use crate::gpu::matcher::stereo_matcher::StereoMatcher;

impl StereoMatcher {
    /// The WGSL of every kernel that a match runs, in the order in which they run first, each with its name: that of the kernel,
    /// and `NAME.2`, `NAME.3` .. where one kernel runs with several texts, as in the rounds of mutual information. Each text is
    /// valid alone and has one entry point, `main`. What it is bound to is in CONTRIBUTING.md.
    #[must_use]
    pub fn shaders(&self) -> Vec<(String, &str)> {
        let mut texts: HashMap<&str, Vec<&str>> = HashMap::new();
        let mut shaders = Vec::new();
        for (name, text) in self.steps.iter().map(|step| step.shader()) {
            let known = texts.entry(name).or_default();
            if known.contains(&text) {
                continue;
            }
            known.push(text);
            let name = if known.len() == 1 { name.to_string() } else { format!("{name}.{}", known.len()) };
            shaders.push((name, text));
        }
        shaders
    }
}
