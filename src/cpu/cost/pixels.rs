//! The costs of pixels: every kind of cost, for a piece of a row.

use std::ops::Range;

use fearless_simd::Simd;

use crate::cpu::LANES;
use crate::cpu::cost::angles::Angles;
use crate::cpu::cost::compare::{
    Bits, BitsAndGradients, BitsAndValue, ColourDifferences, Compare, Differences, Intervals, Products, Squares, Table,
};
use crate::cpu::cost::sums::Value;
use crate::cpu::images::Planes;
use crate::cpu::instructions::{Instructions, Kernel};
use crate::features::LEFT_OUT;
use crate::params::{Census, Cost, Params};

/// A pair, and how its pixels are compared.
#[derive(Clone, Copy)]
pub struct Pixels<'a> {
    pub left: &'a Planes,
    pub right: &'a Planes,
    table: &'a [u8],
    cost: Cost,
    census: Census,
    color: bool,
    /// Weights of bits and of values.
    weights: [u16; 2],
    /// Weight of features, and how many there are.
    learned_weight: u16,
    features: usize,
    instructions: Instructions,
}

impl<'a> Pixels<'a> {
    pub fn new(sides: [&'a Planes; 2], table: &'a [u8], params: &Params, instructions: Instructions) -> Self {
        let [left, right] = sides;
        let weights = [params.census_weight, params.ad_weight].map(|weight| weight as u16);
        Self {
            left,
            right,
            table,
            cost: params.cost,
            census: params.census,
            color: params.color_cost,
            weights,
            learned_weight: params.learned_weight as u16,
            features: params.feature_planes() as usize,
            instructions,
        }
    }

    /// The costs of row y for the columns of the left planes, at the disparities from `d` on, `[column][LANES]`, of a cost that
    /// is a byte.
    pub fn bytes(&self, y: i64, columns: Range<usize>, d: usize, out: &mut [u8]) {
        let at = At { y, columns, d };
        let [of_bits, of_value] = self.weights;
        match self.cost {
            Cost::Sad if self.color => self.fill(ColourDifferences, at, out),
            Cost::Sad | Cost::ZeroMeanSad => self.fill::<1, _>(Differences, at, out),
            Cost::BirchfieldTomasi if self.color => self.fill::<9, _>(Intervals, at, out),
            Cost::BirchfieldTomasi => self.fill::<3, _>(Intervals, at, out),
            Cost::BirchfieldTomasiGray => self.fill::<6, _>(Intervals, at, out),
            Cost::SadXy => self.fill::<2, _>(Differences, at, out),
            Cost::Census => match self.census {
                Census::Five => self.fill::<3, _>(Bits, at, out),
                Census::CentreSymmetric => self.fill::<4, _>(Bits, at, out),
                Census::Seven => self.fill::<6, _>(Bits, at, out),
                Census::NineBySeven => self.fill::<8, _>(Bits, at, out),
            },
            Cost::CensusSobel => match self.census {
                Census::Five => self.fill::<5, _>(BitsAndGradients::<3>, at, out),
                Census::CentreSymmetric => self.fill::<6, _>(BitsAndGradients::<4>, at, out),
                Census::Seven => self.fill::<8, _>(BitsAndGradients::<6>, at, out),
                Census::NineBySeven => self.fill::<10, _>(BitsAndGradients::<8>, at, out),
            },
            Cost::AdCensus => match self.census {
                Census::Five => self.fill::<4, _>(BitsAndValue::<3> { of_bits, of_value }, at, out),
                Census::CentreSymmetric => self.fill::<5, _>(BitsAndValue::<4> { of_bits, of_value }, at, out),
                Census::Seven => self.fill::<7, _>(BitsAndValue::<6> { of_bits, of_value }, at, out),
                Census::NineBySeven => self.fill::<9, _>(BitsAndValue::<8> { of_bits, of_value }, at, out),
            },
            Cost::MutualInformation => self.fill(Table(self.table), at, out),
            Cost::Learned => self.features(at, 0, None, out),
            Cost::LearnedCensus => {
                let beside = At { y, columns: at.columns.clone(), d };
                match self.census {
                    Census::Five => self.fill::<5, _>(BitsAndGradients::<3>, beside, out),
                    Census::CentreSymmetric => self.fill::<6, _>(BitsAndGradients::<4>, beside, out),
                    Census::Seven => self.fill::<8, _>(BitsAndGradients::<6>, beside, out),
                    Census::NineBySeven => self.fill::<10, _>(BitsAndGradients::<8>, beside, out),
                }
                self.features(at, self.left.planes - self.features, Some([self.learned_weight, of_bits]), out);
            }
            Cost::Ssd | Cost::Ncc => unreachable!("a product is no byte"),
        }
    }

    /// The same of a cost that is a product.
    pub fn words(&self, y: i64, columns: Range<usize>, d: usize, out: &mut [u16]) {
        let at = At { y, columns, d };
        match self.cost {
            Cost::Ssd => self.fill(Squares, at, out),
            _ => self.fill(Products, at, out),
        }
    }

    /// The cost of features, which begin at the plane `first`.
    fn features(&self, At { y, columns, d }: At, first: usize, weights: Option<[u16; 2]>, out: &mut [u8]) {
        if LEFT_OUT {
            return; // settings with such a cost were refused
        }
        let (sides, planes) = ([self.left, self.right], first..first + self.features);
        self.instructions.launch(Angles { sides, planes, weights, y, columns, d, out });
    }

    fn fill<const P: usize, C: Compare<P>>(&self, cost: C, at: At, out: &mut [C::Value]) {
        self.instructions.launch(Fill { sides: [self.left, self.right], cost, at, out });
    }
}

/// The pixels of a call.
struct At {
    y: i64,
    columns: Range<usize>,
    d: usize,
}

/// Compares a piece of a row.
struct Fill<'a, const P: usize, C: Compare<P>> {
    sides: [&'a Planes; 2],
    cost: C,
    at: At,
    out: &'a mut [C::Value],
}

impl<const P: usize, C: Compare<P>> Kernel for Fill<'_, P, C> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { sides: [left, right], cost, at: At { y, columns, d }, out } = self;
        let (count, from) = (columns.len(), columns.start);
        // The right pixels of the last column come first.
        let first = left.stride() - columns.end + d;
        let (left_row, right_row) = (left.row(y), right.row(y));
        let left: [&[u8]; P] = std::array::from_fn(|p| &left_row[p * left.stride() + from..][..count]);
        let right: [&[u8]; P] = std::array::from_fn(|p| &right_row[p * right.stride() + first..][..count + LANES - 1]);
        for (i, out) in out.as_chunks_mut::<LANES>().0[..count].iter_mut().enumerate() {
            let (mut here, mut there) = ([0; P], [simd.splat_u8x32(0); P]);
            for p in 0..P {
                here[p] = left[p][i];
                there[p] = u8::load(simd, lanes(right[p], count - 1 - i));
            }
            C::Value::store(cost.compare(simd, here, there), out);
        }
    }
}

/// The values from `at` on.
#[inline(always)]
fn lanes<T>(values: &[T], at: usize) -> &[T; LANES] {
    match values[at..at + LANES].first_chunk() {
        Some(lanes) => lanes,
        None => unreachable!("the slice has this length"),
    }
}
