//! Which paths a sampler renders.

/// Lengths of paths, in edges: from `first` to `last`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lengths {
    pub first: u32,
    pub last: u32,
}

impl Lengths {
    pub const NONE: Self = Self { first: 1, last: 0 };

    pub fn contains(self, length: u32) -> bool {
        self.first <= length && length <= self.last
    }
}
