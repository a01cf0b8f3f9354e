//! Records: pairs of images from two topics of a ROS 2 bag in MCAP.

use super::messages::{Messages, Topic};
use super::partners::{Partners, partners};
use crate::terminal::{plain, warnings};
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use gpu_stereo::files::calibration::Calibration;
use gpu_stereo::files::ros::{CameraInfo, Header, ImageMessage};
use image::DynamicImage;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// So many images may wait for a partner that comes later in the file.
const WAITING: usize = 256;

/// From so many nanoseconds on it is said that the images of a pair were not taken at once.
const APART: i64 = 1_000_000;

/// The types of images.
const IMAGES: [&str; 4] =
    ["sensor_msgs/msg/Image", "sensor_msgs/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/CompressedImage"];

/// When a pair was taken, by its left image.
#[derive(Clone, Debug)]
pub struct Taken {
    /// The header of the left image.
    pub header: Header,
    /// When it was recorded, in nanoseconds.
    pub log_time: u64,
}

/// The pairs of a record, in the order of the file.
pub struct Record {
    path: PathBuf,
    topics: [String; 2],
    messages: Messages,
    /// For each image of a camera, the pair that it belongs to.
    pair_of: [HashMap<usize, usize>; 2],
    /// How many images of each camera were read.
    read: [usize; 2],
    waiting: HashMap<usize, Waiting>,
    /// The cameras by the record's own messages, if it has them.
    pub calibration: Option<Calibration>,
}

/// The image of a pair that came first.
struct Waiting {
    side: usize,
    log_time: u64,
    topic: std::sync::Arc<Topic>,
    data: Vec<u8>,
}

/// Whether a file is a record; other records are refused with what converts them.
pub fn is_record(path: &Path) -> Result<bool> {
    if path.is_dir() {
        ensure!(
            !path.join("metadata.yaml").is_file() || !has_bag(path),
            "{path:?} is the folder of a ROS 2 bag; give the .mcap file in it, or convert it by ros2 bag convert"
        );
        return Ok(false);
    }
    let mut start = Vec::new();
    if !path.is_file() || File::open(path).and_then(|file| file.take(16).read_to_end(&mut start)).is_err() {
        return Ok(false);
    }
    let is_ros1 = start.starts_with(b"#ROSBAG");
    ensure!(
        !is_ros1 && !start.starts_with(b"SQLite format 3"),
        "{path:?} is a bag of {}; convert it to MCAP, for example by mcap convert {} out.mcap",
        if is_ros1 { "ROS 1" } else { "ROS 2 in SQLite" },
        plain(&path.to_string_lossy())
    );
    Ok(start.starts_with(b"\x89MCAP0\r\n"))
}

fn has_bag(folder: &Path) -> bool {
    let files = folder.read_dir().into_iter().flatten().flatten();
    files.map(|file| file.path()).any(|file| file.extension().is_some_and(|e| e == "mcap" || e == "db3"))
}

/// What is known of a topic after the first look.
#[derive(Default)]
struct Found {
    of: String,
    encoding: String,
    messages: usize,
}

impl Record {
    /// Looks through a record and finds the pairs of two topics.
    pub fn open(path: &Path, sides: [Option<&str>; 2]) -> Result<Self> {
        let mut look = Look::default();
        let mut messages = Messages::open(path)?;
        let infos = sides.map(|topic| topic.map(info_topic));
        let is_wanted = |topic: &Topic| {
            sides.contains(&Some(&topic.name)) || infos.iter().flatten().any(|info| *info == topic.name)
        };
        while let Some(message) = messages.next(is_wanted)? {
            look.at(&message.topic, &message.data, sides, &infos)
                .with_context(|| format!("{path:?}: a message of {}", plain(&message.topic.name)))?;
        }
        if messages.is_cut {
            warnings::warn(&format!("{path:?} is cut short; what is there is read (mcap recover repairs it)"));
        }
        let [Some(left), Some(right)] = sides else {
            bail!("{path:?} is a record; say by --left TOPIC and --right TOPIC where the images are; {}", look.topics())
        };
        for (option, topic) in [("left", left), ("right", right)] {
            look.ensure_images(path, option, topic)?;
        }
        ensure!(left != right, "--left and --right are both {left}; give the topics of two cameras");
        let partners = partners([&look.stamps[0], &look.stamps[1]]);
        look.report(path, &partners)?;
        let pair_of =
            [0, 1].map(|side| (0..).zip(&partners.pairs).map(|(pair, places)| (places[side], pair)).collect());
        Ok(Self {
            path: path.into(),
            topics: [left.into(), right.into()],
            messages: Messages::open(path)?,
            pair_of,
            read: [0; 2],
            waiting: HashMap::new(),
            calibration: look.calibration([left, right])?,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The images of the next pair, each with its own error, and when it was taken.
    pub fn next_pair(&mut self) -> Result<Option<(Result<[DynamicImage; 2]>, Taken)>> {
        let topics = &self.topics;
        while let Some(message) = self.messages.next(|topic| topics.contains(&topic.name))? {
            let Some(side) = self.topics.iter().position(|topic| *topic == message.topic.name) else { continue };
            let place = self.read[side];
            self.read[side] += 1;
            let Some(&pair) = self.pair_of[side].get(&place) else { continue };
            let this = Waiting { side, log_time: message.log_time, topic: message.topic, data: message.data };
            let Some(other) = self.waiting.remove(&pair) else {
                self.waiting.insert(pair, this);
                ensure!(
                    self.waiting.len() <= WAITING,
                    "{:?} has {WAITING} images of one camera before those of the other; sort it, for example by mcap sort",
                    self.path
                );
                continue;
            };
            let [left, right] = if side == 0 { [this, other] } else { [other, this] };
            let header = Header::read(&left.data).unwrap_or_default();
            let taken = Taken { header, log_time: left.log_time };
            let images = left.decode().and_then(|left| Ok([left, right.decode()?]));
            return Ok(Some((images, taken)));
        }
        Ok(None)
    }
}

impl Waiting {
    fn decode(&self) -> Result<DynamicImage> {
        let is_compressed = self.topic.of.ends_with("CompressedImage");
        let read = if is_compressed { ImageMessage::read_compressed } else { ImageMessage::read };
        let side = ["left", "right"][self.side];
        Ok(read(&self.data).map_err(|error| anyhow!("the {side} image: {error}"))?.picture)
    }
}

/// The topic of what a camera says of itself, beside that of its images.
fn info_topic(images: &str) -> String {
    let images = images.strip_suffix("/compressed").unwrap_or(images);
    let space = images.rsplit_once('/').map_or("", |(space, _)| space);
    format!("{space}/camera_info")
}

/// What a first look through a record finds.
#[derive(Default)]
struct Look {
    topics: BTreeMap<String, Found>,
    stamps: [Vec<i64>; 2],
    infos: [Option<CameraInfo>; 2],
}

impl Look {
    fn at(&mut self, topic: &Topic, data: &[u8], sides: [Option<&str>; 2], infos: &[Option<String>; 2]) -> Result<()> {
        let found = self.topics.entry(topic.name.clone()).or_insert_with(|| Found {
            of: topic.of.clone(),
            encoding: topic.encoding.clone(),
            messages: 0,
        });
        found.messages += 1;
        for side in [0, 1] {
            if sides[side] == Some(&topic.name) && topic.encoding == "cdr" && IMAGES.contains(&topic.of.as_str()) {
                self.stamps[side].push(Header::read(data)?.nanoseconds());
            }
            if infos[side].as_ref() == Some(&topic.name)
                && self.infos[side].is_none()
                && topic.of.ends_with("CameraInfo")
            {
                self.infos[side] = Some(CameraInfo::read(data)?);
            }
        }
        Ok(())
    }

    /// The topics of images, in words.
    fn topics(&self) -> String {
        let images = self.topics.iter().filter(|(_, found)| IMAGES.contains(&found.of.as_str()));
        let images: Vec<_> =
            images.map(|(name, found)| format!("{} ({} messages)", plain(name), found.messages)).collect();
        match images.is_empty() {
            true => "it has no topic of images".into(),
            false => format!("its topics of images are {}", images.join(", ")),
        }
    }

    fn ensure_images(&self, path: &Path, option: &str, topic: &str) -> Result<()> {
        let Some(found) = self.topics.get(topic) else {
            bail!("--{option} is {topic:?}, but {path:?} has no message of it; {}", self.topics())
        };
        ensure!(
            IMAGES.contains(&found.of.as_str()),
            "--{option} is {topic:?}, which has messages of {:?}, but images are needed; {}",
            found.of,
            self.topics()
        );
        ensure!(
            found.encoding == "cdr",
            "--{option} is {topic:?}, whose messages are encoded as {:?}, but those of ROS 2 (cdr) are read; convert the record",
            found.encoding
        );
        Ok(())
    }

    /// Says which images have no partner, and how far partners are apart.
    fn report(&self, path: &Path, partners: &Partners) -> Result<()> {
        let pairs = partners.pairs.len();
        ensure!(
            pairs > 0,
            "{path:?} has {} left and {} right images, but no two were taken at the same time; are the clocks in step?",
            self.stamps[0].len(),
            self.stamps[1].len()
        );
        let alone = self.stamps.each_ref().map(|stamps| stamps.len() - pairs);
        if alone != [0, 0] {
            warnings::warn(&format!(
                "{} left and {} right images have no partner taken at the same time, and are skipped",
                alone[0], alone[1]
            ));
        }
        if partners.apart >= APART {
            warnings::warn(&format!(
                "images of a pair were taken up to {:.3} ms apart: what moves meanwhile has a wrong disparity",
                partners.apart as f64 * 1e-6
            ));
        }
        Ok(())
    }

    /// The cameras by what they say of themselves. Images of a topic that is called raw are rectified by it.
    fn calibration(&self, topics: [&str; 2]) -> Result<Option<Calibration>> {
        let [Some(left), Some(right)] = &self.infos else { return Ok(None) };
        let raw = topics.iter().any(|topic| topic.contains("raw"));
        let found = CameraInfo::pair(left, right, raw).context("the cameras as camera_info says them")?;
        if found.as_ref().is_some_and(Calibration::has_lenses) {
            warnings::warn("the topics are raw, and are rectified by what camera_info says of the lenses");
        }
        Ok(found)
    }
}
