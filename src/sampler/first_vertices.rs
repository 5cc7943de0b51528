//! Layers of an image: paths by their first vertex after the camera.

/// The kinds that it may be of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FirstVertices {
    pub medium: bool,
    /// One that scatters.
    pub surface: bool,
    pub specular: bool,
    /// There is none: light that the camera sees directly.
    pub none: bool,
}

impl FirstVertices {
    pub const ALL: Self = Self { medium: true, surface: true, specular: true, none: true };
}
