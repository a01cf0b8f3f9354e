//! The bag: disparities, depths and points as messages of ROS 2 in a record, with the stamps of the left images.

use crate::args::InputArgs;
use crate::engine::pair::Pair;
use crate::engine::pipeline::{MatchedPair, Refused, Work};
use crate::engine::streams::{Stream, Taken};
use crate::engine::{disk, images, places};
use anyhow::{Context as _, Result};
use gpu_stereo::files::encoders::{ending, searched};
use gpu_stereo::files::images::ImagePair;
use gpu_stereo::files::ros::{self, DisparityRange, Schema};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempPath;

/// A record to write, whole or not at all.
pub struct Bag {
    path: PathBuf,
    place: PathBuf,
    /// What the topics begin with.
    space: String,
    writing: Mutex<Option<Writing>>,
}

/// A record that was begun.
struct Writing {
    writer: Writer<BufWriter<File>>,
    file: TempPath,
    /// The channel of each topic that has a message.
    channels: BTreeMap<&'static str, u16>,
    sequence: u32,
}

impl Bag {
    /// A record of the maps of these topics of images, once it is sure that it can be written.
    pub fn new(path: &Path, topics: [&str; 2]) -> Result<Self> {
        let place = places::writable_place(path)?;
        Ok(Self { path: path.into(), place, space: common_space(topics), writing: Mutex::new(None) })
    }

    fn add(&self, pair: &MatchedPair, taken: &Taken) -> Result<()> {
        let mut writing = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        let writing = match &mut *writing {
            Some(writing) => writing,
            none => none.insert(self.start()?),
        };
        let (header, params, matched) = (&taken.header, &pair.params, &pair.matched);
        let (first, last) = searched(params);
        let range = DisparityRange { searched: [first, last], camera: params.depth };
        let disparity = ros::disparity(header, &matched.map, &range);
        writing.message(&self.space, "disparity", &ros::DISPARITY, taken, &disparity)?;
        if let (Some(depth), Some(camera)) = (&matched.depth, &params.depth) {
            writing.message(&self.space, "depth", &ros::DEPTH, taken, &ros::depth(header, depth))?;
            let left = images::rectified(&pair.left, params, 0)?;
            let points = ros::points(header, depth, camera, &left);
            writing.message(&self.space, "points2", &ros::POINTS, taken, &points)?;
        }
        writing.sequence += 1;
        Ok(())
    }

    fn start(&self) -> Result<Writing> {
        let folder = self.place.parent().unwrap_or(Path::new("/"));
        let (file, temporary) = disk::temporary(folder, &format!(".{}", ending(&self.path)))?.into_parts();
        let library = concat!("gpu-stereo ", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().compression(Some(Compression::Zstd)).profile("ros2").library(library);
        let writer = options.create(BufWriter::new(file))?;
        Ok(Writing { writer, file: temporary, channels: BTreeMap::new(), sequence: 0 })
    }

    /// Ends the record and names it. Without any map there is no file.
    pub fn finish(self) -> Result<()> {
        let Some(mut writing) = self.writing.into_inner().unwrap_or_else(PoisonError::into_inner) else {
            return Ok(());
        };
        writing.writer.finish().map_err(|error| unwritten(&self.path, error))?;
        let contents = writing.writer.into_inner().into_inner().map_err(|error| error.into_error());
        let published = contents.and_then(|contents| disk::publish(&contents, writing.file, &self.place));
        published.map_err(|error| unwritten(&self.path, error))
    }
}

fn unwritten(path: &Path, error: impl Into<anyhow::Error>) -> anyhow::Error {
    disk::unwritten(error, format_args!("output {path:?}"))
}

impl Writing {
    fn message(&mut self, space: &str, name: &'static str, of: &Schema, taken: &Taken, data: &[u8]) -> Result<()> {
        let channel_id = match self.channels.get(name) {
            Some(id) => *id,
            None => {
                let schema = self.writer.add_schema(of.name, "ros2msg", of.definition.as_bytes())?;
                let quality = BTreeMap::from([("offered_qos_profiles".to_owned(), String::new())]);
                let id = self.writer.add_channel(schema, &format!("{space}/{name}"), "cdr", &quality)?;
                self.channels.insert(name, id);
                id
            }
        };
        let time = taken.log_time;
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time: time, publish_time: time };
        Ok(self.writer.write_to_known_channel(&header, data)?)
    }
}

/// The namespace that both topics are in: /stereo of /stereo/left/image_rect and /stereo/right/image_rect.
fn common_space(topics: [&str; 2]) -> String {
    let [left, right] = topics.map(|topic| topic.split('/').filter(|part| !part.is_empty()));
    let common = left.zip(right).take_while(|(left, right)| left == right);
    common.map(|(part, _)| format!("/{part}")).collect()
}

/// Pairs of a record, whose maps become messages of another.
pub struct FromRecord<'a> {
    /// The record that is read.
    pub stream: &'a Stream,
    /// The one that is written.
    pub bag: &'a Bag,
    /// When the pairs were taken that are not written yet.
    pub taken: Mutex<HashMap<usize, Taken>>,
}

impl FromRecord<'_> {
    fn taken(&self) -> MutexGuard<'_, HashMap<usize, Taken>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Work for FromRecord<'_> {
    fn read(&self, place: usize, _pair: &Pair, _options: &InputArgs) -> Result<ImagePair, Refused> {
        let (pair, taken) = self.stream.next_pair()?;
        self.taken().extend(taken.map(|taken| (place, taken)));
        Ok(pair)
    }

    fn write(&self, pair: &MatchedPair) -> Result<(), Refused> {
        let taken = self.taken().remove(&pair.place).context("the pair has no stamp").map_err(Refused::All)?;
        self.bag.add(pair, &taken).map_err(|error| Refused::All(unwritten(&self.bag.path, error)))
    }

    fn failed(&self, place: usize, _error: &str) -> Result<()> {
        self.taken().remove(&place);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_are_in_the_namespace_of_both_cameras() {
        assert_eq!(common_space(["/stereo/left/image_rect", "/stereo/right/image_rect"]), "/stereo");
        assert_eq!(common_space(["/left/image", "/right/image"]), "");
        assert_eq!(common_space(["a/b/c", "a/b/d"]), "/a/b");
    }
}
