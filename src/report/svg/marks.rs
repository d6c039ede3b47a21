//! Marks that stand for a value, and the key that says what they mean.

use super::{Anchor, Color, Figure, INK, PAPER, Place, text_width};

/// Something that stands for one value.
#[derive(Clone, Copy)]
pub enum Mark {
    /// A filled dot.
    Dot(Color),
    /// A hollow dot.
    Ring(Color),
    /// A filled square.
    Square(Color),
    /// A hollow square.
    Box(Color),
    /// An upright stroke.
    Stroke(Color),
    /// A line of this width.
    Line(Color, f64),
}

impl Mark {
    /// Half of its width, pixels.
    fn half(self) -> f64 {
        match self {
            Mark::Line(..) => 9.0,
            Mark::Stroke(_) => 2.0,
            _ => 4.5,
        }
    }
}

impl Figure {
    /// Draw a mark.
    pub fn mark(&mut self, [x, y]: Place, mark: Mark) {
        let half = mark.half();
        let corners = |half: f64| [[x - half, y - half], [x + half, y + half]];
        match mark {
            Mark::Dot(color) => self.dot([x, y], 3.25, color),
            Mark::Ring(color) => self.ring([x, y], color),
            Mark::Square(color) => self.fill(corners(half), color, 1.0),
            Mark::Box(color) => {
                self.fill(corners(half), color, 1.0);
                self.fill(corners(half - 1.5), PAPER, 1.0);
            }
            Mark::Stroke(color) => self.line([[x, y - 6.5], [x, y + 6.5]], color, 2.5),
            Mark::Line(color, width) => self.line([[x - half, y], [x + half, y]], color, width),
        }
    }
}

/// Marks and what they mean, side by side, ending at `right` pixels and centred at
/// `middle`.
pub fn key(figure: &mut Figure, right: f64, middle: f64, items: &[(Mark, &str)]) {
    const TO_NAME: f64 = 6.0;
    const TO_NEXT: f64 = 14.0;
    let mut right = right;
    for (mark, name) in items.iter().rev() {
        let left = right - text_width(name);
        figure.note([left, middle], Anchor::Start, INK, name);
        let centre = left - TO_NAME - mark.half();
        figure.mark([centre, middle], *mark);
        right = centre - mark.half() - TO_NEXT;
    }
}
