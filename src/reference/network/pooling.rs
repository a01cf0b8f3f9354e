use crate::reference::Values;

/// Stage `average_pool`: the mean of each square of `side` x `side`, from the top left; rows and columns that fill no whole
/// square are left out.
pub fn average_pool(input: &Values, side: usize) -> Values {
    let [channels, _, rows, columns] = input.shape;
    let mut output = Values::new([channels, 1, rows / side, columns / side]);
    let [_, _, rows, columns] = output.shape;
    for (i, mean) in output.data.iter_mut().enumerate() {
        let (channel, y, x) = (i / columns / rows, i / columns % rows, i % columns);
        let square = (y * side..(y + 1) * side).flat_map(|row| &input.row(channel, 0, row)[x * side..(x + 1) * side]);
        *mean = square.sum::<f64>() / (side * side) as f64;
    }
    output
}
