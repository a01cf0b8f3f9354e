//! Speckled boxes before a wall, and the two cameras.

use crate::stereo::{Rig, SIZE};
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

/// Between the cameras, in metres.
const BASELINE: f32 = 0.12;

#[derive(Component)]
pub struct Turns;

/// Gray values of a generator of random numbers.
fn speckles() -> Image {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let data = (0..64 * 64).flat_map(|_| [next(); 3].into_iter().chain([255])).collect();
    let size = Extent3d { width: 64, height: 64, depth_or_array_layers: 1 };
    Image::new(size, TextureDimension::D2, data, TextureFormat::Rgba8UnormSrgb, RenderAssetUsages::RENDER_WORLD)
}

pub fn build(
    mut commands: Commands,
    rig: Res<Rig>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let speckles = images.add(speckles());
    let material = materials.add(StandardMaterial { base_color_texture: Some(speckles), unlit: true, ..default() });
    let cube = meshes.add(Cuboid::from_length(0.6));
    let wall = meshes.add(Cuboid::new(6.0, 4.0, 0.1));
    commands.spawn((Mesh3d(wall), MeshMaterial3d(material.clone()), Transform::from_xyz(0.0, 0.0, -3.5)));
    for (x, z) in [(-0.5, -1.6), (0.5, -2.4)] {
        commands.spawn((
            Mesh3d(cube.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_xyz(x, 0.0, z).with_rotation(Quat::from_rotation_y(x)),
            Turns,
        ));
    }
    for (image, side) in [(&rig.left, -0.5), (&rig.right, 0.5)] {
        commands.spawn((
            Camera3d::default(),
            Camera { order: -1 - (side > 0.0) as isize, ..default() },
            RenderTarget::Image(image.clone().into()),
            Projection::from(PerspectiveProjection { aspect_ratio: SIZE.x as f32 / SIZE.y as f32, ..default() }),
            Tonemapping::None,
            Msaa::Off,
            Transform::from_xyz(side * BASELINE, 0.0, 0.0),
        ));
    }
}

/// With a window the boxes turn.
pub fn turn(windows: Query<&Window>, time: Res<Time>, mut boxes: Query<&mut Transform, With<Turns>>) {
    if !windows.is_empty() {
        boxes.iter_mut().for_each(|mut transform| transform.rotate_y(time.delta_secs() / 3.0));
    }
}
