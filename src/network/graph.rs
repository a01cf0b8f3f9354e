//! The network as one list of operations, and the sizes of what they make.

/// What an operation computes. Images are `[channel][row][column]`, volumes `[channel][plane][row][column]`. Convolutions
/// are sums of products with a neighbourhood (no flip), beyond the border of their input they read 0, and their output k
/// is centred on input k x `stride`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// Red, green and blue of an image, 0 to 1, minus the mean of [`Padded::MEAN`], divided by
    /// [`Padded::DEVIATION`]; then padded by zeros.
    Input,
    /// A convolution of an image.
    Conv2d {
        /// Sides of the neighbourhood: 1 or 3.
        kernel: usize,
        /// Pixels of the input from one output to the next.
        stride: usize,
        /// Pixels of the input from one tap to the next.
        dilation: usize,
    },
    /// The mean of squares of `side` x `side` that do not overlap, from the top left. Rows and columns that fill no whole
    /// square are left out.
    AveragePool {
        /// Pixels.
        side: usize,
    },
    /// Bilinear interpolation of the first input to the size of the second, of which no value is read.
    Upsample,
    /// The channels of all inputs, one input after the other.
    Concat,
    /// The volume of the features of both sides, then a 3x3x3 convolution of it with stride 1. The volume has twice the
    /// channels of the features; plane i of it is the left features, then the right ones at column x - i. Where x < i all
    /// channels are 0.
    VolumeConv3d,
    /// A 3x3x3 convolution of a volume.
    Conv3d {
        /// Along all three axes.
        stride: usize,
    },
    /// A transposed 3x3x3 convolution with stride 2 to twice the sides: value i of the input, times tap k of 0, 1, 2, is
    /// added to value 2i + k - 1 of the output, along each axis.
    TransposedConv3d,
    /// Of the volume of one channel: trilinear interpolation to four times its sides, softmax over the planes, and the
    /// mean of the planes' numbers weighted by it: the disparity in pixels.
    Regression,
}

/// How large the output of an operation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Extent {
    /// An image: the padded sides, shifted to the right by these bits.
    Image(u32),
    /// An image: a quarter of the padded sides, divided by this number of pixels and rounded down.
    Pooled(usize),
    /// A volume: the padded sides and the number of disparities, shifted to the right by these bits.
    Volume(u32),
}

/// Where an operation's weights are in a published file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameters {
    /// The module of the convolution, which has no bias: `.weight` of it is a tensor.
    pub convolution: String,
    /// The module of the batch normalisation, if there is one: `.weight`, `.bias`, `.running_mean` and `.running_var`.
    pub norm: Option<String>,
}

/// A row of the list of operations.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Operation {
    /// The module's path in published files, such as `feature_extraction.layer2.0.conv1`, or where it stands.
    pub name: String,
    /// What is computed.
    pub kind: Kind,
    /// The operations whose outputs are read: earlier ones of the list, by their numbers.
    pub inputs: Vec<usize>,
    /// The operation whose output, of the same shape, is added to each value.
    pub add: Option<usize>,
    /// Whether negative values become 0, after the addition.
    pub relu: bool,
    /// Channels of the output.
    pub channels: usize,
    /// Size of the output.
    pub extent: Extent,
    /// Whether it is computed for each side, left and right, from outputs of the same side.
    pub both_sides: bool,
    /// The weights of a convolution.
    pub parameters: Option<Parameters>,
}

/// The sizes that the network works on: those of the images and the disparities, padded. Zeros are added **above** and
/// to the **right** of the normalised image, up to the next multiple of 16 and at least to 256.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Padded {
    /// Columns; those from the image's width on are padding.
    pub width: usize,
    /// Rows; the first `height` minus the image's height are padding.
    pub height: usize,
    /// Disparities: a multiple of 16.
    pub disparities: usize,
}

impl Padded {
    /// What is subtracted from red, green and blue between 0 and 1.
    pub const MEAN: [f64; 3] = [0.485, 0.456, 0.406];
    /// What they are divided by.
    pub const DEVIATION: [f64; 3] = [0.229, 0.224, 0.225];
    /// The smallest sides: the largest squares that are averaged have 64 pixels at a quarter of the size.
    pub const SMALLEST: usize = 256;

    /// For images of `width` x `height` pixels.
    pub fn new(width: u32, height: u32, disparities: u32) -> Self {
        let padded = |side: u32| (side as usize).next_multiple_of(16).max(Self::SMALLEST);
        let disparities = (disparities as usize).next_multiple_of(16);
        Self { width: padded(width), height: padded(height), disparities }
    }
}

impl Operation {
    /// The sizes of the output, of one side: channels, planes (1 of an image), rows and columns.
    pub fn shape(&self, padded: &Padded) -> [usize; 4] {
        let Padded { width, height, disparities } = *padded;
        let [planes, rows, columns] = match self.extent {
            Extent::Image(shift) => [1, height >> shift, width >> shift],
            Extent::Pooled(side) => [1, (height >> 2) / side, (width >> 2) / side],
            Extent::Volume(shift) => [disparities >> shift, height >> shift, width >> shift],
        };
        [self.channels, planes, rows, columns]
    }

    /// The number of values of the output, of both sides where it has two.
    pub fn values(&self, padded: &Padded) -> u64 {
        let sides = if self.both_sides { 2 } else { 1 };
        sides * self.shape(padded).into_iter().map(|side| side as u64).product::<u64>()
    }

    /// The shape of the convolution's weights as the definition reads them: outputs, inputs, then taps.
    pub fn weights(&self, operations: &[Self]) -> Option<Vec<usize>> {
        let inputs = operations[*self.inputs.first()?].channels;
        match self.kind {
            Kind::Conv2d { kernel, .. } => Some(vec![self.channels, inputs, kernel, kernel]),
            Kind::VolumeConv3d => Some(vec![self.channels, 2 * inputs, 3, 3, 3]),
            Kind::Conv3d { .. } | Kind::TransposedConv3d => Some(vec![self.channels, inputs, 3, 3, 3]),
            _ => None,
        }
    }

    /// Multiplications with weights, each with an addition, for a pair of images.
    pub fn multiplications(&self, operations: &[Self], padded: &Padded) -> u64 {
        let Some(weights) = self.weights(operations) else { return 0 };
        // The weights are all used once at each place of the output, or of the input if that is the smaller one.
        let [_, planes, rows, columns] = match self.kind {
            Kind::TransposedConv3d => operations[self.inputs[0]].shape(padded),
            _ => self.shape(padded),
        };
        let sides = if self.both_sides { 2 } else { 1 };
        weights.iter().chain(&[sides, planes, rows, columns]).map(|&side| side as u64).product()
    }

    /// What it reads for a side: outputs of operations by their numbers, each of a side.
    pub fn reads(&self, side: usize) -> Vec<(usize, usize)> {
        match self.kind {
            Kind::VolumeConv3d => vec![(self.inputs[0], 0), (self.inputs[0], 1)],
            // Of the second input only the size counts.
            Kind::Upsample => vec![(self.inputs[0], side)],
            _ => self.inputs.iter().map(|&input| (input, side)).collect(),
        }
    }

    /// For each operation the last one that reads its output; itself, if none does.
    pub fn last_reads(operations: &[Self]) -> Vec<usize> {
        let mut last: Vec<usize> = (0..operations.len()).collect();
        for (at, operation) in operations.iter().enumerate() {
            // The second input of `Upsample` only gives a size.
            let read = if operation.kind == Kind::Upsample { &operation.inputs[..1] } else { &operation.inputs[..] };
            read.iter().chain(&operation.add).for_each(|&input| last[input] = at);
        }
        last
    }

    /// The largest number of values that are needed at once, if each output is kept until it was read for the last time.
    pub fn peak(operations: &[Self], padded: &Padded) -> u64 {
        let last = Self::last_reads(operations);
        let mut largest = 0;
        for at in 0..operations.len() {
            let live = (0..=at).filter(|&earlier| last[earlier] >= at);
            largest = largest.max(live.map(|earlier| operations[earlier].values(padded)).sum());
        }
        largest
    }
}

/// The list while it is made.
#[derive(Default)]
struct List(Vec<Operation>);

impl List {
    fn add(&mut self, operation: Operation) -> usize {
        self.0.push(operation);
        self.0.len() - 1
    }

    /// Of each side, without weights.
    fn image(&mut self, name: &str, kind: Kind, inputs: &[usize], channels: usize, extent: Extent) -> usize {
        self.add(Operation {
            name: format!("feature_extraction.{name}"),
            kind,
            inputs: inputs.to_vec(),
            add: None,
            relu: false,
            channels,
            extent,
            both_sides: true,
            parameters: None,
        })
    }

    /// A convolution of each side; `taken`: kernel, stride, dilation.
    fn conv2d(&mut self, name: &str, input: usize, channels: usize, taken: [usize; 3], norm: Norm) -> usize {
        let [kernel, stride, dilation] = taken;
        let extent = match self.0[input].extent {
            Extent::Image(shift) => Extent::Image(shift + stride as u32 - 1),
            other => other,
        };
        let at = self.image(name, Kind::Conv2d { kernel, stride, dilation }, &[input], channels, extent);
        self.0[at].relu = norm == Norm::Relu || norm == Norm::InBlock;
        self.0[at].parameters = Some(norm.parameters(&self.0[at].name));
        at
    }

    /// A convolution of volumes.
    fn conv3d(&mut self, name: &str, kind: Kind, input: usize, channels: usize, norm: Norm) -> usize {
        let extent = match (kind, self.0[input].extent) {
            (Kind::Conv3d { stride: 2 }, Extent::Volume(shift)) => Extent::Volume(shift + 1),
            (Kind::TransposedConv3d, Extent::Volume(shift)) => Extent::Volume(shift - 1),
            (Kind::VolumeConv3d, Extent::Image(shift)) => Extent::Volume(shift),
            (_, extent) => extent,
        };
        self.add(Operation {
            name: name.to_owned(),
            kind,
            inputs: vec![input],
            add: None,
            relu: norm == Norm::Relu || norm == Norm::InBlock,
            channels,
            extent,
            both_sides: false,
            parameters: Some(norm.parameters(name)),
        })
    }

    /// Adds the output of `other` to that of `at`, which is returned.
    fn plus(&mut self, at: usize, other: usize) -> usize {
        self.0[at].add = Some(other);
        at
    }
}

/// What follows a convolution, and with it the names of its modules.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Norm {
    /// Nothing.
    No,
    /// Batch normalisation.
    Plain,
    /// Batch normalisation and ReLU, in the same sequence of modules.
    Relu,
    /// The same, in a sequence of their own.
    InBlock,
}

impl Norm {
    fn parameters(self, name: &str) -> Parameters {
        let (convolution, norm) = match self {
            Self::No => (String::new(), None),
            Self::Plain | Self::Relu => (".0".to_owned(), Some(format!("{name}.1"))),
            Self::InBlock => (".0.0".to_owned(), Some(format!("{name}.0.1"))),
        };
        Parameters { convolution: name.to_owned() + &convolution, norm }
    }
}

/// The features of both sides: 32 channels at a quarter of the sides.
fn features(list: &mut List) -> usize {
    let mut at = list.image("input", Kind::Input, &[], 3, Extent::Image(0));
    for (name, stride) in [("firstconv.0", 2), ("firstconv.2", 1), ("firstconv.4", 1)] {
        at = list.conv2d(name, at, 32, [3, stride, 1], Norm::Relu);
    }
    let mut second = at;
    for (layer, blocks, channels, stride, dilation) in
        [("layer1", 3, 32, 1, 1), ("layer2", 16, 64, 2, 1), ("layer3", 3, 128, 1, 1), ("layer4", 3, 128, 1, 2)]
    {
        for block in 0..blocks {
            let stride = if block == 0 { stride } else { 1 };
            let name = format!("{layer}.{block}");
            // What is added is the block's input; a 1x1 convolution makes it fit where the shape changes.
            let same = stride == 1 && list.0[at].channels == channels;
            let inner = list.conv2d(&format!("{name}.conv1"), at, channels, [3, stride, dilation], Norm::InBlock);
            let residual = match same {
                true => at,
                false => list.conv2d(&format!("{name}.downsample"), at, channels, [1, stride, 1], Norm::Plain),
            };
            let outer = list.conv2d(&format!("{name}.conv2"), inner, channels, [3, 1, dilation], Norm::Plain);
            at = list.plus(outer, residual);
        }
        if layer == "layer2" {
            second = at;
        }
    }
    let mut parts = vec![second, at];
    for (branch, side) in [("branch4", 8), ("branch3", 16), ("branch2", 32), ("branch1", 64)] {
        let pool = Kind::AveragePool { side };
        let pooled = list.image(&format!("{branch}.0"), pool, &[at], 128, Extent::Pooled(side));
        let narrow = list.conv2d(&format!("{branch}.1"), pooled, 32, [1, 1, 1], Norm::Relu);
        parts.push(list.image(branch, Kind::Upsample, &[narrow, at], 32, Extent::Image(2)));
    }
    let joined = list.image("concat", Kind::Concat, &parts, 320, Extent::Image(2));
    let wide = list.conv2d("lastconv.0", joined, 128, [3, 1, 1], Norm::Relu);
    list.conv2d("lastconv.2", wide, 32, [1, 1, 1], Norm::No)
}

const SAME: Kind = Kind::Conv3d { stride: 1 };
const HALF: Kind = Kind::Conv3d { stride: 2 };

/// The volume after `dres0` and `dres1`.
fn volume(list: &mut List) -> usize {
    let features = features(list);
    let first = list.conv3d("dres0.0", Kind::VolumeConv3d, features, 32, Norm::Relu);
    let cost = list.conv3d("dres0.2", SAME, first, 32, Norm::Relu);
    residual(list, "dres1", cost)
}

/// Two convolutions, and the input added.
fn residual(list: &mut List, name: &str, input: usize) -> usize {
    let inner = list.conv3d(&format!("{name}.0"), SAME, input, 32, Norm::Relu);
    let outer = list.conv3d(&format!("{name}.2"), SAME, inner, 32, Norm::Plain);
    list.plus(outer, input)
}

/// One hourglass: its output, with `cost` added, and the two volumes at half the sides, of the way down and of the way
/// up, which later ones add to theirs.
fn hourglass(list: &mut List, name: &str, input: usize, cost: usize, earlier: Option<[usize; 2]>) -> [usize; 3] {
    let name = |part: &str| format!("{name}.{part}");
    let first = list.conv3d(&name("conv1"), HALF, input, 64, Norm::InBlock);
    let mut down = list.conv3d(&name("conv2"), SAME, first, 64, Norm::Plain);
    if let Some([_, up]) = earlier {
        down = list.plus(down, up);
    }
    list.0[down].relu = true;
    let third = list.conv3d(&name("conv3"), HALF, down, 64, Norm::InBlock);
    let fourth = list.conv3d(&name("conv4"), SAME, third, 64, Norm::InBlock);
    let up = list.conv3d(&name("conv5"), Kind::TransposedConv3d, fourth, 64, Norm::Plain);
    let up = list.plus(up, earlier.map_or(down, |[down, _]| down));
    list.0[up].relu = true;
    let out = list.conv3d(&name("conv6"), Kind::TransposedConv3d, up, 32, Norm::Plain);
    [list.plus(out, cost), down, up]
}

/// From a volume of 32 channels to one of a single channel.
fn classify(list: &mut List, name: &str, input: usize) -> usize {
    let inner = list.conv3d(&format!("{name}.0"), SAME, input, 32, Norm::Relu);
    list.conv3d(&format!("{name}.2"), SAME, inner, 1, Norm::No)
}

/// The operations of `stackhourglass`.
pub(super) fn stack_hourglass() -> Vec<Operation> {
    let mut list = List::default();
    let cost = volume(&mut list);
    let [out1, down, up1] = hourglass(&mut list, "dres2", cost, cost, None);
    let [out2, _, up2] = hourglass(&mut list, "dres3", out1, cost, Some([down, up1]));
    let [out3, _, _] = hourglass(&mut list, "dres4", out2, cost, Some([down, up2]));
    let mut scores = classify(&mut list, "classif1", out1);
    for (name, out) in [("classif2", out2), ("classif3", out3)] {
        let next = classify(&mut list, name, out);
        scores = list.plus(next, scores);
    }
    regressed(list, scores)
}

/// The operations of `basic`.
pub(super) fn basic() -> Vec<Operation> {
    let mut list = List::default();
    let mut cost = volume(&mut list);
    for name in ["dres2", "dres3", "dres4"] {
        cost = residual(&mut list, name, cost);
    }
    let scores = classify(&mut list, "classify", cost);
    regressed(list, scores)
}

/// The whole list: the disparities last.
fn regressed(mut list: List, scores: usize) -> Vec<Operation> {
    list.add(Operation {
        name: "disparity_regression".to_owned(),
        kind: Kind::Regression,
        inputs: vec![scores],
        add: None,
        relu: false,
        channels: 1,
        extent: Extent::Image(0),
        both_sides: false,
        parameters: None,
    });
    list.0
}
