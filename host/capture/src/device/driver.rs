//! The driver's interface where the `v4l` crate does not reach: formats of devices with several
//! planes, and streaming from mapped buffers, which that crate can neither start when asked nor do
//! with several planes. The one place with system calls of our own.
#![allow(unsafe_code)]

use std::ffi::c_void;
use std::io;
use std::mem::zeroed;
use std::sync::Arc;
use std::time::Duration;

use v4l::buffer::{Flags, Type};
use v4l::device::Handle;
use v4l::memory::Memory;
use v4l::v4l_sys::{
    v4l2_buffer, v4l2_fmtdesc, v4l2_format, v4l2_plane, v4l2_requestbuffers, v4l2_streamparm,
};
use v4l::v4l2::{ioctl, mmap, munmap, vidioc};

/// `poll` for readable (POSIX).
const POLLIN: i16 = 1;
/// `PROT_READ` and `MAP_SHARED` of <sys/mman.h>, the same on every Linux.
const PROT_READ: i32 = 1;
const MAP_SHARED: i32 = 1;
/// `V4L2_FIELD_NONE` of <linux/videodev2.h>: whole frames, not interlaced.
pub(super) const FIELD_NONE: u32 = 1;
/// `VIDEO_MAX_PLANES` of <linux/videodev2.h>.
const MAX_PLANES: usize = 8;
/// Formats that a driver may list; more are a driver that never ends its list.
const MAX_FORMATS: u32 = 256;

/// Asks the driver one thing; `answer` holds the question and then the answer.
fn ask<T>(handle: &Handle, request: vidioc::_IOC_TYPE, answer: &mut T) -> io::Result<()> {
    // SAFETY: every request below names the structure that its number belongs to; the driver
    // reads and writes no more than that.
    unsafe {
        ioctl(
            handle.fd(),
            request,
            std::ptr::from_mut(answer).cast::<c_void>(),
        )
    }
}

/// Picture format as the driver states it, for one plane or several.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct PictureFormat {
    /// Four-character code.
    pub fourcc: [u8; 4],
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// From row to row of each plane, bytes.
    pub row_bytes: [u32; MAX_PLANES],
    /// Separate buffers to a frame.
    pub planes: usize,
    /// `enum v4l2_colorspace`.
    pub colorspace: u32,
    /// `enum v4l2_quantization`.
    pub quantization: u32,
    /// `enum v4l2_field`.
    pub field: u32,
}

/// A device opened for capture, through the interface for one plane or for several.
#[derive(Clone)]
pub(super) struct Driver {
    handle: Arc<Handle>,
    kind: Type,
}

impl Driver {
    /// Interface of a device; `several_planes` where its capabilities say multi-planar.
    pub fn new(handle: Arc<Handle>, several_planes: bool) -> Self {
        let kind = if several_planes {
            Type::VideoCaptureMplane
        } else {
            Type::VideoCapture
        };
        Self { handle, kind }
    }

    fn has_several_planes(&self) -> bool {
        matches!(self.kind, Type::VideoCaptureMplane)
    }

    /// Four-character codes of all formats on offer.
    pub fn formats(&self) -> io::Result<Vec<[u8; 4]>> {
        let mut codes = Vec::new();
        for index in 0..MAX_FORMATS {
            // SAFETY: all zeros is a value of this structure of numbers.
            let mut question: v4l2_fmtdesc = unsafe { zeroed() };
            question.index = index;
            question.type_ = self.kind as u32;
            match ask(&self.handle, vidioc::VIDIOC_ENUM_FMT, &mut question) {
                Ok(()) => codes.push(question.pixelformat.to_le_bytes()),
                // The end of the list.
                Err(error) if error.kind() == io::ErrorKind::InvalidInput => break,
                Err(error) => return Err(error),
            }
        }
        Ok(codes)
    }

    /// The format that is set.
    pub fn format(&self) -> io::Result<PictureFormat> {
        let mut format = self.empty_format();
        ask(&self.handle, vidioc::VIDIOC_G_FMT, &mut format)?;
        Ok(self.read(&format))
    }

    /// Sets layout and size; what the driver made of it.
    pub fn set_format(&self, fourcc: [u8; 4], size_px: [u32; 2]) -> io::Result<PictureFormat> {
        let mut format = self.empty_format();
        let [width, height] = size_px;
        let code = u32::from_le_bytes(fourcc);
        if self.has_several_planes() {
            let mut picture = v4l::v4l_sys::v4l2_pix_format_mplane {
                width,
                height,
                pixelformat: code,
                field: FIELD_NONE,
                // SAFETY: all zeros is a value of this structure of numbers.
                ..unsafe { zeroed() }
            };
            picture.num_planes = 1;
            format.fmt.pix_mp = picture;
        } else {
            format.fmt.pix = v4l::v4l_sys::v4l2_pix_format {
                width,
                height,
                pixelformat: code,
                field: FIELD_NONE,
                // SAFETY: as above.
                ..unsafe { zeroed() }
            };
        }
        ask(&self.handle, vidioc::VIDIOC_S_FMT, &mut format)?;
        Ok(self.read(&format))
    }

    fn empty_format(&self) -> v4l2_format {
        // SAFETY: all zeros is a value of this structure of numbers.
        let mut format: v4l2_format = unsafe { zeroed() };
        format.type_ = self.kind as u32;
        format
    }

    fn read(&self, format: &v4l2_format) -> PictureFormat {
        if self.has_several_planes() {
            // SAFETY: the driver fills this part for this kind; any bits are numbers.
            let picture = unsafe { format.fmt.pix_mp };
            let planes = picture.plane_fmt;
            PictureFormat {
                fourcc: { picture.pixelformat }.to_le_bytes(),
                size_px: [picture.width, picture.height],
                row_bytes: planes.map(|plane| plane.bytesperline),
                planes: usize::from(picture.num_planes).clamp(1, MAX_PLANES),
                colorspace: picture.colorspace,
                quantization: picture.quantization.into(),
                field: picture.field,
            }
        } else {
            // SAFETY: as above.
            let picture = unsafe { format.fmt.pix };
            let mut row_bytes = [0; MAX_PLANES];
            row_bytes[0] = picture.bytesperline;
            PictureFormat {
                fourcc: picture.pixelformat.to_le_bytes(),
                size_px: [picture.width, picture.height],
                row_bytes,
                planes: 1,
                colorspace: picture.colorspace,
                quantization: picture.quantization,
                field: picture.field,
            }
        }
    }

    /// From frame to frame as it is set, ns; `None` where the driver does not say.
    pub fn period_ns(&self) -> io::Result<Option<u64>> {
        let mut parameters = self.empty_parameters();
        ask(&self.handle, vidioc::VIDIOC_G_PARM, &mut parameters)?;
        Ok(period_ns(&parameters))
    }

    /// Asks for a rate, frames a second; what the driver made of it, ns from frame to frame.
    pub fn set_rate(&self, hz: u32) -> io::Result<Option<u64>> {
        let mut parameters = self.empty_parameters();
        let mut capture = v4l::v4l_sys::v4l2_captureparm {
            // SAFETY: all zeros is a value of this structure of numbers.
            ..unsafe { zeroed() }
        };
        capture.timeperframe.numerator = 1;
        capture.timeperframe.denominator = hz;
        parameters.parm.capture = capture;
        ask(&self.handle, vidioc::VIDIOC_S_PARM, &mut parameters)?;
        Ok(period_ns(&parameters))
    }

    fn empty_parameters(&self) -> v4l2_streamparm {
        // SAFETY: all zeros is a value of this structure of numbers.
        let mut parameters: v4l2_streamparm = unsafe { zeroed() };
        parameters.type_ = self.kind as u32;
        parameters
    }

    /// A description of a buffer, with room for its planes where there are several.
    fn buffer(&self, planes: &mut [v4l2_plane; MAX_PLANES]) -> v4l2_buffer {
        // SAFETY: all zeros is a value of this structure of numbers and pointers.
        let mut buffer: v4l2_buffer = unsafe { zeroed() };
        buffer.type_ = self.kind as u32;
        buffer.memory = Memory::Mmap as u32;
        if self.has_several_planes() {
            buffer.length = MAX_PLANES as u32;
            buffer.m.planes = planes.as_mut_ptr();
        }
        buffer
    }

    fn request_buffers(&self, count: u32) -> io::Result<u32> {
        // SAFETY: all zeros is a value of this structure of numbers.
        let mut request: v4l2_requestbuffers = unsafe { zeroed() };
        request.count = count;
        request.type_ = self.kind as u32;
        request.memory = Memory::Mmap as u32;
        ask(&self.handle, vidioc::VIDIOC_REQBUFS, &mut request)?;
        Ok(request.count)
    }

    fn turn(&self, request: vidioc::_IOC_TYPE) -> io::Result<()> {
        let mut kind = self.kind as u32;
        ask(&self.handle, request, &mut kind)
    }
}

fn period_ns(parameters: &v4l2_streamparm) -> Option<u64> {
    // SAFETY: the driver fills this part for capture; any bits are numbers.
    let interval = unsafe { parameters.parm.capture }.timeperframe;
    let [n, d] = [interval.numerator, interval.denominator].map(u64::from);
    (n > 0 && d > 0).then(|| n * 1_000_000_000 / d)
}

// Where a long has 32 bits, so have these.
#[allow(clippy::useless_conversion)]
fn ns(time: v4l::v4l_sys::timeval) -> i64 {
    i64::from(time.tv_sec)
        .wrapping_mul(1_000_000_000)
        .wrapping_add(i64::from(time.tv_usec) * 1000)
}

fn no_planes() -> [v4l2_plane; MAX_PLANES] {
    // SAFETY: all zeros is a value of this structure of numbers.
    unsafe { zeroed() }
}

/// Memory of one plane of a buffer.
struct Mapping {
    start: *mut c_void,
    bytes: usize,
}

// SAFETY: the memory belongs to the mapping alone, whichever thread holds it.
unsafe impl Send for Mapping {}

impl Mapping {
    fn new(handle: &Handle, bytes: u32, offset: u32) -> io::Result<Self> {
        let bytes = bytes as usize;
        let start = std::ptr::null_mut();
        let offset = offset.into();
        // SAFETY: a new mapping where the system likes; nothing of ours lies there.
        let start = unsafe { mmap(start, bytes, PROT_READ, MAP_SHARED, handle.fd(), offset)? };
        Ok(Self { start, bytes })
    }

    fn data(&self) -> &[u8] {
        // SAFETY: mapped for reading over this length until dropped.
        unsafe { std::slice::from_raw_parts(self.start.cast::<u8>(), self.bytes) }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: mapped by `new` with this length, and not borrowed any more. What the system
        // could complain about is nothing that could be done better.
        let _ = unsafe { munmap(self.start, self.bytes) };
    }
}

/// A buffer that the driver has filled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Filled {
    index: usize,
    /// First byte and end of what each plane holds.
    used: [[usize; 2]; MAX_PLANES],
    /// The driver says that its content is damaged.
    pub is_damaged: bool,
    /// When it was taken, ns.
    pub time_ns: i64,
    /// Counts the frames that the device made.
    pub sequence: u32,
}

/// A running stream; dropping it stops the device and gives its buffers back.
pub(super) struct Stream {
    driver: Driver,
    buffers: Vec<Vec<Mapping>>,
    held: Option<usize>,
}

impl Stream {
    /// Maps `count` buffers, hands them to the driver and starts the device.
    ///
    /// # Errors
    /// What the driver says, be it that there is no room on the bus for what it would send.
    pub fn start(driver: &Driver, count: u32) -> io::Result<Self> {
        let granted = driver.request_buffers(count)?;
        let mut stream = Self {
            driver: driver.clone(),
            buffers: Vec::new(),
            held: None,
        };
        for index in 0..granted {
            let mut planes = no_planes();
            let mut buffer = driver.buffer(&mut planes);
            buffer.index = index;
            ask(&driver.handle, vidioc::VIDIOC_QUERYBUF, &mut buffer)?;
            let map = |bytes, offset| Mapping::new(&driver.handle, bytes, offset);
            let mapped = if driver.has_several_planes() {
                let count = (buffer.length as usize).min(MAX_PLANES);
                let planes = planes[..count].iter();
                // SAFETY: the driver fills the offset for mapped buffers.
                let planes = planes.map(|plane| map(plane.length, unsafe { plane.m.mem_offset }));
                planes.collect::<io::Result<Vec<_>>>()?
            } else {
                // SAFETY: as above.
                vec![map(buffer.length, unsafe { buffer.m.offset })?]
            };
            stream.buffers.push(mapped);
        }
        for index in 0..stream.buffers.len() {
            stream.queue(index)?;
        }
        driver.turn(vidioc::VIDIOC_STREAMON)?;
        Ok(stream)
    }

    fn queue(&self, index: usize) -> io::Result<()> {
        let mut planes = no_planes();
        let mut buffer = self.driver.buffer(&mut planes);
        buffer.index = index as u32;
        ask(&self.driver.handle, vidioc::VIDIOC_QBUF, &mut buffer)
    }

    /// Gives the last buffer back and waits for the next; `None` if none came in time.
    pub fn next(&mut self, within: Duration) -> io::Result<Option<Filled>> {
        if let Some(index) = self.held.take() {
            self.queue(index)?;
        }
        let within_ms = i32::try_from(within.as_millis()).unwrap_or(i32::MAX);
        match self.driver.handle.poll(POLLIN, within_ms) {
            Ok(0) => return Ok(None),
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return Ok(None),
            Err(error) => return Err(error),
        }
        let mut planes = no_planes();
        let mut buffer = self.driver.buffer(&mut planes);
        match ask(&self.driver.handle, vidioc::VIDIOC_DQBUF, &mut buffer) {
            Ok(()) => {}
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
                ) =>
            {
                return Ok(None);
            }
            Err(error) => return Err(error),
        }
        let index = buffer.index as usize;
        let Some(mapped) = self.buffers.get(index) else {
            return Err(io::Error::other(
                "the driver returned a buffer that it was not given",
            ));
        };
        self.held = Some(index);
        let mut used = [[0; 2]; MAX_PLANES];
        if self.driver.has_several_planes() {
            for ((used, plane), mapped) in used.iter_mut().zip(&planes).zip(mapped) {
                let end = (plane.bytesused as usize).min(mapped.bytes);
                *used = [(plane.data_offset as usize).min(end), end];
            }
        } else {
            used[0] = [0, (buffer.bytesused as usize).min(mapped[0].bytes)];
        }
        Ok(Some(Filled {
            index,
            used,
            is_damaged: Flags::from(buffer.flags).contains(Flags::ERROR),
            time_ns: ns(buffer.timestamp),
            sequence: buffer.sequence,
        }))
    }

    /// What a plane of a filled buffer holds; empty where there is no such plane.
    pub fn plane(&self, filled: &Filled, plane: usize) -> &[u8] {
        let mapped = self.buffers.get(filled.index).and_then(|b| b.get(plane));
        let [from, to] = filled.used.get(plane).copied().unwrap_or_default();
        mapped.map_or(&[], |mapped| &mapped.data()[from..to])
    }

    /// Whether a further frame is waiting already.
    pub fn has_more(&self) -> bool {
        let ready = self.driver.handle.poll(POLLIN, 0);
        ready.is_ok_and(|ready| ready > 0)
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        // A device that is gone refuses both, and has forgotten the buffers all the same.
        let _ = self.driver.turn(vidioc::VIDIOC_STREAMOFF);
        self.buffers.clear();
        let _ = self.driver.request_buffers(0);
    }
}
