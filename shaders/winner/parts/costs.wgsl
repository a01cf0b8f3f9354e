// Appended to the kernels that hold a value for each disparity of a pixel: four a vector, sixteen an entry.
alias Costs = array<array<vec4<u32>, 4>, OWN_QUADS>;
