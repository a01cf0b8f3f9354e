"""Writes small good files into corpus/TARGET, for the fuzz targets to begin with: python3 fuzz/seeds.py

The first byte of a file selects what is asked of the parser (src/lib.rs); of maps the magic number is left out.
"""

import struct
import zlib
from pathlib import Path

CORPUS = Path(__file__).parent / "corpus"
FLOATS = struct.pack("<6f", 4.0, float("nan"), 1.5, 20.0, float("inf"), 0.0)


def put(target, **files):
    (CORPUS / target).mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (CORPUS / target / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def npy(kind, samples, shape="(2, 3)", fortran=False, version=1):
    header = f"{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n".encode()
    return bytes([0, version, 0]) + struct.pack("<H" if version == 1 else "<I", len(header)) + header + samples


def tiff(order, bits, sample_format, samples, width=3, height=2):
    """One strip, after the header and the list of tags."""
    tags = [(256, 3, width), (257, 3, height), (258, 3, bits), (259, 3, 1), (262, 3, 1), (273, 4, 0), (277, 3, 1)]
    tags += [(278, 3, height), (279, 4, len(samples)), (339, 3, sample_format)]
    strip = 8 + 2 + 12 * len(tags) + 4
    body = struct.pack(order + "IH", 8, len(tags))
    for tag, kind, value in tags:
        value = strip if tag == 273 else value
        body += struct.pack(order + "HHI", tag, kind, 1) + struct.pack(order + ("I" if kind == 4 else "HH"), *([value] if kind == 4 else [value, 0]))
    return body + struct.pack(order + "I", 0) + samples


def exr(channels, compression=0, width=3, height=2):
    """Scan lines of floats without compression, or of halves by ZIP; the magic number is left out."""

    def text(value):
        return value.encode() + b"\0"

    def attribute(name, kind, value):
        return text(name) + text(kind) + struct.pack("<I", len(value)) + value

    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    listed = b"".join(text(name) + struct.pack("<IIii", 2, 0, 1, 1) for name in channels) + b"\0"
    head = struct.pack("<I", 2) + attribute("channels", "chlist", listed) + attribute("compression", "compression", bytes([compression]))
    head += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    head += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)) + attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    row = struct.pack(f"<{width * len(channels)}f", *range(width * len(channels)))
    rows = [struct.pack("<iI", y, len(row)) + row for y in range(height)]
    start = 4 + len(head) + 8 * height
    return head + b"".join(struct.pack("<Q", start + y * len(rows[0])) for y in range(height)) + b"".join(rows)


def png(bits, colour, rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    width = len(rows[0]) * 8 // bits // {0: 1, 2: 3}[colour]
    header = struct.pack(">2I5B", width, len(rows), bits, colour, 0, 0, 0)
    return chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + r for r in rows))) + chunk(b"IEND", b"")


put("pfm", little=b"\0\n3 2\n-1.0\n" + FLOATS, comment=b"\x01\r\n# by hand\n3\t2 1\r\n" + FLOATS, depth=b"\x02\n1 1\n1\n\x41\0\0\0")
put(
    "npy",
    f4=npy("<f4", FLOATS),
    f8=npy("<f8", FLOATS, "(3, 1)"),
    big=npy(">f4", FLOATS),
    u1=npy("|u1", b"\0\1\2\3\4\5", "(3, 2)", True),
    i2=npy("<i2", FLOATS[:12], version=2),
    opencv=npy("<i2", struct.pack("<6h", -16, 0, 128, 320, 5, 7), "(1, 2, 3)"),
    f2=npy("<f2", FLOATS[:12], "(1, 1, 2, 3)"),
    i8=npy("<i8", struct.pack("<2q", 1, 1 << 40), "(1, 2)"),
)
put("exr", one=b"\0" + exr("Y"), three=b"\1" + exr("BGR"), depth=b"\2" + exr("AZ"), rle=b"\3" + exr("Y", 1))
put(
    "tiff",
    f32=b"\0" + tiff("<", 32, 3, FLOATS)[0:],
    f64=b"\x04" + tiff(">", 64, 3, struct.pack(">6d", 1, 2, 3, 4, 5, 6)),
    u16=b"\x01" + tiff("<", 16, 1, FLOATS[:12]),
    u8=b"\x05" + tiff(">", 8, 1, FLOATS[:6]),
)
put(
    "picture",
    gray16=b"\0" + png(16, 0, [b"\0\0\1\0", b"\2\0\xff\xff"]),
    gray8=b"\x01" + png(8, 0, [b"\0\1\2", b"\3\4\5"]),
    rgb=b"\x01" + png(8, 2, [b"\1\1\1\2\2\2"]),
    pgm=b"\x15\n# by hand\n3 2\n255\n\0\1\2\3\4\5",
    pgm16=b"\x15\n2 1\n65535\n\0\1\2\3",
    plain=b"\x09\n2 1 255 7 8\n",
    pam=b"\x1d\nWIDTH 1\nHEIGHT 1\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n\7",
)

LEFT = "700 0 320.5 0 0 700 240 0 0 0 1 0"
RIGHT = "700 0 330.5 -70 0 700 240 0 0 0 1 0"


def opencv(name, columns, numbers):
    numbers = ", ".join(numbers.split())
    rows = len(numbers.split(",")) // columns
    return f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: [ {numbers} ]\n"


def opencv_xml(name, columns, numbers):
    rows = len(numbers.split()) // columns
    return f'<{name} type_id="opencv-matrix"><rows>{rows}</rows><cols>{columns}</cols><dt>d</dt><data>{numbers}</data></{name}>\n'


def camera_info(projection):
    def matrix(name, rows, columns, numbers):
        return f"{name}:\n  rows: {rows}\n  cols: {columns}\n  data: [{', '.join(numbers.split())}]\n"

    return (
        "image_width: 640\nimage_height: 480\ncamera_name: c\n"
        + matrix("camera_matrix", 3, 3, "700 0 320 0 700 240 0 0 1")
        + "distortion_model: plumb_bob\n"
        + matrix("distortion_coefficients", 1, 5, "0.1 0.01 0 0 0")
        + matrix("rectification_matrix", 3, 3, "1 0 0 0 1 0 0 0 1")
        + matrix("projection_matrix", 3, 4, projection)
    )


PAIR = [("P1", 4, LEFT), ("P2", 4, RIGHT)]
Q = [("Q", 4, "1 0 0 -320 0 1 0 -240 0 0 0 700 0 0 10 0")]
LENSES = PAIR + [
    (name + side, columns, numbers)
    for side in "12"
    for name, columns, numbers in [("M", 3, "700 0 320 0 700 240 0 0 1"), ("D", 5, "0.1 0 0 0 0"), ("R", 3, "1 0 0 0 1 0 0 0 1")]
]
put(
    "calibration",
    middlebury="\0cam0=[700 0 320.5; 0 700 240; 0 0 1]\ncam1=[700 0 330.5; 0 700 240; 0 0 1]\ndoffs=10\nbaseline=100\nwidth=640\nheight=480\n",
    kitti=f"\x04P0: {LEFT}\nP1: {RIGHT}\n",
    kitti_raw=f"\0S_rect_02: 640 480\nP_rect_02: {LEFT}\nP_rect_03: {RIGHT}\n",
    yaml="\0%YAML:1.0\n---\nimage_size: [ 640, 480 ]\n" + "".join(opencv(*m) for m in PAIR),
    yaml_q="\1%YAML:1.0\n---\n" + "".join(opencv(*m) for m in Q),
    yaml_lenses="\x0c%YAML:1.0\n---\n" + "".join(opencv(*m) for m in LENSES),
    xml='\0<?xml version="1.0"?>\n<opencv_storage>\n' + "".join(opencv_xml(*m) for m in PAIR) + "</opencv_storage>\n",
    xml_lenses='\x0c<opencv_storage><imageSize>640 480</imageSize>' + "".join(opencv_xml(*m) for m in LENSES) + "</opencv_storage>",
)
BETWEEN = [("R", 3, "1 0 0 0 1 0 0 0 1"), ("T", 1, "-0.1 0.001 0")]
LENS_ONLY = [m for m in LENSES if m[0][0] in "MD"]
put(
    "calibration",
    yaml_unrectified="\x0c%YAML:1.0\n---\nimage_size: [ 640, 480 ]\n" + "".join(opencv(*m) for m in LENS_ONLY + BETWEEN),
)
put(
    "camera_info",
    two_files="\x0c%YAML:1.0\n---\nimage_size: [ 640, 480 ]\n" + "".join(opencv(*m) for m in LENS_ONLY) + "\0%YAML:1.0\n---\n" + "".join(opencv(*m) for m in BETWEEN),
)
put(
    "calibration",
    kalibr="\x0ccam0: {camera_model: pinhole, intrinsics: [700, 700, 320, 240], distortion_model: equidistant, distortion_coeffs: [0.1, 0, 0, 0]}\n"
    "cam1:\n  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n  camera_model: pinhole\n"
    "  intrinsics: [700, 700, 320, 240]\n  distortion_model: equidistant\n  distortion_coeffs: [0.1, 0, 0, 0]\n",
    zed="\x0c[LEFT_CAM_HD]\nfx=700\nfy=700\ncx=320\ncy=240\nk1=0.1\n[RIGHT_CAM_HD]\nfx=700\nfy=700\ncx=320\ncy=240\n[STEREO]\nBaseline=120\nTY=0\nRX_HD=0.01\n",
    drivingstereo=f"\0S_rect_101: 640 480\nP_rect_101: {LEFT}\nP_rect_103: {RIGHT}\n",
)
SIDE = '{"camera_matrix": [[700, 0, 320], [0, 700, 240], [0, 0, 1]], "dist": [[0.1, 0, 0, 0, 0]]}'
CAMERA = '{"camera_type": "ds", "intrinsics": {"fx": 700, "fy": 700, "cx": 320, "cy": 240, "xi": -0.2, "alpha": 0.6}}'
POSE = '{"px": %s, "py": 0, "pz": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 1}'
put(
    "calibration",
    foundation_stereo="\0700 0 320 0 700 240 0 0 1\n0.1\n",
    basalt="\x0c{\"value0\": {\"T_imu_cam\": [%s, %s], \"intrinsics\": [%s, %s], \"resolution\": [[640, 480], [640, 480]]}}"
    % (POSE % 0, POSE % 0.1, CAMERA, CAMERA),
    json="\x0c{\"left\": %s, \"right\": %s, \"rvec\": [0, 0.01, 0], \"T\": [-0.1, 0, 0], \"img_shape\": [480, 640]}" % (SIDE, SIDE),
    names="\x0cleft: &a {fx: 700, fy: 700, cx: 320, cy: 240, k1: 0.1, k2: 0, p1: 0, p2: 0}\nright: *a\nrot: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\ntrans: [0, -0.1, 0]\n",
    numpy="\x0cK_l: &a\n  args: [f8]\n  state: [1, [3, 3], f8, false, AAAAAACAgUAAAAAAAAAAAAAAAAAAAHRAAAAAAAAAAAAAAAAAAICBQAAAAAAAAG5AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAPA/]\n"
    "K_r: *a\nD_l: []\nD_r: []\nR: [0, 0, 0]\nT: [-0.1, 0, 0]\n",
    zed_all="\x0c" + "".join(
        f"[{side}_CAM_{name}]\nfx={f}\nfy={f}\ncx={f / 2}\ncy={f / 3}\nk1=0.1\n" for side in ("LEFT", "RIGHT") for name, f in (("HD", 1280), ("VGA", 640))
    ) + "[STEREO]\nBaseline=120\nTY=0.1\nTZ=-0.2\nCV_HD=0.01\nRX_VGA=0.01\n",
)
SENSOR = "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, %s, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [640, 480]\ncamera_model: pinhole\n" \
    "intrinsics: [700, 700, 320, 240]\ndistortion_model: radial-tangential\ndistortion_coefficients: [0.1, 0, 0, 0]\n"
put("camera_info", euroc="\x0c" + SENSOR % 0 + "\0" + SENSOR % 0.1)
ARRAYS = [("(3, 3)", "700 0 320 0 700 240 0 0 1"), ("(1, 5)", "0.1 0 0 0 0")] * 2 + [("(3, 3)", "1 0 0 0 1 0 0 0 1"), ("(3, 1)", "-0.1 0 0")]
FILES = [b"\x93NUMPY" + npy("<f8", struct.pack(f"<{len(n.split())}d", *map(float, n.split())), s)[1:] for s, n in ARRAYS]
put("npz", arrays=b"\x0c" + b"|".join(FILES))
put("camera_info", pair="\0" + camera_info(LEFT) + "\0" + camera_info(RIGHT), lenses="\x0c" + camera_info(LEFT) + "\0" + camera_info(RIGHT))
put(
    "csv",
    header='left,right,name\n"a, b.png",c.png,x/y\n# no\nd.png,e.png,\n',
    plain='"say ""c"".png", r.png\r\n../a.png,/b.png\n',
)
put(
    "json_lines",
    named='{"left": "a.png", "right": "\\u00e4.png", "name": "x/y"}\n\n{"left": "d/a.png", "right": "b", "name": null}\n',
    failure='{"name":"n","left":"l","right":"r","error":"e"}\n',
)


def text(value):
    return b"X" + struct.pack("<I", len(value)) + value.encode()


def tensor(kind, key, offset, shape, strides):
    def numbers(values):
        return b"(" + b"".join(b"K" + bytes([value]) for value in values) + b"t"

    storage = b"(" + text("storage") + f"ctorch\n{kind}\n".encode() + text(key) + text("cpu") + b"K\x06tQ"
    rest = b"K" + bytes([offset]) + numbers(shape) + numbers(strides) + b"\x89ccollections\nOrderedDict\n)RtR"
    return b"ctorch._utils\n_rebuild_tensor_v2\n(" + storage + rest


def pickled(content):
    return b"\x80\x02" + content + b"."


def archive(files):
    """Files that are stored as they are."""
    body = directory = b""
    for name, content in files.items():
        name = name.encode()
        lengths = struct.pack("<3I2H", zlib.crc32(content), len(content), len(content), len(name), 0)
        directory += b"PK\1\2" + struct.pack("<6H", 0, 0, 0, 0, 0, 0) + lengths + struct.pack("<3H2I", 0, 0, 0, 0, len(body)) + name
        body += b"PK\3\4" + struct.pack("<5H", 0, 0, 0, 0, 0) + lengths + name + content
    return body + directory + b"PK\5\6" + struct.pack("<4H2IH", 0, 0, len(files), len(files), len(directory), len(body), 0)


STATE = b"}(" + text("module.a") + tensor("FloatStorage", "0", 1, [2, 2], [1, 2]) + text("b") + tensor("HalfStorage", "1", 0, [2], [1]) + b"u"
CHECKPOINT = b"}(" + text("epoch") + b"K\1" + text("state_dict") + STATE + b"u"
MAGIC = pickled(b"\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19") + pickled(b"M\xe9\3") + pickled(b"}")
HEADER = b'{"a":{"dtype":"F32","shape":[2,3],"data_offsets":[0,24]}}  '
put(
    "weights",
    archive=archive({"a/data.pkl": pickled(CHECKPOINT), "a/data/0": FLOATS, "a/data/1": b"\0\x3c\0\xc0"}),
    legacy=MAGIC + pickled(STATE) + pickled(b"](" + text("0") + text("1") + b"e") + struct.pack("<Q", 6) + FLOATS + struct.pack("<Q", 2) + b"\0\x3c\0\xc0",
    safetensors=struct.pack("<Q", len(HEADER)) + HEADER + FLOATS,
)


def jpeg(*segments):
    """A JPEG file without pixels, with these segments."""
    content = b"".join(b"\xff" + bytes([marker]) + struct.pack(">H", len(data) + 2) + data for marker, data in segments)
    return b"\xff\xd8" + content + b"\xff\xda\0\2\xff\xd9"


def mpo(order, kinds):
    """An MPO file of so many images, 8 bytes each but for the first."""
    length = 2 + 4 + 4 + 26 + 16 * len(kinds) + 6
    index = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "IHHHIII", 8, 1, 0xB002, 7, 16 * len(kinds), 26, 0)
    for number, kind in enumerate(kinds):
        index += struct.pack(order + "4I", kind, 8 if number else length, length + 8 * (number - 1) - 10 if number else 0, 0)
    return jpeg((0xE2, b"MPF\0" + index)) + jpeg()[:2] * (len(kinds) - 1) * 4


put(
    "both",
    mpo=mpo("<", [0x20002, 0x20002]),
    mpo_big=mpo(">", [0x30000, 0x10001, 0]),
    jps=jpeg((0xE0, b"JFIF\0"), (0xE3, b"_JPSJPS_\0\4\0\4\2\1")),
)
put(
    "frames",
    y4m=b"\0YUV4MPEG2 W3 H2 F30:1 Ip A1:1 C420jpeg XCOLORRANGE=FULL\n" + (b"FRAME\n" + bytes(10)) * 2,
    mono=b"\0YUV4MPEG2 W3 H2 Cmono12\nFRAME Ip\n" + bytes(12),
    pam=b"\0P7\nWIDTH 2\nHEIGHT 1\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n" + bytes(6),
    **{f"raw{kind}": bytes([kind]) + bytes(range(36)) for kind in range(1, 8)},
)
STAMP = b"\0\1\0\0" + struct.pack("<iII", 1, 2, 4) + b"cam\0"
CAMERA = struct.pack("<III", 480, 640, 10) + b"plumb_bob\0\0\0" + struct.pack("<II", 1, 0)
put(
    "message",
    header=b"\0" + STAMP,
    image=b"\1" + STAMP + struct.pack("<III", 2, 3, 6) + b"mono8\0\0\0" + struct.pack("<II", 3, 6) + bytes(6),
    padded=b"\1" + STAMP + struct.pack("<III", 2, 1, 5) + b"bgr8\0\0\0\0" + struct.pack("<II", 4, 8) + bytes(8),
    compressed=b"\2" + STAMP + struct.pack("<I", 4) + b"png\0" + struct.pack("<I", 8) + b"\x89PNG\r\n\x1a\n",
    camera=b"\3" + STAMP + CAMERA + struct.pack("<31d", 0.1, *[0.0] * 18, 500, 0, 320, -60, 0, 500, 240, 0, 0, 0, 1, 0),
)
