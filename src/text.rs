//! Text in a buffer of the caller's: no allocation, and none of `core::fmt`, whose float formatting can panic.

/// Text that is written on, as far as there is room; how long it would be is known anyway.
pub struct Text<'a> {
    buffer: &'a mut [u8],
    /// In bytes, of all that was put.
    pub length: usize,
}

/// Decimal digits of a number: about those of single precision.
const DIGITS: usize = 7;

impl<'a> Text<'a> {
    pub fn new(buffer: &'a mut [u8]) -> Self {
        Self { buffer, length: 0 }
    }

    pub fn put(&mut self, text: &str) -> &mut Self {
        text.bytes().for_each(|byte| self.byte(byte));
        self
    }

    pub fn whole(&mut self, n: u64) -> &mut Self {
        let (mut rest, mut digits, mut first) = (n, [b'0'; 20], 20);
        for (i, digit) in digits.iter_mut().enumerate().rev() {
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
            first = i;
            if rest == 0 {
                break;
            }
        }
        digits.iter().skip(first).for_each(|digit| self.byte(*digit));
        self
    }

    /// As `%.7g` does, with at least that precision.
    pub fn number(&mut self, x: f64) -> &mut Self {
        if x.is_nan() {
            return self.put("nan");
        }
        if x.is_sign_negative() && x != 0.0 {
            self.put("-");
        }
        let x = x.abs();
        if x == 0.0 {
            return self.put("0");
        }
        if x.is_infinite() {
            return self.put("inf");
        }
        let mut exponent = libm::floor(libm::log10(x)) as i32;
        // In two steps: powers beyond 308 are infinite.
        let scaled = |exponent: i32| {
            let power = DIGITS as i32 - 1 - exponent;
            libm::round(x * libm::pow(10.0, f64::from(power / 2)) * libm::pow(10.0, f64::from(power - power / 2))) as u64
        };
        const LIMIT: u64 = 10_u64.pow(DIGITS as u32);
        let mut digits = scaled(exponent);
        if digits >= LIMIT || digits < LIMIT / 10 {
            exponent += if digits >= LIMIT { 1 } else { -1 };
            digits = scaled(exponent);
        }
        self.decimal(digits, exponent)
    }

    /// d.ddd · 10^exponent, without trailing zeros.
    fn decimal(&mut self, digits: u64, exponent: i32) -> &mut Self {
        const LARGEST: i32 = DIGITS as i32 - 1;
        let (point, shown) = if (-4..=LARGEST).contains(&exponent) { (exponent, 0) } else { (0, exponent) };
        let (mut rest, mut all, mut last) = (digits, [0; DIGITS], 0);
        for (i, digit) in all.iter_mut().enumerate().rev() {
            *digit = (rest % 10) as u8;
            rest /= 10;
            last = if last == 0 && *digit > 0 { i } else { last };
        }
        if point < 0 {
            self.put("0.");
            (1..-point).for_each(|_| self.byte(b'0'));
        }
        for (place, digit) in (0..).zip(all) {
            if place > point.max(last as i32) {
                break;
            }
            if place == point + 1 && point >= 0 {
                self.byte(b'.');
            }
            self.byte(b'0' + digit);
        }
        if shown != 0 {
            self.put(if shown < 0 { "e-" } else { "e+" }).whole(shown.unsigned_abs().into());
        }
        self
    }

    fn byte(&mut self, byte: u8) {
        if let Some(place) = self.buffer.get_mut(self.length) {
            *place = byte;
        }
        self.length += 1;
    }
}
