//! Pairs of a made scene, as cameras of several programs would have taken them: the inside of a ball around the left camera, whose
//! distance is the same however the rectified camera is turned.

use crate::support::{command, stderr, stdout};
use image::{GrayImage, Luma};
use serde_json::Value;
use std::fs;
use std::path::Path;

type Vector = [f64; 3];
type Matrix = [[f64; 3]; 3];

/// The ball's radius in metres.
const RADIUS: f64 = 0.9;
const SIZE: [u32; 2] = [240, 180];

#[derive(Clone, Copy)]
enum Model {
    RadTan([f64; 5]),
    Equidistant([f64; 4]),
    DoubleSphere([f64; 2]),
}

#[derive(Clone, Copy)]
struct Lens {
    focal: [f64; 2],
    center: [f64; 2],
    model: Model,
}

impl Lens {
    /// The pixel of a direction.
    fn pixel(&self, [x, y, z]: Vector) -> [f64; 2] {
        let place = match self.model {
            Model::RadTan([k1, k2, p1, p2, k3]) => {
                let (x, y) = (x / z, y / z);
                let q = x * x + y * y;
                let radial = 1.0 + k1 * q + k2 * q * q + k3 * q * q * q;
                [
                    x * radial + 2.0 * p1 * x * y + p2 * (q + 2.0 * x * x),
                    y * radial + p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y,
                ]
            }
            Model::Equidistant(k) => {
                let r = x.hypot(y);
                let angle = r.atan2(z);
                let bent = angle + (0..4).map(|i| k[i] * angle.powi(2 * i as i32 + 3)).sum::<f64>();
                if r == 0.0 { [0.0; 2] } else { [x / r * bent, y / r * bent] }
            }
            Model::DoubleSphere([xi, alpha]) => {
                let far = (x * x + y * y + z * z).sqrt();
                let moved = xi * far + z;
                let w = alpha * (x * x + y * y + moved * moved).sqrt() + (1.0 - alpha) * moved;
                [x / w, y / w]
            }
        };
        [0, 1].map(|axis| self.focal[axis] * place[axis] + self.center[axis])
    }

    /// The direction of a pixel: Newton's rounds over two angles.
    fn direction(&self, pixel: [f64; 2]) -> Vector {
        let of = |[a, b]: [f64; 2]| [a.sin(), b.sin() * a.cos(), b.cos() * a.cos()];
        let mut angles = [0, 1].map(|axis| ((pixel[axis] - self.center[axis]) / self.focal[axis]).atan());
        for _ in 0..30 {
            let at = |angles: [f64; 2]| self.pixel(of(angles));
            let (now, step) = (at(angles), 1e-6);
            let (a, b) = (at([angles[0] + step, angles[1]]), at([angles[0], angles[1] + step]));
            let [da, db] = [a, b].map(|moved| [0, 1].map(|axis| (moved[axis] - now[axis]) / step));
            let miss = [pixel[0] - now[0], pixel[1] - now[1]];
            let determinant = da[0] * db[1] - db[0] * da[1];
            angles[0] += (miss[0] * db[1] - miss[1] * db[0]) / determinant;
            angles[1] += (miss[1] * da[0] - miss[0] * da[1]) / determinant;
        }
        of(angles)
    }
}

/// The pose of the right camera: it sees `rotation` x + `translation`.
#[derive(Clone, Copy)]
struct Pose {
    axis: Vector,
    translation: Vector,
}

impl Pose {
    /// By a series of the matrix of the cross product.
    fn rotation(&self) -> Matrix {
        let [x, y, z] = self.axis;
        let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        let (mut sum, mut term) = ([[0.0; 3]; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        for n in 1..20 {
            for (i, row) in sum.iter_mut().enumerate() {
                (0..3).for_each(|j| row[j] += term[i][j]);
            }
            let next = |i: usize, j: usize| (0..3).map(|k| term[i][k] * cross[k][j]).sum::<f64>() / f64::from(n);
            term = std::array::from_fn(|i| std::array::from_fn(|j| next(i, j)));
        }
        sum
    }
}

/// Noise over directions in space.
fn texture(point: Vector) -> f64 {
    let hash = |cell: [i64; 3]| {
        let mixed = cell.iter().fold(0x9e37_79b9_7f4a_7c15_u64, |hash, &side| {
            (hash ^ side as u64).wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(31)
        });
        (mixed.wrapping_mul(0xc4ce_b9fe_1a85_ec53) >> 40) as f64 / f64::from(1 << 24)
    };
    let octave = |scale: f64| {
        let place = point.map(|side| side * scale);
        let (cell, share) = (place.map(|side| side.floor() as i64), place.map(|side| side - side.floor()));
        let corner = |i: usize| {
            let at = [0, 1, 2].map(|axis| cell[axis] + (i >> axis & 1) as i64);
            let weight: f64 =
                (0..3).map(|axis| if i >> axis & 1 == 1 { share[axis] } else { 1.0 - share[axis] }).product();
            weight * hash(at)
        };
        (0..8).map(corner).sum::<f64>()
    };
    0.5 * octave(35.0) + 0.5 * octave(14.0)
}

/// What a camera at `center`, turned back by the transposed `rotation`, sees.
fn seen(lens: &Lens, rotation: &Matrix, center: Vector) -> GrayImage {
    GrayImage::from_fn(SIZE[0], SIZE[1], |x, y| {
        let ray = lens.direction([x.into(), y.into()]);
        let ray: Vector = std::array::from_fn(|i| (0..3).map(|k| rotation[k][i] * ray[k]).sum());
        // center + s ray on the ball
        let dot = |a: Vector, b: Vector| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (along, off) = (dot(ray, center), dot(center, center) - RADIUS * RADIUS);
        let far = -along + (along * along - off).sqrt();
        let point = std::array::from_fn(|i| center[i] + far * ray[i]);
        Luma([(255.0 * texture(point)).round().clamp(0.0, 255.0) as u8])
    })
}

fn take(folder: &Path, lenses: &[Lens; 2], pose: &Pose) {
    let straight = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let rotation = pose.rotation();
    let center = std::array::from_fn(|i| -(0..3).map(|k| rotation[k][i] * pose.translation[k]).sum::<f64>());
    seen(&lenses[0], &straight, [0.0; 3]).save(folder.join("left.png")).unwrap();
    seen(&lenses[1], &rotation, center).save(folder.join("right.png")).unwrap();
}

/// The values of a .npy of 32-bit floats.
fn floats(path: &Path, count: usize) -> Vec<f64> {
    let bytes = fs::read(path).unwrap();
    let samples = &bytes[bytes.len() - 4 * count..];
    samples.chunks(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]).into()).collect()
}

/// The median error of the disparities, and the share of pixels that have one; the cameras must be those of the rig.
fn judged(folder: &Path, options: &[&str], pose: &Pose) -> (f64, f64, [u64; 2]) {
    let mut run = command(folder);
    run.args([
        "left.png",
        "right.png",
        "--disp",
        "48",
        "--backend",
        "cpu",
        "--json",
        "-o",
        "map.npy",
        "--depth",
        "depth.npy",
    ]);
    let output = run.args(options).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["warnings"].as_array().unwrap().len(), 0, "{}", json["warnings"]);
    let camera = |name: &str| json["camera"][name].as_f64().unwrap();
    let [focal, baseline, cx, cy] = ["focal_px", "baseline_m", "cx_px", "cy_px"].map(camera);
    let apart = pose.translation.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((baseline - apart).abs() < 1e-6, "{baseline} where {apart}");
    let [width, height] = ["width", "height"].map(|name| json[name].as_u64().unwrap());
    let count = (width * height) as usize;
    let (map, depth) = (floats(&folder.join("map.npy"), count), floats(&folder.join("depth.npy"), count));
    let truth = |i: usize| {
        let (x, y) = ((i as u64 % width) as f64, (i as u64 / width) as f64);
        let (x, y) = ((x - cx) / focal, (y - cy) / focal);
        let depth = RADIUS / (1.0 + x * x + y * y).sqrt();
        (focal * baseline / depth, depth)
    };
    let mut errors: Vec<f64> = (0..count).filter(|&i| !map[i].is_nan()).map(|i| (map[i] - truth(i).0).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let near = (0..count).filter(|&i| (depth[i] / truth(i).1 - 1.0).abs() < 0.1).count();
    assert!(2 * near > errors.len(), "of {} depths {near} are right", errors.len());
    (errors[errors.len() / 2], errors.len() as f64 / count as f64, [width, height])
}

fn radtan() -> [Lens; 2] {
    let lens =
        |f: f64, cx: f64, cy: f64, k: [f64; 5]| Lens { focal: [f, f + 1.0], center: [cx, cy], model: Model::RadTan(k) };
    [
        lens(150.0, 122.0, 88.0, [-0.28, 0.07, 0.0002, 0.00002, 0.0]),
        lens(149.0, 117.0, 91.0, [-0.27, 0.06, -0.0001, 0.0003, 0.0]),
    ]
}

const SIDE_BY_SIDE: Pose = Pose { axis: [0.01, -0.02, 0.015], translation: [-0.11, 0.003, -0.002] };

/// Rows of a matrix of 4 x 4.
fn rows(rotation: &Matrix, translation: Vector) -> Vec<[f64; 4]> {
    let row = |i: usize| [rotation[i][0], rotation[i][1], rotation[i][2], translation[i]];
    vec![row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

fn kalibr(lenses: &[Lens; 2], pose: &Pose) -> String {
    let mut text = String::new();
    for (i, lens) in lenses.iter().enumerate() {
        let Lens { focal: [fx, fy], center: [cx, cy], model } = lens;
        let (kind, name, own, bent) = match model {
            Model::RadTan(k) => ("pinhole", "radtan", String::new(), k[..4].to_vec()),
            Model::Equidistant(k) => ("pinhole", "equidistant", String::new(), k.to_vec()),
            Model::DoubleSphere([xi, alpha]) => ("ds", "none", format!("{xi}, {alpha}, "), vec![]),
        };
        text += &format!("cam{i}:\n  cam_overlaps: [{}]\n  camera_model: {kind}\n", 1 - i);
        text += &format!("  distortion_coeffs: {bent:?}\n  distortion_model: {name}\n");
        text += &format!("  intrinsics: [{own}{fx}, {fy}, {cx}, {cy}]\n  resolution: {SIZE:?}\n");
        if i == 1 {
            let rows = rows(&pose.rotation(), pose.translation);
            text += &format!("  T_cn_cnm1:\n{}", rows.iter().map(|row| format!("  - {row:?}\n")).collect::<String>());
        }
    }
    text
}

fn small(folder: &Path, options: &[&str], pose: &Pose, what: &str) -> [u64; 2] {
    let (error, share, size) = judged(folder, options, pose);
    eprintln!("{what}: a median error of {error:.3} px, {:.0} % of {size:?}", 100.0 * share);
    assert!(error < 0.5 && share > 0.4, "{what}: {error} px, {share}");
    size
}

#[test]
fn pinholes_of_kalibr_euroc_and_zed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let lenses = radtan();
    take(path, &lenses, &SIDE_BY_SIDE);
    fs::write(path.join("camchain.yaml"), kalibr(&lenses, &SIDE_BY_SIDE)).unwrap();
    let chain = ["--rectify", "camchain.yaml"];
    assert_eq!(small(path, &chain, &SIDE_BY_SIDE, "Kalibr"), [240, 180]);
    // OpenCV's alpha and another size.
    for (alpha, size) in [("0", "240x180"), ("0.5", "240x180"), ("1", "240x180"), ("0", "320x200"), ("1", "320x200")] {
        let more = ["--alpha", alpha, "--rectified-size", size];
        let found = small(path, &[&chain[..], &more].concat(), &SIDE_BY_SIDE, &format!("alpha {alpha}, {size}"));
        assert_eq!(format!("{}x{}", found[0], found[1]), size);
    }
    // EuRoC: both cameras on a body.
    let body = Pose { axis: [0.3, -1.2, 0.7], translation: [0.05, -0.2, 0.4] };
    let turn = body.rotation();
    let right = SIDE_BY_SIDE.rotation();
    // The right camera's pose on the body: that of the left one after the way back.
    let back: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| turn[i][k] * right[j][k]).sum()));
    let place = std::array::from_fn(|i| {
        body.translation[i] - (0..3).map(|k| back[i][k] * SIDE_BY_SIDE.translation[k]).sum::<f64>()
    });
    for (i, pose) in [rows(&turn, body.translation), rows(&back, place)].iter().enumerate() {
        let Lens { focal: [fx, fy], center: [cx, cy], model: Model::RadTan([k1, k2, p1, p2, _]) } = lenses[i] else {
            panic!()
        };
        let data = pose.concat().iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
        let text = format!(
            "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [{data}]\nrate_hz: 20\nresolution: {SIZE:?}\ncamera_model: \
             pinhole\nintrinsics: [{fx}, {fy}, {cx}, {cy}]\ndistortion_model: radial-tangential\ndistortion_coefficients: [{k1}, {k2}, \
             {p1}, {p2}]\n"
        );
        fs::write(path.join(format!("cam{i}.yaml")), text).unwrap();
    }
    let euroc = ["--rectify", "cam0.yaml", "--calib-right", "cam1.yaml"];
    small(path, &euroc, &SIDE_BY_SIDE, "EuRoC");
    // ZED: the turns are RX, CV and RZ, the lengths the other way round and in millimetres.
    let mut text = String::new();
    for (side, lens) in ["LEFT", "RIGHT"].iter().zip(lenses) {
        let Lens { focal: [fx, fy], center: [cx, cy], model: Model::RadTan([k1, k2, p1, p2, k3]) } = lens else {
            panic!()
        };
        text += &format!(
            "[{side}_CAM_HD]\nfx={fx}\nfy={fy}\ncx={cx}\ncy={cy}\nk1={k1}\nk2={k2}\np1={p1}\np2={p2}\nk3={k3}\n\n"
        );
        text += &format!("[{side}_CAM_2K]\nfx=1400\nfy=1400\ncx=1100\ncy=620\n\n");
    }
    let ([x, y, z], [rx, cv, rz]) = (SIDE_BY_SIDE.translation.map(|x| -1000.0 * x), SIDE_BY_SIDE.axis);
    text += &format!("[STEREO]\nBaseline={x}\nTY={y}\nTZ={z}\nCV_HD={cv}\nRX_HD={rx}\nRZ_HD={rz}\n");
    fs::write(path.join("SN1.conf"), text).unwrap();
    small(path, &["--rectify", "SN1.conf"], &SIDE_BY_SIDE, "ZED");
}

#[test]
fn wide_lenses_of_tum_vi_and_basalt() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let wide = |model: [Model; 2], f: f64| {
        let lens = |i: usize, cx: f64| Lens { focal: [f, f - 0.5], center: [cx, 90.0], model: model[i] };
        [lens(0, 121.0), lens(1, 118.5)]
    };
    let equidistant = [[0.0034, 0.0008, -0.0004, 0.0002], [0.0027, 0.0011, -0.0005, 0.0001]].map(Model::Equidistant);
    let lenses = wide(equidistant, 95.0);
    take(path, &lenses, &SIDE_BY_SIDE);
    fs::write(path.join("camchain.yaml"), kalibr(&lenses, &SIDE_BY_SIDE)).unwrap();
    small(path, &["--rectify", "camchain.yaml"], &SIDE_BY_SIDE, "TUM-VI");
    let lenses = wide([[-0.24, 0.56], [-0.23, 0.57]].map(Model::DoubleSphere), 75.0);
    take(path, &lenses, &SIDE_BY_SIDE);
    let camera = |lens: &Lens| {
        let Lens { focal: [fx, fy], center: [cx, cy], model: Model::DoubleSphere([xi, alpha]) } = lens else {
            panic!()
        };
        serde_json::json!({"camera_type": "ds", "intrinsics": {"fx": fx, "fy": fy, "cx": cx, "cy": cy, "xi": xi, "alpha": alpha}})
    };
    let [x, y, z] = SIDE_BY_SIDE.axis.map(|x| -x);
    let angle = (x * x + y * y + z * z).sqrt();
    let [qx, qy, qz] = [x, y, z].map(|x| x / angle * (angle / 2.0).sin());
    let right = SIDE_BY_SIDE.rotation();
    let place = |i: usize| -(0..3).map(|k| right[k][i] * SIDE_BY_SIDE.translation[k]).sum::<f64>();
    let basalt = serde_json::json!({"value0": {
        "T_imu_cam": [
            {"px": 0, "py": 0, "pz": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 1},
            {"px": place(0), "py": place(1), "pz": place(2), "qx": qx, "qy": qy, "qz": qz, "qw": (angle / 2.0).cos()}
        ],
        "intrinsics": [camera(&lenses[0]), camera(&lenses[1])],
        "resolution": [SIZE, SIZE]
    }});
    fs::write(path.join("calibration.json"), basalt.to_string()).unwrap();
    small(path, &["--rectify", "calibration.json"], &SIDE_BY_SIDE, "Basalt, double sphere");
    fs::write(path.join("camchain.yaml"), kalibr(&lenses, &SIDE_BY_SIDE)).unwrap();
    small(path, &["--rectify", "camchain.yaml", "--alpha", "1"], &SIDE_BY_SIDE, "Kalibr, double sphere");
}

/// The upper camera in the place of the left one.
#[test]
fn cameras_one_above_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let pose = Pose { axis: [0.015, -0.01, 0.02], translation: [0.002, -0.1, 0.003] };
    let lenses = radtan();
    take(path, &lenses, &pose);
    fs::write(path.join("camchain.yaml"), kalibr(&lenses, &pose)).unwrap();
    let chain = ["--rectify", "camchain.yaml"];
    for more in [&[][..], &["--vertical"], &["--vertical", "--alpha", "0", "--rectified-size", "300x200"]] {
        small(path, &[&chain, more].concat(), &pose, &format!("vertical {more:?}"));
    }
}
