// Appended to the kernels that send messages: the smoothness is the same for all differences, and what values are cut off at.

fn smoothed(values: ptr<function, Costs>, weight: u32) {
}
