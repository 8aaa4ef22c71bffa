//! What an operator at the preview may ask for while frames come: pictures, recordings, marks.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::SystemTime;

use serde_json::{Value, json};

use crate::preview::{Asked, Outcome, Picture, Request};
use crate::{
    CaptureError, Frame, Layout, MIN_FREE_BYTES, Recorder, Shot, VideoKind, check_free,
    describe_recording, free_bytes, utc,
};

/// Columns of the file of marks.
const MARKS_HEADER: &str = "time_utc,left_time_ns,left_sequence,right_time_ns,right_sequence,\
                            event,name\n";

/// Answers requests with the frames at hand. All files go into one folder, which is made when first
/// needed; `marks.csv` there has a line for everything that was asked for, with the time.
#[derive(Debug)]
pub struct Operator {
    folder: PathBuf,
    rate: [u32; 2],
    /// Something else records already, into the same folder.
    records_itself: bool,
    /// Name of each eye's source, and what else is known of it.
    sources: [Option<(String, Value)>; 2],
    /// Reads what else each eye's source is set to at this moment.
    read_settings: Option<ReadSettings>,
    /// What the cameras' controls were last set to while they run.
    controls: Option<String>,
    recording: Option<Recording>,
    recorded: Vec<Recorded>,
    /// Saves the last pictures that were asked for.
    saving: Option<JoinHandle<()>>,
    /// What went wrong last, until a recording begins again.
    failure: Option<String>,
}

/// As of [`Operator::with_settings`].
struct ReadSettings(Box<dyn Fn() -> [Option<Value>; 2] + Send>);

impl fmt::Debug for ReadSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ReadSettings").finish_non_exhaustive()
    }
}

/// A video of each eye.
#[derive(Debug)]
struct Recording {
    name: String,
    recorders: [Option<Recorder>; 2],
    /// Frames of each eye that there were to write.
    given: u64,
    left_out: u64,
}

/// What became of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recorded {
    /// What its files' names begin with.
    pub name: String,
    /// Frames of each eye that are on the disk.
    pub frames: u64,
    /// Moments at which an eye gave no frame, or one that cannot be decoded; the other's was left
    /// out.
    pub left_out: u64,
    /// Frames that did not reach the disk.
    pub lost: u64,
    /// What went wrong.
    pub failure: Option<String>,
}

impl fmt::Display for Recorded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} frames of each eye recorded",
            self.name, self.frames
        )?;
        if self.left_out > 0 {
            write!(f, ", {} left out for lack of an eye", self.left_out)?;
        }
        if self.lost > 0 {
            write!(f, ", {} lost", self.lost)?;
        }
        match &self.failure {
            Some(failure) => write!(f, ": {failure}"),
            None => Ok(()),
        }
    }
}

/// The frames of one moment.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// Left and right.
    pub eyes: Shot<'a>,
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
            sources: [None, None],
            read_settings: None,
            controls: None,
            recording: None,
            recorded: Vec::new(),
            saving: None,
            failure: None,
        }
    }

    /// Describes recordings by their sources: name of each eye's, and what else is known of it.
    #[must_use]
    pub fn with_sources(mut self, sources: [Option<(String, Value)>; 2]) -> Self {
        self.sources = sources;
        self
    }

    /// Describes recordings by what each eye's source is set to when they begin: objects whose members
    /// replace those of the same names in what was known before.
    #[must_use]
    pub fn with_settings(mut self, read: impl Fn() -> [Option<Value>; 2] + Send + 'static) -> Self {
        self.read_settings = Some(ReadSettings(Box::new(read)));
        self
    }

    /// Goes on recording, if told to. What goes wrong ends the recording and is told by
    /// [`Operator::status`].
    pub fn frames(&mut self, moment: &Moment<'_>) {
        let Some(recording) = &mut self.recording else {
            return;
        };
        if let Err(error) = recording.write(moment) {
            let recorded = self.finish(moment, Some(error));
            self.failure = recorded.map(|recorded| format!("the recording has ended: {recorded}"));
        }
    }

    /// There are no more frames: a recording is over, and whole on the disk, and so are pictures.
    pub fn end(&mut self) {
        if let Some(saving) = self.saving.take()
            && saving.join().is_err()
        {
            self.failure = Some("the last pictures were not saved".to_owned());
        }
        let nothing = Moment {
            eyes: [None, None],
            stitched: None,
        };
        if let Some(recorded) = self.finish(&nothing, None)
            && recorded.failure.is_some()
        {
            self.failure = Some(recorded.to_string());
        }
    }

    /// The recordings that have ended.
    pub fn recorded(&self) -> &[Recorded] {
        &self.recorded
    }

    /// Does what was asked. Pictures are encoded on a thread of their own.
    pub fn answer(&mut self, asked: Asked, moment: &Moment<'_>) {
        let time = utc(SystemTime::now());
        let outcome = match asked.request.clone() {
            Request::Snapshot => return self.snapshot(&time, asked, moment),
            Request::Record(true) => self.record(&time, moment),
            Request::Record(false) => self.end_recording(moment),
            Request::NoteControls(words) => self.note_controls(&time, moment, words),
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
            .map(|recording| json!({ "name": recording.name, "frames": recording.given }));
        let free_mb = free_bytes(&self.folder).ok().map(|bytes| bytes >> 20);
        json!({
            "folder": self.folder.to_string_lossy(), "recording": recording, "failure": self.failure,
            "records_itself": self.records_itself, "free_mb": free_mb,
            "needed_mb": MIN_FREE_BYTES >> 20,
        })
    }

    fn snapshot(&mut self, time: &str, asked: Asked, moment: &Moment<'_>) {
        if self
            .saving
            .as_ref()
            .is_some_and(|saving| !saving.is_finished())
        {
            return asked.answer(Err("the last pictures are still being saved".to_owned()));
        }
        if let Err(reason) = self.mark(time, moment, "snapshot", "") {
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
        let time = time.to_owned();
        let save_all = move || {
            let saved = pictures
                .iter()
                .try_for_each(|(path, picture)| save(picture, path));
            asked.answer(saved.map(|()| format!("{} pictures of {time} saved", pictures.len())));
        };
        let thread = std::thread::Builder::new().name("snapshot".to_owned());
        match thread.spawn(save_all) {
            Ok(saving) => self.saving = Some(saving),
            Err(error) => self.failure = Some(format!("no pictures were saved: {error}")),
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
        // The other one may be away just now; it is not recorded when it comes back.
        let which = match recorders {
            [Some(_), None] => ", the left eye alone",
            [None, Some(_)] => ", the right eye alone",
            _ => "",
        };
        let name = file_name(time);
        self.mark(time, moment, "record", &name)?;
        self.describe(&name, moment)
            .map_err(|error| error.to_string())?;
        self.failure = None;
        self.recording = Some(Recording {
            name,
            recorders,
            given: 0,
            left_out: 0,
        });
        Ok(format!("recording since {time}{which}"))
    }

    fn end_recording(&mut self, moment: &Moment<'_>) -> Outcome {
        let Some(recorded) = self.finish(moment, None) else {
            return Err("nothing is being recorded".to_owned());
        };
        if recorded.failure.is_some() {
            return Err(recorded.to_string());
        }
        Ok(recorded.to_string())
    }

    /// Ends the recording, if there is one, and waits until all of it is on the disk.
    fn finish(&mut self, moment: &Moment<'_>, failure: Option<String>) -> Option<Recorded> {
        let recording = self.recording.take()?;
        let time = utc(SystemTime::now());
        let marked = self.mark(&time, moment, "record ends", &recording.name);
        let mut recorded = recording.finish();
        recorded.failure = failure.or(recorded.failure).or(marked.err());
        self.recorded.push(recorded.clone());
        Some(recorded)
    }

    /// Exposure and gain have changed: a recording that is under way says so.
    fn note_controls(&mut self, time: &str, moment: &Moment<'_>, words: String) -> Outcome {
        let noted = if self.records_itself || self.recording.is_some() {
            self.mark(time, moment, "controls", &words)
        } else {
            Ok(())
        };
        self.controls = Some(words.clone());
        noted.map(|()| words)
    }

    /// Writes what the recording `name` is made with beside it.
    fn describe(&self, name: &str, moment: &Moment<'_>) -> Result<(), CaptureError> {
        let read = self.read_settings.as_ref();
        let settings = read.map_or([None, None], |ReadSettings(read)| read());
        let of = |i: usize| {
            let ((source, facts), frame) = (self.sources[i].as_ref()?, moment.eyes[i]?);
            let mut facts = facts.clone();
            if let (Some(facts), Some(Value::Object(now))) = (facts.as_object_mut(), &settings[i]) {
                facts.extend(now.clone());
            }
            Some((&**source, frame.format, facts))
        };
        let mut about = describe_recording(self.rate, [of(0), of(1)]);
        about["controls_set_while_running"] = json!(self.controls);
        let path = self.folder.join(format!("{name}.json"));
        write_whole(&path, format!("{about:#}\n").as_bytes())
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
        check_free(&path, MIN_FREE_BYTES)?;
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

impl Drop for Operator {
    /// Whatever ends the program: recordings and pictures are whole.
    fn drop(&mut self) {
        self.end();
    }
}

impl Recording {
    fn write(&mut self, moment: &Moment<'_>) -> Result<(), String> {
        let written = Recorder::write_shot(&mut self.recorders, &moment.eyes);
        match written {
            Ok(false) => self.left_out += 1,
            // What cannot be written is lost, and counts as that.
            Ok(true) | Err(_) => self.given += 1,
        }
        written.map(|_| ()).map_err(|error| error.to_string())
    }

    fn finish(mut self) -> Recorded {
        let mut failure = None;
        let mut frames = self.given;
        for recorder in self.recorders.iter_mut().flatten() {
            if let Err(error) = recorder.finish() {
                failure.get_or_insert(error.to_string());
            }
            frames = frames.min(recorder.frames());
        }
        Recorded {
            name: self.name,
            frames,
            left_out: self.left_out,
            lost: self.given - frames,
            failure,
        }
    }
}

/// Writes a PNG file.
fn save(picture: &Picture, path: &Path) -> Result<(), String> {
    let rgb = picture.rgb().ok_or("a frame cannot be decoded")?;
    let mut png = Cursor::new(Vec::new());
    let encoded = rgb.write_to(&mut png, image::ImageFormat::Png);
    encoded.map_err(|error| format!("{}: {error}", path.display()))?;
    write_whole(path, png.get_ref()).map_err(|error| error.to_string())
}

/// Writes a file under another name until it is whole on the disk.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), CaptureError> {
    let unfinished = path.with_extension("part");
    let write = || {
        let mut file = File::create(&unfinished)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&unfinished, path)
    };
    write().map_err(|error| {
        // What is there of it is of no use, and takes room.
        let _ = std::fs::remove_file(&unfinished);
        CaptureError::io(path, error)
    })
}

/// A time as part of a file's name: without colons.
fn file_name(time: &str) -> String {
    time.replace(['-', ':'], "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_is_told_with_what_it_lacks() {
        let mut recorded = Recorded {
            name: "dive".to_owned(),
            frames: 40,
            left_out: 0,
            lost: 0,
            failure: None,
        };
        assert_eq!(recorded.to_string(), "dive: 40 frames of each eye recorded");
        recorded.left_out = 2;
        recorded.lost = 3;
        recorded.failure = Some("the disk is full".to_owned());
        assert_eq!(
            recorded.to_string(),
            "dive: 40 frames of each eye recorded, 2 left out for lack of an eye, 3 lost: \
             the disk is full"
        );
    }
}
