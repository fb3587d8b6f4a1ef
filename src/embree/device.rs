//! Embree's device: errors and memory.

use super::isa::Isa;
use super::sys;
use crate::{Error, Result};
use std::ffi::{CString, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

/// An Embree device. It is created once, and shared by what is made from it.
pub struct Device {
    handle: sys::RTCDevice,
    /// The largest instruction set that it was allowed.
    isa_limit: Option<Isa>,
    /// Boxed, as Embree keeps its address.
    memory: Box<Memory>,
}

/// What Embree may take, in bytes.
struct Memory {
    held: AtomicI64,
    limit: i64,
}

// SAFETY: Embree's device functions may be called from any thread (manual, "Thread safety"); the handle is
// released once, by the last owner.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// A device whose builds use at most `threads` threads (0: all of the machine's), held to [`Isa::chosen`].
    ///
    /// # Errors
    /// As [`Isa::chosen`] and [`Device::held_to`].
    pub fn new(threads: usize) -> Result<Arc<Device>> {
        Device::held_to(Isa::chosen()?, threads)
    }

    /// The same with an instruction set of its own; `None`: the largest that the processor has.
    ///
    /// # Errors
    /// Where Embree refuses, or where the library is of another minor version than the headers it was built with.
    pub fn held_to(isa: Option<Isa>, threads: usize) -> Result<Arc<Device>> {
        let free = crate::io::memory::free().and_then(|bytes| i64::try_from(bytes).ok());
        Device::within(free.unwrap_or(i64::MAX), isa, threads)
    }

    /// The same with `limit` bytes at most: what is beyond that is an error of whoever asks for it.
    pub(super) fn within(limit: i64, isa: Option<Isa>, threads: usize) -> Result<Arc<Device>> {
        let held_to = isa.map_or(String::new(), |isa| format!(",max_isa={}", isa.name()));
        let config = CString::new(format!("threads={threads}{held_to}")).expect("names and digits hold no NUL");
        // SAFETY: the string is NUL-terminated and only read during the call.
        let handle = unsafe { sys::rtcNewDevice(config.as_ptr()) };
        if handle.is_null() {
            // SAFETY: a null device asks for the thread's own error.
            let code = unsafe { sys::rtcGetDeviceError(handle) };
            return Err(Error::Embree(format!("no device could be made: {}", describe(code))));
        }
        let memory = Box::new(Memory { held: AtomicI64::new(0), limit });
        let device = Device { handle, isa_limit: isa, memory };
        device.check_version()?;
        let counter: *const Memory = &*device.memory;
        // SAFETY: the counter is boxed and dropped after the device has been released (see `drop`).
        unsafe { sys::rtcSetDeviceMemoryMonitorFunction(handle, Some(count_memory), counter.cast_mut().cast()) };
        Ok(Arc::new(device))
    }

    /// Version of the library that runs, as major·10000 + minor·100 + patch.
    pub(crate) fn version(&self) -> u32 {
        // SAFETY: the handle is live.
        unsafe { sys::rtcGetDeviceProperty(self.handle, sys::RTC_DEVICE_PROPERTY_VERSION) as u32 }
    }

    /// The instruction set that Embree uses; `None` for less than SSE4.2, and for other processors than x86-64.
    ///
    /// Embree tells only the widest packets that it has kernels for; what lies between follows from the processor and
    /// from what this device was allowed.
    pub(crate) fn isa(&self) -> Option<Isa> {
        let width = match self.packet_width() {
            16 => Isa::Avx512,
            8 => Isa::Avx2,
            _ => Isa::Sse42,
        };
        Isa::available().take_while(|isa| *isa <= width && self.isa_limit.is_none_or(|limit| *isa <= limit)).last()
    }

    /// Rays of a packet for which there are kernels: 16, 8 or 4.
    pub(crate) fn packet_width(&self) -> usize {
        match (self.native_ray16(), self.native_ray8()) {
            (true, _) => 16,
            (false, true) => 8,
            (false, false) => 4,
        }
    }

    /// Whether packets of 16 rays go in halves, for which there are kernels.
    pub(super) fn takes_halves(&self) -> bool {
        self.packet_width() == 8
    }

    fn native_ray16(&self) -> bool {
        // SAFETY: the handle is live.
        unsafe { sys::rtcGetDeviceProperty(self.handle, sys::RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0 }
    }

    fn native_ray8(&self) -> bool {
        // SAFETY: the handle is live.
        unsafe { sys::rtcGetDeviceProperty(self.handle, sys::RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0 }
    }

    /// Bytes that Embree holds for this device now.
    pub(crate) fn memory(&self) -> u64 {
        self.memory.held.load(Ordering::Relaxed).max(0) as u64
    }

    pub(super) fn handle(&self) -> sys::RTCDevice {
        self.handle
    }

    /// The error that the calling thread's last Embree call left, if any.
    pub(super) fn check(&self, doing: &str) -> Result<()> {
        // SAFETY: the handle is live.
        match unsafe { sys::rtcGetDeviceError(self.handle) } {
            sys::RTC_ERROR_NONE => Ok(()),
            code => Err(Error::Embree(format!("{doing}: {}", describe(code)))),
        }
    }

    /// Struct layouts changed between minor versions (4.3 added a field to the hit), so headers and library must agree.
    fn check_version(&self) -> Result<()> {
        let (library, headers) = (self.version(), sys::RTC_VERSION);
        // 4.3 and 4.4 have the same layout for what is used here.
        let layout = |version: u32| match version / 100 {
            404 => 403,
            other => other,
        };
        if layout(library) == layout(headers) {
            return Ok(());
        }
        Err(Error::Embree(format!(
            "the library is version {library}, but Phototaxis was built with the headers of {headers}: build it again"
        )))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: this is the only owner of the reference that rtcNewDevice gave; scenes hold an `Arc` of
        // this struct and so have gone before. The monitor is unset first, so the counter is not used after.
        unsafe {
            sys::rtcSetDeviceMemoryMonitorFunction(self.handle, None, std::ptr::null_mut());
            sys::rtcReleaseDevice(self.handle);
        }
    }
}

/// Refuses what would go beyond the limit; Embree then ends its call with an error.
///
/// # Safety
/// Called by Embree with the pointer that `Device::within` registered.
unsafe extern "C" fn count_memory(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: the counter outlives the registration (`Device::drop`).
    let memory = unsafe { &*counter.cast::<Memory>() };
    let before = memory.held.fetch_add(bytes as i64, Ordering::Relaxed);
    bytes <= 0 || before.saturating_add(bytes as i64) <= memory.limit
}

fn describe(code: sys::RTCError) -> String {
    match code {
        sys::RTC_ERROR_INVALID_ARGUMENT => "invalid argument".into(),
        sys::RTC_ERROR_INVALID_OPERATION => "invalid operation".into(),
        sys::RTC_ERROR_OUT_OF_MEMORY => "out of memory".into(),
        sys::RTC_ERROR_UNSUPPORTED_CPU => "this processor is not supported (SSE2 at least)".into(),
        sys::RTC_ERROR_CANCELLED => "cancelled".into(),
        code => format!("error {code}"),
    }
}
