//! The reader: frame after frame from any source of bytes, in whichever of the forms it is.

use super::raw::RawFrames;
use super::{Packing, pam, y4m};
use crate::files::error::{Context as _, Result, bail, ensure};
use image::DynamicImage;
use std::io::{BufRead, Read as _};

/// Reads the frames of a stream.
#[derive(Debug)]
pub struct FrameReader<R> {
    source: R,
    form: Form,
    frames: u64,
}

#[derive(Debug)]
enum Form {
    Y4m(y4m::Header),
    Raw(RawFrames),
    Pam,
}

impl<R: BufRead> FrameReader<R> {
    /// Reads the beginning of a stream of Y4M or PAM frames, which tells which of them it is, or expects `raw` frames.
    ///
    /// # Errors
    /// If the stream cannot be read or is of neither kind.
    pub fn open(mut source: R, raw: Option<RawFrames>) -> Result<Self> {
        let form = match raw {
            Some(raw) => Form::Raw(raw),
            None => {
                let start = source.fill_buf().with_context(|| "the stream cannot be read")?;
                match start {
                    [] => bail!("the stream has no byte; see what the program before the pipe says"),
                    [b'Y', ..] => Form::Y4m(y4m::header(&mut source)?),
                    [b'P', ..] => Form::Pam,
                    _ => bail!(
                        "the stream is neither Y4M nor PAM; give ffmpeg -f yuv4mpegpipe -pix_fmt yuv420p, or say what raw \
                         frames are by --raw-frames, such as 1280x480:yuyv"
                    ),
                }
            }
        };
        Ok(Self { source, form, frames: 0 })
    }

    /// Frames a second, if the stream says them.
    pub fn rate(&self) -> Option<f64> {
        if let Form::Y4m(header) = &self.form { header.rate } else { None }
    }

    /// The next frame; `None` at the end of the stream.
    ///
    /// # Errors
    /// If the stream cannot be read, is damaged or ends within a frame. Nothing can be read after that.
    pub fn next_frame(&mut self) -> Result<Option<DynamicImage>> {
        let number = self.frames;
        let frame = self.read().with_context(|| format!("frame {number}"))?;
        self.frames += u64::from(frame.is_some());
        Ok(frame)
    }

    fn read(&mut self) -> Result<Option<DynamicImage>> {
        let (width, height, packing) = match &self.form {
            Form::Y4m(header) => {
                if !y4m::begins_frame(&mut self.source)? {
                    return Ok(None);
                }
                (header.width, header.height, header.packing)
            }
            Form::Raw(raw) => {
                if self.source.fill_buf()?.is_empty() {
                    return Ok(None);
                }
                (raw.width, raw.height, raw.packing)
            }
            Form::Pam => match pam::header(&mut self.source)? {
                Some(header) => header,
                None => return Ok(None),
            },
        };
        let bytes = self.pixels(packing, width, height)?;
        packing.picture(width, height, bytes).map(Some)
    }

    /// The bytes of a frame. Memory is only taken as bytes arrive, since a header can declare anything.
    fn pixels(&mut self, packing: Packing, width: u32, height: u32) -> Result<Vec<u8>> {
        let length = packing.frame_bytes(width, height)?;
        let mut bytes = Vec::new();
        (&mut self.source).take(length as u64).read_to_end(&mut bytes)?;
        ensure!(
            bytes.len() == length,
            "it is cut short: the stream ended after {} of its {length} bytes; is it really of {width}x{height} pixels?",
            bytes.len()
        );
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(bytes: &[u8], raw: Option<&str>) -> Result<Vec<DynamicImage>> {
        let mut reader = FrameReader::open(bytes, raw.map(|raw| raw.parse().unwrap()))?;
        let mut frames = Vec::new();
        while let Some(frame) = reader.next_frame()? {
            frames.push(frame);
        }
        Ok(frames)
    }

    fn y4m(header: &str, frames: &[&[u8]]) -> Vec<u8> {
        let frames = frames.iter().map(|frame| [b"FRAME\n", *frame].concat());
        [format!("YUV4MPEG2 {header}\n").into_bytes(), frames.collect::<Vec<_>>().concat()].concat()
    }

    #[test]
    fn each_form_is_told_by_its_beginning() {
        let gray = y4m("W2 H1 F30:1 Ip A1:1 Cmono XYSCSS=420", &[&[1, 2], &[3, 4]]);
        let read = frames(&gray, None).unwrap();
        assert_eq!(read.iter().map(|frame| frame.to_luma8().into_raw()).collect::<Vec<_>>(), [[1, 2], [3, 4]]);
        assert_eq!(FrameReader::open(&gray[..], None).unwrap().rate(), Some(30.0));
        let deep = y4m("W1 H1 Cmono12", &[&[2, 1]]);
        assert_eq!(frames(&deep, None).unwrap()[0].to_luma16().into_raw(), [0x0102]);
        let pam = b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n\x01\x02\x03";
        let read = frames(&pam.repeat(2), None).unwrap();
        assert_eq!((read.len(), read[1].to_rgb8().into_raw()), (2, vec![1, 2, 3]));
        let read = frames(&[1, 2, 3, 4], Some("2x1:gray")).unwrap();
        assert_eq!(read[1].to_luma8().into_raw(), [3, 4]);
        assert!(frames(&[], Some("2x1:gray")).unwrap().is_empty());
        assert!(frames(&y4m("W2 H1 Cmono", &[]), None).unwrap().is_empty());
    }

    #[test]
    fn what_is_damaged_is_refused_in_words() {
        for (bytes, raw, words) in [
            (Vec::new(), None, "no byte"),
            (b"GIF89a".to_vec(), None, "--raw-frames"),
            (b"YUV4MPEG3 W2\n".to_vec(), None, "in place of YUV4MPEG2"),
            (y4m("W2 H0 Cmono", &[]), None, "2x0"),
            (y4m("Wx H0 Cmono", &[]), None, "\"Wx\""),
            (y4m("W2 H2 C420p11", &[]), None, "C420p11"),
            (
                y4m("W2 H1 Cmono", &[&[1, 2], &[1]]),
                None,
                "frame 1: it is cut short: the stream ended after 1 of its 2 bytes",
            ),
            (y4m("W2 H1 Cmono", &[&[1, 2, 3]]), None, "frame 1: a line of its header has no end"),
            ([y4m("W2 H1 Cmono", &[]), b"FRAMES\n".to_vec()].concat(), None, "in place of FRAME"),
            (vec![1, 2, 3], Some("2x1:gray"), "frame 1: it is cut short"),
            (b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 2\nMAXVAL 255\nENDHDR\n".to_vec(), None, "2 samples a pixel"),
            (b"P7\nWIDTH 99999\nHEIGHT 99999\nDEPTH 1\nMAXVAL 255\nENDHDR\n".to_vec(), None, "99999x99999"),
            (b"P7\nWIDTH 10000\nHEIGHT 10000\nDEPTH 1\nMAXVAL 255\nENDHDR\n12".to_vec(), None, "cut short"),
            (vec![b'Y'; 9000], None, "has no end"),
        ] {
            let told = frames(&bytes, raw).unwrap_err().to_string();
            assert!(told.contains(words), "{words}: {told}");
        }
    }
}
