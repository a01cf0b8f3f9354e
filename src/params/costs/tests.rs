use super::*;
use crate::gpu::kernels::{KERNELS, source};
use crate::gpu::plan::Plan;
use crate::params::Params;
use crate::reference::{cost_columns, cost_table, images, matching_cost, pixel_cost};
use crate::{Image, PixelFormat, Pixels};

/// Every cost with every method, prefilter and census that it allows, and its usual block.
fn settings() -> Vec<Params> {
    let mut all = Vec::new();
    for &cost in Cost::VALUES {
        for &method in cost.row().methods {
            for &prefilter in Prefilter::VALUES {
                for &census in Census::VALUES {
                    let base = Params { min_disparity: -2, ..Params::sgm(9) };
                    let mut params = Params { cost, method, census, ..base };
                    params.take_usual();
                    params.prefilter = prefilter;
                    params.prefilter_cap = params.largest_cap();
                    all.push(params.clone());
                    params.color_cost = cost.row().color;
                    all.push(params);
                }
            }
        }
    }
    all
}

/// An image whose neighbours differ by anything, also by the most.
fn image(seed: u32) -> Image {
    let value = |i: u32| {
        let v = (i * i + seed).wrapping_mul(0x9e37_79b9) >> 24;
        (if v & 8 == 0 { v } else { 255 * (v & 1) }) as u8
    };
    Image::new(24, 7, Pixels::Rgba8((0..24 * 7 * 4).map(value).collect())).unwrap()
}

#[test]
fn rows_are_complete_and_their_settings_are_accepted() {
    for &cost in Cost::VALUES {
        let row = cost.row();
        assert!(!row.name.is_empty() && !row.help.is_empty() && !row.methods.is_empty(), "{cost}");
        assert!(row.blocks.contains(&row.block) && row.block % 2 == 1, "{cost}");
        let beside = [Descriptor::Census, Descriptor::Features];
        let numbers = row.descriptors.iter().filter(|descriptor| !beside.contains(descriptor));
        assert!(
            !row.descriptors.is_empty() && numbers.count() <= 1,
            "{cost}: a kernel computes one beside a census string and features"
        );
    }
    let in_colour = Cost::VALUES.iter().filter(|cost| cost.row().color).map(|cost| cost.name());
    let option = Params::OPTIONS.iter().find(|option| option.name == "color-cost").unwrap();
    let named = format!("{}: ", in_colour.collect::<Vec<_>>().join(", "));
    assert!(option.help.starts_with(&named), "the help of color-cost begins with {named:?}");
    for params in settings() {
        params.validate().unwrap();
        let above = Params { prefilter_cap: params.prefilter_cap + 1, ..params.clone() };
        assert!(above.validate().is_err(), "{params:?}");
    }
}

#[test]
fn a_row_says_what_the_reference_computes() {
    let pair = [image(1), image(7)];
    for params in settings() {
        let sides = pair.each_ref().map(|image| images(image, &params).prefiltered(&params).descriptors(&params));
        let table = cost_table(&sides, None, &params);
        assert_eq!(table.is_empty(), !params.has_table(), "{}", params.cost);
        for side in &sides {
            assert_eq!(side.planes, params.planes() as usize, "{params:?}");
            let numbers = side.data.iter().skip(params.census_planes() as usize).step_by(side.planes);
            let compared = params.numeric_descriptor() != Descriptor::Census;
            assert!(!compared || numbers.max().unwrap() <= &(params.descriptor_max() as u8), "{params:?}");
        }
        let pixels = (0..7 * 24).map(|i| {
            let [left, right] = sides.each_ref().map(|side| side.clamped(i % 24, i / 24));
            pixel_cost(left, right, &table, &params)
        });
        let most = pixels.max().unwrap();
        assert!(most <= params.pixel_max() && most > 0, "{params:?}: {most} of at most {}", params.pixel_max());
        assert!(params.cost.row().kind.multiplies() || params.pixel_max() <= 255, "{params:?}");
        if !params.correlates() {
            let costs = matching_cost(&cost_columns(&sides[0], &sides[1], &table, &params), &params);
            assert!(costs.data.iter().all(|&cost| cost <= 89), "{params:?}");
        }
    }
}

#[test]
fn the_shaders_follow_the_row() {
    for params in settings() {
        let row = params.cost.row();
        let text = row.fragments.concat();
        let [costs, pairs] = ["fn pixel_costs(", "fn pixel_pairs("].map(|name| text.matches(name).count());
        assert_eq!([costs, pairs], if row.kind.multiplies() { [0, 1] } else { [1, 0] }, "{}", params.cost);
        let plan = Plan::of(params.quads(), false, 1, false);
        let kernel = KERNELS.iter().find(|kernel| kernel.name == "cost_columns").unwrap();
        let whole = source(kernel, &params, PixelFormat::Gray8, &plan);
        assert!(row.fragments.iter().all(|fragment| whole.contains(fragment)), "{}", params.cost);
        let kernel = KERNELS.iter().find(|kernel| kernel.name == "descriptors").unwrap();
        let whole = source(kernel, &params, PixelFormat::Gray8, &plan);
        for (name, value) in [
            ("DESCRIPTOR", params.numeric_descriptor() as u32),
            ("CENSUS_PLANES", params.census_planes()),
            ("IMAGE_PLANES", (params.compared_planes() / params.described()).max(1)),
        ] {
            assert!(whole.contains(&format!("const {name}: u32 = {value}u;")), "{}: {name}", params.cost);
        }
    }
}
