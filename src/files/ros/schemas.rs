//! The types of the messages that are written, as records define them.

/// A type of messages: its name, and its definition with those of all that it has.
#[derive(Clone, Copy, Debug)]
pub struct Schema {
    /// The name.
    pub name: &'static str,
    /// The definition in the form `ros2msg`.
    pub definition: &'static str,
}

macro_rules! part {
    ($name:literal) => {
        concat!(
            "\n================================================================================\nMSG: ",
            $name,
            "\n"
        )
    };
}

macro_rules! header {
    () => {
        concat!(
            part!("std_msgs/Header"),
            "builtin_interfaces/Time stamp\nstring frame_id\n",
            part!("builtin_interfaces/Time"),
            "int32 sec\nuint32 nanosec\n"
        )
    };
}

macro_rules! image {
    () => {
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n"
    };
}

/// Of `disparity`.
pub const DISPARITY: Schema = Schema {
    name: "stereo_msgs/msg/DisparityImage",
    definition: concat!(
        "std_msgs/Header header\nsensor_msgs/Image image\nfloat32 f\nfloat32 t\nsensor_msgs/RegionOfInterest valid_window\n",
        "float32 min_disparity\nfloat32 max_disparity\nfloat32 delta_d\n",
        part!("sensor_msgs/Image"),
        image!(),
        part!("sensor_msgs/RegionOfInterest"),
        "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
        header!()
    ),
};

/// Of `depth`.
pub const DEPTH: Schema = Schema { name: "sensor_msgs/msg/Image", definition: concat!(image!(), header!()) };

/// Of `points`.
pub const POINTS: Schema = Schema {
    name: "sensor_msgs/msg/PointCloud2",
    definition: concat!(
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n",
        "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
        part!("sensor_msgs/PointField"),
        "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n",
        "uint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n",
        header!()
    ),
};
