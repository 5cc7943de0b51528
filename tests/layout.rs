//! Structs and numbers of the C ABI are in Rust what they were in C when tests/abi was last written: `make abi`.
#![cfg(target_pointer_width = "64")]

use core::mem::offset_of;
use volgrad::ffi::*;
use volgrad::math::{Rgb as volgrad_rgb, Vec3 as volgrad_vec3};
use volgrad::medium::Segment as volgrad_segment;
use volgrad::path::Vertex as volgrad_vertex;
use volgrad::scene::{Hit as volgrad_hit, MAX_SEGMENTS as VOLGRAD_MAX_SEGMENTS, Ray as volgrad_ray};

macro_rules! layouts {
    (
        $(struct $type:ident: $size:literal { $($field:ident: $offset:literal),* })*
        $(enum $kind:ident::$name:ident: $value:literal;)*
        $(const $constant:ident: $number:literal;)*
    ) => {
        #[test]
        fn structs_are_laid_out_as_in_c() {
            $(
                // No field is missing in C.
                let _ = |$type { $($field: _),* }: $type| ();
                assert_eq!(size_of::<$type>(), $size, stringify!($type));
                $(assert_eq!(offset_of!($type, $field), $offset, "{}.{}", stringify!($type), stringify!($field));)*
            )*
        }

        #[test]
        fn numbers_are_those_of_c() {
            $(assert_eq!($kind::$name as i64, $value, stringify!($name));)*
            $(assert_eq!($constant as i64, $number, stringify!($constant));)*
        }
    };
}

include!("abi/layout.rs");
