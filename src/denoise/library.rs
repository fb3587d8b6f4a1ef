//! The C API of Open Image Denoise 2, as far as it is used. Nothing is linked: the functions are looked up in the library that
//! was loaded, by the names and the types of its header `oidn.h`.
#![allow(
    unsafe_code,
    reason = "the foreign function interface to Open Image Denoise; see `embree` and `simd` for the crate's other unsafe code"
)]

use crate::math::Rgb;
use crate::{Error, Result};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::null;

/// Objects of the library.
type DeviceHandle = *mut c_void;
type FilterHandle = *mut c_void;

/// Values of the header's enumerations.
const DEVICE_TYPE_CPU: c_int = 1;
const ERROR_NONE: c_int = 0;
const FORMAT_FLOAT3: c_int = 3;

type SetSharedFilterImage =
    unsafe extern "C" fn(FilterHandle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);

/// The functions, and the library that has them.
pub struct Library {
    new_device: unsafe extern "C" fn(c_int) -> DeviceHandle,
    release_device: unsafe extern "C" fn(DeviceHandle),
    set_device_int: unsafe extern "C" fn(DeviceHandle, *const c_char, c_int),
    get_device_int: unsafe extern "C" fn(DeviceHandle, *const c_char) -> c_int,
    get_device_error: unsafe extern "C" fn(DeviceHandle, *mut *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(DeviceHandle),
    new_filter: unsafe extern "C" fn(DeviceHandle, *const c_char) -> FilterHandle,
    release_filter: unsafe extern "C" fn(FilterHandle),
    set_shared_filter_image: SetSharedFilterImage,
    set_filter_bool: unsafe extern "C" fn(FilterHandle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(FilterHandle),
    execute_filter: unsafe extern "C" fn(FilterHandle),
    /// Last, so that it is closed after all else is gone.
    _library: libloading::Library,
}

impl Library {
    /// Loads the library at `path`, or by its name.
    pub fn load(path: &Path) -> std::result::Result<Library, libloading::Error> {
        // SAFETY: loading runs the library's initialisers, which set up its own tables (and those of its C++ runtime) and
        // call nothing of this program's.
        let library = unsafe { libloading::Library::new(path) }?;
        // SAFETY: the types of the fields, to which each symbol is taken, are those of the functions of that name in `oidn.h`
        // of version 2, which its major version, part of the file's name, keeps as they are. The pointers are called only
        // while `_library`, which stands beside them, is open.
        unsafe {
            Ok(Library {
                new_device: *library.get(b"oidnNewDevice\0")?,
                release_device: *library.get(b"oidnReleaseDevice\0")?,
                set_device_int: *library.get(b"oidnSetDeviceInt\0")?,
                get_device_int: *library.get(b"oidnGetDeviceInt\0")?,
                get_device_error: *library.get(b"oidnGetDeviceError\0")?,
                commit_device: *library.get(b"oidnCommitDevice\0")?,
                new_filter: *library.get(b"oidnNewFilter\0")?,
                release_filter: *library.get(b"oidnReleaseFilter\0")?,
                set_shared_filter_image: *library.get(b"oidnSetSharedFilterImage\0")?,
                set_filter_bool: *library.get(b"oidnSetFilterBool\0")?,
                commit_filter: *library.get(b"oidnCommitFilter\0")?,
                execute_filter: *library.get(b"oidnExecuteFilter\0")?,
                _library: library,
            })
        }
    }
}

/// What filters run on: the processor. It stays in the thread that made it.
pub struct Device {
    library: Library,
    handle: DeviceHandle,
}

impl Device {
    /// A device of `threads` threads (0: as many as there are).
    pub fn new(library: Library, threads: usize) -> Result<Device> {
        // SAFETY: the function takes any type and returns null where it has no such device.
        let handle = unsafe { (library.new_device)(DEVICE_TYPE_CPU) };
        if handle.is_null() {
            // SAFETY: the header allows a null device here, for errors of making one; the pointer is valid for the call.
            let message = unsafe { message(&library, handle) };
            return Err(Error::Denoise(format!("no device: {}", message.unwrap_or_default())));
        }
        let device = Device { library, handle };
        let threads = c_int::try_from(threads).unwrap_or(0);
        // SAFETY: the handle is a live device, names are terminated strings, and both are settings of CPU devices before
        // their commit.
        unsafe {
            (device.library.set_device_int)(device.handle, c"numThreads".as_ptr(), threads);
            (device.library.commit_device)(device.handle);
        }
        device.check()?;
        Ok(device)
    }

    /// 20501 for 2.5.1, or so the header's macros have it (major · 10000 + minor · 100 + patch).
    pub fn version(&self) -> i32 {
        // SAFETY: the handle is a live device and the name a terminated string.
        unsafe { (self.library.get_device_int)(self.handle, c"version".as_ptr()) }
    }

    /// Runs a filter of the kind `RT` over named images of `size` pixels, with these settings.
    ///
    /// # Panics
    /// Where an image has another number of pixels.
    pub fn filter(
        &self,
        inputs: &[(&'static str, &[Rgb])],
        size: (usize, usize),
        settings: &[(&'static str, bool)],
    ) -> Result<Vec<Rgb>> {
        let mut output = vec![Rgb::ZERO; size.0 * size.1];
        // SAFETY: the handle is a live device and the name a terminated string.
        let handle = unsafe { (self.library.new_filter)(self.handle, c"RT".as_ptr()) };
        self.check()?;
        let filter = Filter { library: &self.library, handle };
        for (name, pixels) in inputs {
            assert_eq!(pixels.len(), output.len(), "pixels of {name}");
            // SAFETY: the pixels are as many as `size` says and outlive the filter, which only reads its inputs.
            unsafe { filter.image(name, pixels.as_ptr().cast_mut().cast(), size) };
        }
        // SAFETY: the output has `size` pixels, outlives the filter, and is read only after the filter has run.
        unsafe { filter.image("output", output.as_mut_ptr().cast(), size) };
        for (name, value) in settings {
            let name = text(name);
            // SAFETY: the handle is a live filter and the name a terminated string.
            unsafe { (self.library.set_filter_bool)(filter.handle, name.as_ptr(), *value) };
        }
        // SAFETY: the handle is a live filter, whose images are valid as above. The call returns once all of them have been
        // read and written.
        unsafe {
            (self.library.commit_filter)(filter.handle);
            (self.library.execute_filter)(filter.handle);
        }
        drop(filter);
        self.check()?;
        Ok(output)
    }

    /// The first error since the last time that this was asked.
    fn check(&self) -> Result<()> {
        // SAFETY: the handle is a live device.
        let message = unsafe { message(&self.library, self.handle) };
        message.map_or(Ok(()), |message| Err(Error::Denoise(message)))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the handle is a live device, of which no filter is left, and is not used again.
        unsafe { (self.library.release_device)(self.handle) };
    }
}

/// A filter that is released with this.
struct Filter<'a> {
    library: &'a Library,
    handle: FilterHandle,
}

impl Filter<'_> {
    /// # Safety
    /// `pixels` are three floats for each of `size` pixels, row after row without gaps, and stay where they are until the filter
    /// is released.
    unsafe fn image(&self, name: &str, pixels: *mut c_void, (width, height): (usize, usize)) {
        let name = text(name);
        let set = self.library.set_shared_filter_image;
        // SAFETY: the handle is a live filter, the name a terminated string, the pixels are as the caller promises; strides of
        // 0 say that there are no gaps.
        unsafe { set(self.handle, name.as_ptr(), pixels, FORMAT_FLOAT3, width, height, 0, 0, 0) };
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is a live filter and is not used again.
        unsafe { (self.library.release_filter)(self.handle) };
    }
}

/// What went wrong, if anything did; it is then forgotten.
///
/// # Safety
/// `device` is a live device or null.
unsafe fn message(library: &Library, device: DeviceHandle) -> Option<String> {
    let mut text: *const c_char = null();
    // SAFETY: the device is as the caller promises, and `text` may be written.
    let code = unsafe { (library.get_device_error)(device, &mut text) };
    if code == ERROR_NONE {
        return None;
    }
    if text.is_null() {
        return Some(format!("error {code}"));
    }
    // SAFETY: the library gives a terminated string, which stays until its next error in this thread.
    Some(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
}

fn text(name: &str) -> CString {
    CString::new(name).expect("names of images and settings have no zeros")
}

// Pixels are passed as three floats without gaps.
const _: () = assert!(size_of::<Rgb>() == 12);
