//! The matcher in a Bevy app: two cameras draw into textures, the matcher takes these where they are and leaves disparities and their
//! colours in two others, and the window shows the left view beside the colours. Nothing passes through the host.
//!
//!     cargo run                # a window
//!     cargo run -- --check     # without a window: some frames, then the disparities beside the reference, to the bit
//!
//! `stereo.rs` is the part to take into another app.

mod scene;
mod stereo;

use bevy::app::ScheduleRunnerPlugin;
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use gpu_stereo::{DisparityMap, Image as Picture, Pixels, reference};
use stereo::{Rig, SIZE, StereoPlugin, params};

fn main() -> AppExit {
    let check = std::env::args().any(|argument| argument == "--check");
    let mut app = App::new();
    if check {
        let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
        app.add_plugins((DefaultPlugins.set(window).disable::<WinitPlugin>(), ScheduleRunnerPlugin::default()));
        app.init_resource::<Read>().add_systems(Startup, read.after(scene::build)).add_systems(Update, compare);
    } else {
        app.add_plugins(DefaultPlugins).add_systems(Startup, show.after(scene::build));
    }
    app.add_plugins(StereoPlugin).add_systems(Startup, scene::build).add_systems(Update, scene::turn);
    app.run()
}

/// The left view beside the colours.
fn show(mut commands: Commands, rig: Res<Rig>) {
    commands.spawn((Camera2d, Camera { order: 1, ..default() }));
    for (image, side) in [(&rig.left, -0.5), (&rig.colours, 0.5)] {
        commands.spawn((Sprite::from_image(image.clone()), Transform::from_xyz(side * SIZE.x as f32, 0.0, 0.0)));
    }
}

/// What came back from the device: left, right, disparities.
#[derive(Resource, Default)]
struct Read([Vec<u8>; 3], u32);

fn read(mut commands: Commands, rig: Res<Rig>) {
    for (number, image) in [&rig.left, &rig.right, &rig.disparity].into_iter().enumerate() {
        let keep = move |done: On<ReadbackComplete>, mut read: ResMut<Read>| read.0[number] = done.data.clone();
        commands.spawn(Readback::texture(image.clone())).observe(keep);
    }
}

/// After some frames of a scene at rest: the reference of the views that came back beside the disparities that came back.
fn compare(mut read: ResMut<Read>, mut exit: MessageWriter<AppExit>) {
    read.1 += 1;
    let Read([left, right, disparity], frames) = &*read;
    if disparity.is_empty() || *frames < 60 {
        assert!(*frames < 6000, "no frame came back");
        return;
    }
    let view = |bytes: &Vec<u8>| Picture::new(SIZE.x, SIZE.y, Pixels::Rgba8(bytes.clone())).expect("a view");
    let expected: DisparityMap = reference::compute(&view(left), &view(right), &params()).expect("the reference");
    let found = disparity.chunks_exact(4).map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    let expected: Vec<f32> = expected.data.iter().map(|value| f32::from(*value) / 16.0).collect();
    let different = found.zip(&expected).filter(|(found, expected)| found != *expected).count();
    let valid = expected.iter().filter(|value| **value >= 0.0).count();
    println!("{different} of {} disparities differ from the reference; {valid} are valid", expected.len());
    exit.write(if different == 0 && valid > expected.len() / 2 { AppExit::Success } else { AppExit::error() });
}
