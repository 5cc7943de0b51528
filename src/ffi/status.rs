//! What a call returns, in numbers and words.

use crate::path::{PathError, PathErrorKind};
use crate::scene::Stop;
use core::ffi::{CStr, c_char};

/// The result of every fallible function. On an error all outputs are untouched, unless the function says otherwise.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum volgrad_status {
    VOLGRAD_OK = 0,
    /// A required pointer is NULL.
    VOLGRAD_ERROR_NULL = 1,
    /// A pointer is not aligned as its type (or, for memory, to 16 bytes).
    VOLGRAD_ERROR_MISALIGNED = 2,
    /// A struct_size is too small to be true, or a newer struct sets fields that this library does not know.
    VOLGRAD_ERROR_STRUCT_SIZE = 3,
    /// A kind, mode or flag that does not exist, or not in this place.
    VOLGRAD_ERROR_KIND = 4,
    /// A NaN or an infinity, or a vector that should have unit length.
    VOLGRAD_ERROR_NOT_FINITE = 5,
    /// A value outside its range.
    VOLGRAD_ERROR_RANGE = 6,
    /// An index that points past its array.
    VOLGRAD_ERROR_INDEX = 7,
    /// A buffer or memory block is too small.
    VOLGRAD_ERROR_TOO_SMALL = 8,
    /// Two points that must differ are the same.
    VOLGRAD_ERROR_ZERO_LENGTH = 9,
    /// Media segments of an edge are missing, out of order, or end too early; or a medium vertex lies in none of them.
    VOLGRAD_ERROR_SEGMENTS = 10,
    /// This vertex cannot move freely: it is not in a medium, or next to a specular surface.
    VOLGRAD_ERROR_NOT_MOVABLE = 11,
    /// The path carries nothing (f = 0), so that log f has no gradient and a weight no meaning.
    VOLGRAD_ERROR_ZERO_CONTRIBUTION = 12,
    /// A callback returned a value other than 0.
    VOLGRAD_ERROR_CALLBACK = 13,
    /// A callback filled a hit that breaks the rules of `volgrad_hit`.
    VOLGRAD_ERROR_INVALID_HIT = 14,
    /// Two films differ in size.
    VOLGRAD_ERROR_SIZE_MISMATCH = 15,
    /// The memory was not initialised by this library, or by another ABI version of it.
    VOLGRAD_ERROR_NOT_INITIALISED = 16,
    /// A file could not be read or written, or is not what it should be.
    VOLGRAD_ERROR_FILE = 17,
    /// A chain's path is not what it was: the scene, its guides, the seed or the techniques are not those of the samples and the plan.
    VOLGRAD_ERROR_OTHER_PATH = 18,
    /// A bug in the library or one of its dependencies; nothing of the call can be relied on.
    VOLGRAD_ERROR_INTERNAL = 19,
    /// What is asked for needs the derivative of a custom material or light that has no `log_gradient`, or of a custom phase function
    /// that has no `log_derivative`.
    VOLGRAD_ERROR_NO_GRADIENT = 20,
}

use volgrad_status::*;

impl volgrad_status {
    fn message(self) -> &'static CStr {
        match self {
            VOLGRAD_OK => c"no error",
            VOLGRAD_ERROR_NULL => c"a required pointer is NULL",
            VOLGRAD_ERROR_MISALIGNED => c"a pointer is misaligned; memory for volgrad objects must be aligned to 16 bytes",
            VOLGRAD_ERROR_STRUCT_SIZE => c"a struct_size is wrong; fill option structs by their _default function",
            VOLGRAD_ERROR_KIND => c"a kind, mode or flag does not exist or not in this place",
            VOLGRAD_ERROR_NOT_FINITE => c"a value is NaN or infinite, or a direction or normal is not of unit length",
            VOLGRAD_ERROR_RANGE => c"a value is out of its range",
            VOLGRAD_ERROR_INDEX => c"an index points past its array",
            VOLGRAD_ERROR_TOO_SMALL => c"a buffer or memory block is too small",
            VOLGRAD_ERROR_ZERO_LENGTH => c"two points that must differ are the same",
            VOLGRAD_ERROR_SEGMENTS => c"media segments are missing, out of order, or do not cover their edge",
            VOLGRAD_ERROR_NOT_MOVABLE => c"the vertex cannot move freely: not in a medium, or next to a specular surface",
            VOLGRAD_ERROR_ZERO_CONTRIBUTION => c"the path carries no light",
            VOLGRAD_ERROR_CALLBACK => c"a callback stopped the call",
            VOLGRAD_ERROR_INVALID_HIT => c"a callback filled a hit that breaks the rules of volgrad_hit",
            VOLGRAD_ERROR_SIZE_MISMATCH => c"the films differ in size",
            VOLGRAD_ERROR_NOT_INITIALISED => c"the memory holds no object of this library version",
            VOLGRAD_ERROR_FILE => c"a file could not be read or written, or is not what it should be",
            VOLGRAD_ERROR_OTHER_PATH => c"the chain belongs to another scene, or its start to other samples",
            VOLGRAD_ERROR_INTERNAL => c"internal error",
            VOLGRAD_ERROR_NO_GRADIENT => {
                c"this needs the derivative of a custom material, phase function or light whose table has none"
            }
        }
    }

    /// Every status, by number.
    const ALL: [Self; 21] = [
        VOLGRAD_OK,
        VOLGRAD_ERROR_NULL,
        VOLGRAD_ERROR_MISALIGNED,
        VOLGRAD_ERROR_STRUCT_SIZE,
        VOLGRAD_ERROR_KIND,
        VOLGRAD_ERROR_NOT_FINITE,
        VOLGRAD_ERROR_RANGE,
        VOLGRAD_ERROR_INDEX,
        VOLGRAD_ERROR_TOO_SMALL,
        VOLGRAD_ERROR_ZERO_LENGTH,
        VOLGRAD_ERROR_SEGMENTS,
        VOLGRAD_ERROR_NOT_MOVABLE,
        VOLGRAD_ERROR_ZERO_CONTRIBUTION,
        VOLGRAD_ERROR_CALLBACK,
        VOLGRAD_ERROR_INVALID_HIT,
        VOLGRAD_ERROR_SIZE_MISMATCH,
        VOLGRAD_ERROR_NOT_INITIALISED,
        VOLGRAD_ERROR_FILE,
        VOLGRAD_ERROR_OTHER_PATH,
        VOLGRAD_ERROR_INTERNAL,
        VOLGRAD_ERROR_NO_GRADIENT,
    ];
}

impl From<PathError> for volgrad_status {
    fn from(error: PathError) -> Self {
        match error.kind {
            PathErrorKind::BadKind => VOLGRAD_ERROR_KIND,
            PathErrorKind::BadIndex => VOLGRAD_ERROR_INDEX,
            PathErrorKind::NotFinite => VOLGRAD_ERROR_NOT_FINITE,
            PathErrorKind::Misplaced => VOLGRAD_ERROR_RANGE,
            PathErrorKind::ZeroLength => VOLGRAD_ERROR_ZERO_LENGTH,
            PathErrorKind::BadSegments => VOLGRAD_ERROR_SEGMENTS,
            PathErrorKind::NotMovable => VOLGRAD_ERROR_NOT_MOVABLE,
            PathErrorKind::ZeroContribution => VOLGRAD_ERROR_ZERO_CONTRIBUTION,
            PathErrorKind::NoGradient => VOLGRAD_ERROR_NO_GRADIENT,
        }
    }
}

impl From<Stop> for volgrad_status {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Callback(_) => VOLGRAD_ERROR_CALLBACK,
            Stop::InvalidHit => VOLGRAD_ERROR_INVALID_HIT,
            Stop::OtherPath => VOLGRAD_ERROR_OTHER_PATH,
            Stop::NoGradient => VOLGRAD_ERROR_NO_GRADIENT,
        }
    }
}

/// Which field was wrong, beside a status.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_error {
    /// `sizeof(volgrad_error)` of the caller.
    pub struct_size: u32,
    /// Index of the array element or path vertex that `field` belongs to; 0 if none.
    pub index: u32,
    /// Name of the field, for example `media.albedo`; static text, or NULL if no field is to blame.
    pub field: *const c_char,
}

/// A failure and its place, inside this module.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fault {
    pub status: volgrad_status,
    pub field: Option<&'static CStr>,
    pub index: u32,
}

impl From<volgrad_status> for Fault {
    fn from(status: volgrad_status) -> Self {
        Self { status, field: None, index: 0 }
    }
}

impl From<PathError> for Fault {
    fn from(error: PathError) -> Self {
        Self { status: error.into(), field: Some(c"path.vertices"), index: error.index }
    }
}

impl From<Stop> for Fault {
    fn from(stop: Stop) -> Self {
        volgrad_status::from(stop).into()
    }
}

impl volgrad_status {
    pub(super) fn at(self, field: &'static CStr, index: usize) -> Fault {
        Fault { status: self, field: Some(field), index: index as u32 }
    }
}

/// The status of a result.
pub(super) fn finish(result: Result<(), Fault>) -> volgrad_status {
    result.map_or_else(|fault| fault.status, |()| VOLGRAD_OK)
}

/// A status in words: static text in English, never NULL, also for numbers that are no status.
#[unsafe(no_mangle)]
pub extern "C" fn volgrad_status_message(status: i32) -> *const c_char {
    let known = usize::try_from(status).ok().and_then(|i| volgrad_status::ALL.get(i));
    known.map_or(c"unknown status", |status| status.message()).as_ptr()
}

/// `VOLGRAD_ABI_VERSION` of the library, to compare with the header's.
#[unsafe(no_mangle)]
pub extern "C" fn volgrad_abi_version() -> u32 {
    super::VOLGRAD_ABI_VERSION
}

/// The library's version, "major.minor.patch"; static text.
#[unsafe(no_mangle)]
pub extern "C" fn volgrad_version() -> *const c_char {
    // The version has no NUL of its own, so this never falls back.
    CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()).unwrap_or(c"").as_ptr()
}
