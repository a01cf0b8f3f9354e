// The map as a cloud of points: a square for each pixel of the left image, as large as the pixel is at its depth.

struct View {
    // From the camera's coordinates (x right, y down, z forwards) to the screen.
    projection: mat4x4<f32>,
    // The axes of the screen in the camera's coordinates: right, down.
    right: vec4<f32>,
    down: vec4<f32>,
    // Focal length in pixels, baseline, doffs, the factor that scales a square.
    camera: vec4<f32>,
    // The principal point.
    centre: vec2<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var disparity: texture_2d<f32>; // pixels, -2048: none
@group(0) @binding(2) var left: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
}

@vertex
fn corner(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    let width = textureDimensions(disparity).x;
    let pixel = vec2(instance % width, instance / width);
    let raw = textureLoad(disparity, pixel, 0).r;
    let d = raw + view.camera.z;
    if raw <= -2048.0 || d <= 0.0 {
        return Corner(vec4(0.0, 0.0, -1.0, 0.0), vec4(0.0)); // all four alike: nothing is drawn
    }
    let z = view.camera.x * view.camera.y / d;
    let side = z / view.camera.x;
    let point = vec3((vec2<f32>(pixel) - view.centre) * side, z);
    let offset = (vec2(f32(vertex & 1u), f32(vertex >> 1u)) - 0.5) * side * view.camera.w;
    let at = point + view.right.xyz * offset.x + view.down.xyz * offset.y;
    return Corner(view.projection * vec4(at, 1.0), textureLoad(left, pixel, 0));
}

@fragment
fn colour(in: Corner) -> @location(0) vec4<f32> {
    return vec4(in.colour.rgb, 1.0);
}
