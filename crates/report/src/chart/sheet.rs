//! The sheet that a picture is drawn for: the same picture is drawn once for a page and once for a phone,
//! because scaled down its labels would be unreadable.

/// Width and margins of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sheet {
    /// A column of text on a desk or on paper.
    Page,
    /// The whole width of a desk, low.
    Full,
    /// Half of it: two pictures stand side by side.
    Half,
    /// A phone.
    Phone,
}

impl Sheet {
    /// Width of a picture.
    pub(crate) fn width(self) -> f64 {
        match self {
            Sheet::Page => 760.0,
            Sheet::Full => 1100.0,
            Sheet::Half => 540.0,
            Sheet::Phone => 340.0,
        }
    }

    /// Left edge of the plotting area: room for labels of ticks.
    pub(crate) fn left(self) -> f64 {
        match self {
            Sheet::Page | Sheet::Full | Sheet::Half => 70.0,
            Sheet::Phone => 46.0,
        }
    }

    /// Room at the right of the plotting area.
    fn right(self) -> f64 {
        if self == Sheet::Phone { 10.0 } else { 14.0 }
    }

    /// Width of the plotting area.
    pub(crate) fn inner(self) -> f64 {
        self.width() - self.left() - self.right()
    }

    /// Whether there is little room beside a picture.
    pub(crate) fn is_phone(self) -> bool {
        self == Sheet::Phone
    }
}
