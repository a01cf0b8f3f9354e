// metal_stdlib has all that is used.
