//! What an operator at the preview may ask for while frames come: pictures, recordings, marks.

use std::fs::{File, OpenOptions};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;

use serde_json::{Value, json};

use crate::preview::{Asked, Outcome, Picture, Request};
use crate::{CaptureError, Frame, LEAST_FREE_BYTES, Layout, Recorder, VideoKind, check_free};
use crate::{free_bytes, utc};

/// Columns of the file of marks.
const MARKS_HEADER: &str = "time_utc,left_time_ns,left_sequence,right_time_ns,right_sequence,\
                            event,name\n";
const SIDES: [&str; 2] = ["left", "right"];

/// Answers requests with the frames at hand. All files go into one folder, which is made when first
/// needed; `marks.csv` there has a line for everything that was asked for, with the time.
#[derive(Debug)]
pub struct Operator {
    folder: PathBuf,
    rate: [u32; 2],
    /// Something else records already, into the same folder.
    records_itself: bool,
    recording: Option<Recording>,
    saving: Arc<AtomicBool>,
    /// What went wrong last, until a recording begins again.
    failure: Option<String>,
}

/// A video of each eye.
#[derive(Debug)]
struct Recording {
    name: String,
    recorders: [Option<Recorder>; 2],
    frames: u64,
}

/// The frames of one moment.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// Left and right.
    pub eyes: [Option<Frame<'a>>; 2],
    /// The stitched picture.
    pub stitched: Option<Frame<'a>>,
}

impl Operator {
    /// Keeps what it is asked for in `folder`; videos say that they have `rate` (frames, in
    /// seconds). With `records_itself` the program records everything already.
    pub fn new(folder: &Path, rate: [u32; 2], records_itself: bool) -> Self {
        Self {
            folder: folder.to_owned(),
            rate,
            records_itself,
            recording: None,
            saving: Arc::default(),
            failure: None,
        }
    }

    /// Goes on recording, if told to. What goes wrong ends the recording and is told by
    /// [`Operator::status`].
    pub fn frames(&mut self, moment: &Moment<'_>) {
        let Some(recording) = &mut self.recording else {
            return;
        };
        if let Err(error) = recording.write(moment) {
            self.failure = Some(format!("the recording has ended: {error}"));
            self.recording = None;
        }
    }

    /// There are no more frames: a recording is over.
    pub fn end(&mut self) {
        self.recording = None;
    }

    /// Does what was asked. Pictures are encoded on a thread of their own.
    pub fn answer(&mut self, asked: Asked, moment: &Moment<'_>) {
        let time = utc(SystemTime::now());
        let outcome = match asked.request.clone() {
            Request::Snapshot => return self.snapshot(&time, asked, moment),
            Request::Record(true) => self.record(&time, moment),
            Request::Record(false) => self.end_recording(&time, moment),
            Request::Mark(name) => self
                .mark(&time, moment, "mark", &name)
                .map(|()| format!("marked \"{name}\" at {time}")),
        };
        asked.answer(outcome);
    }

    /// For the page: what is recorded, and how much room there is.
    pub fn status(&self) -> Value {
        let recording = self
            .recording
            .as_ref()
            .map(|recording| json!({ "name": recording.name, "frames": recording.frames }));
        let free_mb = free_bytes(&self.folder).ok().map(|bytes| bytes >> 20);
        json!({
            "folder": self.folder.to_string_lossy(), "recording": recording, "failure": self.failure,
            "records_itself": self.records_itself, "free_mb": free_mb,
            "needed_mb": LEAST_FREE_BYTES >> 20,
        })
    }

    fn snapshot(&mut self, time: &str, asked: Asked, moment: &Moment<'_>) {
        if self.saving.swap(true, Ordering::Relaxed) {
            return asked.answer(Err("the last pictures are still being saved".to_owned()));
        }
        if let Err(reason) = self.mark(time, moment, "snapshot", "") {
            self.saving.store(false, Ordering::Relaxed);
            return asked.answer(Err(reason));
        }
        let [left, right] = moment.eyes;
        let pictures: Vec<_> = [
            ("left", left),
            ("right", right),
            ("stitched", moment.stitched),
        ]
        .into_iter()
        .filter_map(|(name, frame)| {
            let path = self.folder.join(format!("{}-{name}.png", file_name(time)));
            Some((path, Picture::of(&frame?)))
        })
        .collect();
        let (saving, time) = (self.saving.clone(), time.to_owned());
        let save_all = move || {
            let saved = pictures
                .iter()
                .try_for_each(|(path, picture)| save(picture, path));
            saving.store(false, Ordering::Relaxed);
            asked.answer(saved.map(|()| format!("{} pictures of {time} saved", pictures.len())));
        };
        let thread = std::thread::Builder::new().name("snapshot".to_owned());
        if let Err(error) = thread.spawn(save_all) {
            self.saving.store(false, Ordering::Relaxed);
            self.failure = Some(format!("no pictures were saved: {error}"));
        }
    }

    fn record(&mut self, time: &str, moment: &Moment<'_>) -> Outcome {
        if self.records_itself {
            return Err("everything is recorded already".to_owned());
        }
        if let Some(recording) = &self.recording {
            return Err(format!("{} is being recorded already", recording.name));
        }
        let create = |(side, frame): (&str, Option<Frame<'_>>)| {
            let Some(frame) = frame else {
                return Ok(None);
            };
            let kind = match frame.format.layout {
                Layout::Mjpeg => VideoKind::Mjpeg,
                _ => VideoKind::Y4m,
            };
            let name = format!("{}-{side}.{}", file_name(time), kind.ending());
            Recorder::create(&self.folder.join(name), kind, self.rate).map(Some)
        };
        let [left, right] = moment.eyes;
        let recorders = create(("left", left))
            .and_then(|left| Ok([left, create(("right", right))?]))
            .map_err(|error| error.to_string())?;
        self.mark(time, moment, "record", "")?;
        self.failure = None;
        self.recording = Some(Recording {
            name: file_name(time),
            recorders,
            frames: 0,
        });
        Ok(format!("recording since {time}"))
    }

    fn end_recording(&mut self, time: &str, moment: &Moment<'_>) -> Outcome {
        let Some(recording) = self.recording.take() else {
            return Err("nothing is being recorded".to_owned());
        };
        self.mark(time, moment, "record ends", &recording.name)?;
        let Recording { name, frames, .. } = recording;
        Ok(format!("{name}: {frames} frames of each eye recorded"))
    }

    /// Adds a line to the file of marks.
    fn mark(&self, time: &str, moment: &Moment<'_>, event: &str, name: &str) -> Result<(), String> {
        let [left, right] = moment.eyes.map(|frame| {
            frame.map_or(",".to_owned(), |frame| {
                format!("{},{}", frame.time_ns, frame.sequence)
            })
        });
        let name = name.replace('"', "\"\"");
        let line = format!("{time},{left},{right},{event},\"{name}\"\n");
        self.append(&line)
            .map_err(|error| format!("not marked: {error}"))
    }

    fn append(&self, line: &str) -> Result<(), CaptureError> {
        let path = self.folder.join("marks.csv");
        check_free(&path, LEAST_FREE_BYTES)?;
        let io = |error| CaptureError::io(&path, error);
        std::fs::create_dir_all(&self.folder).map_err(io)?;
        let open = OpenOptions::new().append(true).create(true).open(&path);
        let mut file: File = open.map_err(io)?;
        let is_new = file.metadata().map_err(io)?.len() == 0;
        let header = if is_new { MARKS_HEADER } else { "" };
        // In one piece: a line is there or is not.
        file.write_all(format!("{header}{line}").as_bytes())
            .map_err(io)
    }
}

impl Recording {
    fn write(&mut self, moment: &Moment<'_>) -> Result<(), String> {
        // Frame n of both eyes was taken together: without one, neither is kept.
        let eyes = || self.recorders.iter().zip(moment.eyes);
        if eyes().any(|(recorder, frame)| recorder.is_some() && frame.is_none()) {
            return Ok(());
        }
        for ((recorder, frame), side) in self.recorders.iter_mut().zip(moment.eyes).zip(SIDES) {
            if let (Some(recorder), Some(frame)) = (recorder, frame)
                && !recorder.write(&frame).map_err(|error| error.to_string())?
            {
                return Err(format!("a frame of the {side} eye cannot be decoded"));
            }
        }
        self.frames += 1;
        Ok(())
    }
}

/// Writes a PNG file: under another name until it is whole on the disk.
fn save(picture: &Picture, path: &Path) -> Result<(), String> {
    let rgb = picture.rgb().ok_or("a frame cannot be decoded")?;
    let mut png = Cursor::new(Vec::new());
    let encoded = rgb.write_to(&mut png, image::ImageFormat::Png);
    let unfinished = path.with_extension("part");
    let write = || {
        let mut file = File::create(&unfinished)?;
        file.write_all(png.get_ref())?;
        file.sync_all()?;
        std::fs::rename(&unfinished, path)
    };
    let written = encoded
        .map_err(|error| error.to_string())
        .and_then(|()| write().map_err(|error| error.to_string()));
    written.map_err(|error| {
        // What is there of it is of no use, and takes room.
        let _ = std::fs::remove_file(&unfinished);
        format!("{}: {error}", path.display())
    })
}

/// A time as part of a file's name: without colons.
fn file_name(time: &str) -> String {
    time.replace(['-', ':'], "")
}
