//! Bindings and uniform blocks of the shaders agree with the table and with their Rust twins, by reflection.

use std::mem::offset_of;

use wgpu::naga;

use super::specialisations::{PLAN, parse, specialised};
use crate::gpu::kernels::{Access, KERNELS, source};
use crate::gpu::layout::{
    BeliefOwn, CoarseOwn, Dispatch, FeatureOwn, FillOwn, Frame, GrayOwn, HistogramOwn, ImageOwn, LayerOwn, Own,
    PathOwn, PlaneOwn, RoundOwn, SmoothOwn, StartOwn, StatisticsOwn, ValidityOwn, WindowOwn,
};
use crate::{Params, PixelFormat};

/// Name, offset and kind of each member of a struct, and its size.
type StructLayout = (Vec<(String, u32, String)>, u32);

/// Name, offset and kind of each member, and the size: of a Rust struct. A member left out does not compile.
macro_rules! layout {
    ($type:ident { $($field:ident),+ $(,)? }) => {{
        let $type { $($field),+ } = $type::default();
        let members = vec![$((
            stringify!($field).to_string(),
            offset_of!($type, $field) as u32,
            std::any::type_name_of_val(&$field).to_string(),
        )),+];
        (members, size_of::<$type>() as u32)
    }};
}

/// The same of a WGSL struct.
fn reflected(module: &naga::Module, name: &str) -> StructLayout {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
        panic!("there is no struct {name}");
    };
    let kind = |member: &naga::StructMember| match module.types[member.ty].inner {
        naga::TypeInner::Scalar(naga::Scalar::U32) => "u32".to_string(),
        naga::TypeInner::Scalar(naga::Scalar::I32) => "i32".to_string(),
        ref other => format!("{other:?}"),
    };
    let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset, kind(m))).collect();
    (members, *span)
}

fn frame_layout() -> StructLayout {
    layout!(Frame {
        width,
        height,
        min_disparity,
        block_radius,
        prefilter_cap,
        cost_scale,
        p1,
        p2,
        lr_max_difference,
        gray_stride,
        left_stride,
        right_stride,
        map_stride,
        volume_stride,
        map_words,
        texture,
        speckle_window,
        speckle_range,
        fill_max_difference,
        depth_high,
        depth_low,
        depth_offset,
        source_shift,
    })
}

fn dispatch_layout() -> StructLayout {
    layout!(Dispatch {
        first_row,
        rows,
        volume_row,
        first_line,
        lines,
        shift,
        dx,
        dy,
        entry,
        carried,
        stride,
        row_step,
        slot,
        map_row,
        planes_row,
        planes_rows,
        own,
    })
}

/// The block `Own` of each kernel that has one.
fn own_layout(kernel: &str) -> Option<StructLayout> {
    Some(match kernel {
        "gray" | "deep_gray" => layout!(GrayOwn { channel, reversed }),
        "prefilter" | "descriptors" => layout!(PlaneOwn { mirrored, lead, first_plane }),
        "window_columns" | "window_sums" => layout!(WindowOwn { window }),
        "mi_histogram" => layout!(HistogramOwn { halvings }),
        "mi_smooth" => layout!(SmoothOwn { narrowing, prior, logarithms }),
        "sgm_aggregate" | "second_cost" | "winner" => {
            layout!(PathOwn { accumulate, carry_from, carry_to, penalties_from, penalties_line, penalties_step, place })
        }
        "coarse_cost" | "coarse_cost_sums" => layout!(CoarseOwn { width, rows, stride, coarse_stride }),
        "messages_start" => layout!(StartOwn {
            rows,
            stride,
            coarse_width,
            coarse_height,
            coarse_stride,
            coarse_first,
            coarse_rows,
            above
        }),
        "messages" | "messages_coarse" | "winner_beliefs" => {
            layout!(BeliefOwn { width, height, stride, first, rows, above, odd, share })
        }
        "average_pool" | "upsample" | "disparity_regression" => {
            layout!(ImageOwn { columns, rows, in_columns, in_rows, in_stride, in_at, out_stride, rule })
        }
        "feature_statistics" => layout!(StatisticsOwn { shift }),
        "feature_point" | "feature_convolution" | "feature_depthwise" => {
            layout!(FeatureOwn { in_first, in_rows, in_blocks, out_blocks, weights, lowest, highest, wide })
        }
        "round_disparities" => layout!(RoundOwn { columns, padding }),
        "network_input" => layout!(GrayOwn { channel, reversed }),
        name if name.starts_with("conv") => layout!(LayerOwn {
            columns,
            rows,
            planes,
            in_columns,
            in_rows,
            in_planes,
            blocks,
            first_in,
            end_in,
            in_stride,
            out_stride,
            at,
            added_at,
            weights,
            first_block,
            out_blocks,
            flags
        }),
        "validity" => layout!(ValidityOwn { side }),
        "fill_between" | "fill_rays" => layout!(FillOwn { occlusions }),
        _ => return None,
    })
}

/// What all kernels share, and what each has of its own.
#[test]
fn uniform_blocks_are_laid_out_as_their_rust_twins() {
    let (dispatch, bytes) = dispatch_layout();
    let (shared, own) = (&dispatch[..dispatch.len() - 1], dispatch.last().unwrap().1);
    assert_eq!((own, bytes), (64, 64 + size_of::<Own>() as u32));
    for kernel in KERNELS {
        let name = kernel.name;
        let module = parse(kernel, &source(kernel, &Params::sgm(64), PixelFormat::Gray8, &PLAN));
        assert_eq!(reflected(&module, "Frame"), frame_layout(), "Frame in WGSL (left) and Rust (right)");
        let (members, span) = reflected(&module, "Dispatch");
        assert_eq!(members[..members.len() - 1], *shared, "{name}: Dispatch in WGSL (left) and Rust (right)");
        let (last, at, _) = members.last().unwrap();
        assert_eq!((last.as_str(), *at), ("own", own), "{name}");
        assert!(span <= bytes, "{name}: {span} bytes of Dispatch, but only {bytes} are bound");
        let is_own =
            |ty: &naga::Type| ty.name.as_deref() == Some("Own") && matches!(ty.inner, naga::TypeInner::Struct { .. });
        let has_own = module.types.iter().any(|(_, ty)| is_own(ty));
        let declared = has_own.then(|| reflected(&module, "Own"));
        assert_eq!(declared, own_layout(name), "{name}: Own in WGSL (left) and Rust (right)");
    }
}

/// The test of the test above: members that change places, and one of another kind.
#[test]
fn a_changed_uniform_block_is_noticed() {
    let kernel = &KERNELS[0];
    let text = source(kernel, &Params::sgm(64), PixelFormat::Gray8, &PLAN);
    for (from, to) in [
        ("    p1: u32,\n    p2: u32,\n", "    p2: u32,\n    p1: u32,\n"),
        ("    min_disparity: i32,\n", "    min_disparity: u32,\n"),
        ("    height: u32,\n", "    @align(16) height: u32,\n"),
    ] {
        let changed = text.replace(from, to);
        assert_ne!(changed, text, "{from:?} is no longer in the text");
        assert_ne!(reflected(&parse(kernel, &changed), "Frame"), frame_layout(), "{to:?} went unnoticed");
    }
    let kernel = KERNELS.iter().find(|kernel| kernel.name == "gray").unwrap();
    let text = source(kernel, &Params::sgm(64), PixelFormat::Gray8, &PLAN);
    let changed = text.replace("reversed: u32,", "@align(16) reversed: u32,");
    assert_ne!(changed, text);
    assert_ne!(Some(reflected(&parse(kernel, &changed), "Own")), own_layout(kernel.name));
}

#[test]
fn bindings_agree_with_the_table() {
    for kernel in KERNELS {
        for (text, bound) in specialised(kernel) {
            let module = parse(kernel, text);
            let mut bindings: Vec<(u32, String)> = Vec::new();
            for (_, variable) in module.global_variables.iter() {
                let Some(at) = &variable.binding else { continue };
                assert_eq!(at.group, 0, "{}: {:?}", kernel.name, variable.name);
                let kind = match variable.space {
                    naga::AddressSpace::Uniform => module.types[variable.ty].name.clone().unwrap_or_default(),
                    naga::AddressSpace::Storage { access } if access == naga::StorageAccess::LOAD => "Read".into(),
                    naga::AddressSpace::Storage { .. } => "Write".into(),
                    naga::AddressSpace::Handle => match module.types[variable.ty].inner {
                        naga::TypeInner::Image {
                            class: naga::ImageClass::Storage { format: naga::StorageFormat::R32Uint, access },
                            ..
                        } if access == naga::StorageAccess::LOAD => "Texels(R32Uint)".into(),
                        naga::TypeInner::Image {
                            class: naga::ImageClass::Storage { format: naga::StorageFormat::Rgba32Uint, access },
                            ..
                        } if access == naga::StorageAccess::LOAD => "Texels(Rgba32Uint)".into(),
                        ref other => format!("{other:?}"),
                    },
                    other => format!("{other:?}"),
                };
                bindings.push((at.binding, kind));
            }
            bindings.sort();
            let written = |access| if access == Access::Trees { Access::Write } else { access };
            for (params, _, plan) in bound {
                let storage = kernel.storage(params, plan).into_iter().map(|access| format!("{:?}", written(access)));
                let expected = ["Frame".to_string(), "Dispatch".to_string()].into_iter().chain(storage);
                let expected: Vec<(u32, String)> = (0..).zip(expected).collect();
                assert_eq!(bindings, expected, "{}: bindings in WGSL (left) and in the table (right)", kernel.name);
            }
        }
    }
}
