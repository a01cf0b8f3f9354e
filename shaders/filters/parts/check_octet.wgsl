// check_octet: four words of a map, eight pixels of a row from column x on, each as the kernel's `check(value, x, row)` leaves it.

fn check_word(word: u32, x: i32, row: u32) -> u32 {
    return map_word(check(map_value(word, 0u), x, row), check(map_value(word, 1u), x + 1, row));
}

fn check_octet(words: vec4<u32>, x: i32, row: u32) -> vec4<u32> {
    return vec4(check_word(words.x, x, row), check_word(words.y, x + 2, row),
        check_word(words.z, x + 4, row), check_word(words.w, x + 6, row));
}
