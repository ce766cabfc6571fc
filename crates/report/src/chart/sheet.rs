//! The sheet that a picture is drawn for: the same picture is drawn once for a page and once for a phone,
//! because scaled down its labels would be unreadable.

/// From the edge of the picture, or of a turned label, to the plotting area, less the labels of ticks.
const TICK: f64 = 10.0;
/// The same with the label of the axis, turned, beside those of ticks.
pub(super) const TURNED: f64 = 32.0;
/// Least room at the right of the plotting area.
pub(super) const RIGHT: f64 = 10.0;

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

    /// Least left edge of the plotting area, so that those of most pictures agree.
    fn left(self) -> f64 {
        match self {
            Sheet::Page | Sheet::Full | Sheet::Half => 70.0,
            Sheet::Phone => 46.0,
        }
    }

    /// Room at the right of the plotting area.
    fn right(self) -> f64 {
        if self == Sheet::Phone { RIGHT } else { 14.0 }
    }

    /// Left edge and width of the plotting area beside labels of this width. Very wide ones get two fifths of
    /// the picture.
    pub(crate) fn beside(self, labels: f64) -> (f64, f64) {
        let room = if self.is_phone() { TICK } else { TURNED };
        let left = self.left().max(labels + room).min(0.4 * self.width()).ceil();
        (left, self.width() - left - self.right())
    }

    /// Whether there is little room beside a picture.
    pub(crate) fn is_phone(self) -> bool {
        self == Sheet::Phone
    }
}
