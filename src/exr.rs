//! OpenEXR images: linear RGB in 32-bit floats, with the attributes that say how an image was made. Needs std.

use ::exr::prelude::*;
use std::path::Path;
use std::string::{String, ToString};
use std::vec::Vec;

/// Which part of an image a file stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// The whole image ("display window").
    pub width: usize,
    pub height: usize,
    /// The stored part ("data window").
    pub x: usize,
    pub y: usize,
    pub window_width: usize,
    pub window_height: usize,
}

/// A number or a text beside the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attribute<'a> {
    Number(&'a str, f64),
    Text(&'a str, &'a str),
}

/// Writes `rgb`, three floats per pixel of the window, row by row from the top.
pub fn write(path: &Path, layout: &Layout, rgb: &[f32], attributes: &[Attribute]) -> core::result::Result<(), String> {
    let size = Vec2(layout.window_width, layout.window_height);
    if rgb.len() != 3 * size.area() {
        return Err("the buffer does not hold three floats per pixel of the window".to_string());
    }
    let pixels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| {
        let i = 3 * (y * layout.window_width + x);
        (rgb[i], rgb[i + 1], rgb[i + 2])
    });
    let mut image = Image::from_layer(Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, pixels));
    let corner = |x: usize, y: usize| Some(Vec2(i32::try_from(x).ok()?, i32::try_from(y).ok()?));
    image.layer_data.attributes.layer_position = corner(layout.x, layout.y).ok_or("the window lies too far out")?;
    image.attributes.display_window = IntegerBounds::new(Vec2(0, 0), Vec2(layout.width, layout.height));
    for attribute in attributes {
        let (name, value) = match *attribute {
            Attribute::Number(name, number) => (name, AttributeValue::F64(number)),
            Attribute::Text(name, text) => (name, AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes()))),
        };
        image.layer_data.attributes.other.insert(name_of(name)?, value);
    }
    image.write().to_file(path).map_err(|error| error.to_string())
}

fn name_of(text: &str) -> core::result::Result<Text, String> {
    Text::new_or_none(text).ok_or_else(|| std::format!("{text:?} cannot name an EXR attribute"))
}

/// The windows of a file.
pub fn read_layout(path: &Path) -> core::result::Result<Layout, String> {
    let meta = MetaData::read_from_file(path, false).map_err(|error| error.to_string())?;
    let header = meta.headers.first().ok_or("the file has no layer")?;
    let display = header.shared_attributes.display_window;
    let offset = header.own_attributes.layer_position - display.position;
    let inside = |v: i32| usize::try_from(v).map_err(|_| "the data window begins before the display window".to_string());
    Ok(Layout {
        width: display.size.width(),
        height: display.size.height(),
        x: inside(offset.x())?,
        y: inside(offset.y())?,
        window_width: header.layer_size.width(),
        window_height: header.layer_size.height(),
    })
}

/// The window's pixels, three floats each, row by row from the top.
pub fn read(path: &Path) -> core::result::Result<Vec<f32>, String> {
    struct Pixels(usize, Vec<f32>);
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| Pixels(size.width(), std::vec![0.0; 3 * size.area()]),
        |pixels: &mut Pixels, Vec2(x, y), (r, g, b, _): (f32, f32, f32, f32)| {
            let i = 3 * (y * pixels.0 + x);
            pixels.1[i..i + 3].copy_from_slice(&[r, g, b]);
        },
    )
    .map_err(|error| error.to_string())?;
    Ok(image.layer_data.channel_data.pixels.1)
}
