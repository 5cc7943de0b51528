//! Text in a buffer of the caller's: no allocation, and none of `core::fmt`, whose float formatting can panic.

/// Text that is written on, as far as there is room; how long it would be is known anyway.
pub struct Text<'a> {
    buffer: &'a mut [u8],
    /// In bytes, of all that was put.
    pub length: usize,
}

impl<'a> Text<'a> {
    pub fn new(buffer: &'a mut [u8]) -> Self {
        Self { buffer, length: 0 }
    }

    pub fn put(&mut self, text: &str) -> &mut Self {
        for byte in text.bytes() {
            if let Some(place) = self.buffer.get_mut(self.length) {
                *place = byte;
            }
            self.length += 1;
        }
        self
    }

    pub fn whole(&mut self, n: u64) -> &mut Self {
        self.put(itoa::Buffer::new().format(n))
    }

    /// The shortest decimal that is the number in single precision; in double, if it is beyond that.
    pub fn number(&mut self, x: f64) -> &mut Self {
        let single = x as f32;
        let mut buffer = ryu::Buffer::new();
        self.put(if single.is_normal() || x == 0.0 { buffer.format(single) } else { buffer.format(x) })
    }
}
