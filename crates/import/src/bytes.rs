//! Numbers from bytes: every read is checked, so that no header can point outside of its file.

/// Bytes that are read from the front.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bytes<'a> {
    rest: &'a [u8],
    /// Whether the first byte of a number is its highest.
    pub(crate) big: bool,
}

macro_rules! number {
    ($($name:ident: $type:ty),*) => {
        $(
            /// The next number; none at the end.
            pub(crate) fn $name(&mut self) -> Option<$type> {
                let bytes = self.take(size_of::<$type>())?.try_into().ok()?;
                Some(if self.big { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) })
            }
        )*
    };
}

impl<'a> Bytes<'a> {
    pub(crate) fn new(rest: &'a [u8], big: bool) -> Bytes<'a> {
        Bytes { rest, big }
    }

    /// The next `n` bytes; none if there are fewer.
    pub(crate) fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.rest.split_at_checked(n)?;
        self.rest = rest;
        Some(head)
    }

    /// What is left.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    number!(u8: u8, i8: i8, u16: u16, i16: i16, u32: u32, i32: i32, u64: u64, i64: i64, f32: f32, f64: f64);
}

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Whole numbers without and with sign.
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    /// IEEE 754 in two, four and eight bytes.
    F16,
    F32,
    F64,
}

impl Kind {
    /// Bytes of a number.
    pub(crate) fn size(self) -> usize {
        match self {
            Kind::U8 | Kind::I8 => 1,
            Kind::U16 | Kind::I16 | Kind::F16 => 2,
            Kind::U32 | Kind::I32 | Kind::F32 => 4,
            Kind::U64 | Kind::I64 | Kind::F64 => 8,
        }
    }

    /// The next number, as the nearest double.
    pub(crate) fn read(self, bytes: &mut Bytes<'_>) -> Option<f64> {
        Some(match self {
            Kind::U8 => f64::from(bytes.u8()?),
            Kind::I8 => f64::from(bytes.i8()?),
            Kind::U16 => f64::from(bytes.u16()?),
            Kind::I16 => f64::from(bytes.i16()?),
            Kind::U32 => f64::from(bytes.u32()?),
            Kind::I32 => f64::from(bytes.i32()?),
            Kind::U64 => bytes.u64()? as f64,
            Kind::I64 => bytes.i64()? as f64,
            Kind::F16 => half(bytes.u16()?),
            Kind::F32 => f64::from(bytes.f32()?),
            Kind::F64 => bytes.f64()?,
        })
    }

    /// `count` numbers; none if there are fewer.
    pub(crate) fn read_many(self, bytes: &mut Bytes<'_>, count: usize) -> Option<Vec<f64>> {
        let mut own = Bytes::new(bytes.take(count.checked_mul(self.size())?)?, bytes.big);
        (0..count).map(|_| self.read(&mut own)).collect()
    }
}

/// A number in two bytes: sign, five bits of exponent, ten of fraction.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}
