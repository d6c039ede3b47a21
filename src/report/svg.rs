//! Drawing as inline SVG: colours, type, axes and marks the figures share.
//!
//! plotters places everything on whole pixels, so a figure is drawn
//! [`SCALE`] times too large and its view box brings it back. Sizes below are
//! in pixels of the finished figure. Colours are few, told apart by readers
//! who cannot tell red from green, and named in [`PALETTE`]: a page can give
//! each another value on a dark screen.

use std::fmt::Write as _;
use std::io;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontFamily, FontStyle};

/// Text and what is true.
pub const INK: RGBColor = RGBColor(0x1F, 0x29, 0x33);
/// Axis labels and readings.
pub const MUTED: RGBColor = RGBColor(0x6B, 0x72, 0x80);
pub const GRID: RGBColor = RGBColor(0xE3, 0xE7, 0xEC);
/// A broad line that a thin one runs in.
pub const BAND: RGBColor = RGBColor(0xC3, 0xCA, 0xD4);
/// What was identified.
pub const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xB2);
/// What cannot be known.
pub const ORANGE: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
/// The card behind a figure, inside hollow marks.
pub const PAPER: RGBColor = RGBColor(0xFF, 0xFF, 0xFF);

/// Each colour and its name on the page.
pub const PALETTE: [(&str, RGBColor); 7] = [
    ("ink", INK),
    ("muted", MUTED),
    ("grid", GRID),
    ("band", BAND),
    ("blue", BLUE),
    ("orange", ORANGE),
    ("paper", PAPER),
];

/// A colour as SVG writes it.
pub fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Drawn units per pixel.
const SCALE: f64 = 4.0;
/// plotters divides the sizes of type by this.
const FONT_UNIT: f64 = 1.24;
/// Size of all type but titles.
pub const SMALL: f64 = 12.0;
const TITLE: f64 = 13.5;
/// Width of a letter over its size, on the safe side.
const LETTER: f64 = 0.56;

pub type Area<'b> = DrawingArea<SVGBackend<'b>, Shift>;
type Chart<'c, 'b> = ChartContext<'c, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
pub type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<io::Error>>;
/// A place on the figure, in drawn units.
pub type Place = (i32, i32);

/// Draw a figure. `label` says in words what it shows.
pub fn figure(
    [width, height]: [u32; 2],
    label: &str,
    paint: impl FnOnce(&Area<'_>) -> Drawn,
) -> String {
    let size = [width, height].map(|length| length * SCALE as u32);
    let mut drawn = String::new();
    let area = SVGBackend::with_string(&mut drawn, size.into()).into_drawing_area();
    paint(&area)
        .and_then(|()| area.present())
        .expect("drawing into memory meets no broken device and margins fit the figure");
    drop(area);
    let (_, marks) = drawn.split_once('>').expect("a drawing opens with a tag");
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" \
         width=\"{width}\" height=\"{height}\" stroke-linejoin=\"round\" role=\"img\" aria-label=\"",
        size[0], size[1]
    );
    escape(&mut text, label);
    text.push_str("\">");
    text.push_str(marks);
    text
}

/// Append `text` so that markup reads it as text.
pub fn escape(out: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
}

/// Pixels to drawn units.
pub fn px(pixels: f64) -> i32 {
    (pixels * SCALE).round() as i32
}

/// The smallest range over all finite values, a little wider.
pub fn span(values: impl IntoIterator<Item = f64>) -> Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.into_iter().filter(|value| value.is_finite()) {
        (low, high) = (low.min(value), high.max(value));
    }
    if low > high {
        return 0.0..1.0;
    }
    let margin = (0.06 * (high - low))
        .max(1e-9 * low.abs().max(high.abs()))
        .max(1e-6);
    low - margin..high + margin
}

/// Where a text hangs on its place.
#[derive(Clone, Copy)]
pub enum Side {
    Left,
    Middle,
    Right,
}

/// Write one line, its middle at the height of `place`.
pub fn write(
    area: &Area<'_>,
    text: &str,
    place: Place,
    side: Side,
    size: f64,
    color: RGBColor,
    bold: bool,
) -> Drawn {
    let clean: String = text
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    let style = if bold {
        FontStyle::Bold
    } else {
        FontStyle::Normal
    };
    let font = FontDesc::new(FontFamily::SansSerif, size * SCALE * FONT_UNIT, style);
    let h = match side {
        Side::Left => HPos::Left,
        Side::Middle => HPos::Center,
        Side::Right => HPos::Right,
    };
    let style = TextStyle::from(font)
        .color(&color)
        .pos(Pos::new(h, VPos::Center));
    area.draw(&Text::new(clean, place, style))
}

/// A small line of text.
pub fn note(area: &Area<'_>, text: &str, place: Place, side: Side, color: RGBColor) -> Drawn {
    write(area, text, place, side, SMALL, color, false)
}

/// A figure's or panel's title, hung at its left.
pub fn title(area: &Area<'_>, text: &str, place: Place) -> Drawn {
    write(area, text, place, Side::Left, TITLE, INK, true)
}

/// Pixels that small type may take.
fn text_width(text: &str) -> f64 {
    let letters = text
        .chars()
        .map(|c| if c.is_uppercase() { 1.3 } else { 1.0 });
    LETTER * SMALL * letters.sum::<f64>()
}

/// A line through places.
pub fn line(area: &Area<'_>, places: Vec<Place>, color: RGBColor, width: f64) -> Drawn {
    area.draw(&PathElement::new(
        places,
        color.stroke_width(px(width) as u32),
    ))
}

/// A filled box between two corners.
pub fn fill(area: &Area<'_>, corners: [Place; 2], color: RGBColor) -> Drawn {
    area.draw(&Rectangle::new(corners, color.filled()))
}

/// Something that stands for one value.
#[derive(Clone, Copy)]
pub enum Mark {
    /// A filled dot.
    Dot(RGBColor),
    /// A hollow dot.
    Ring(RGBColor),
    /// A filled square.
    Square(RGBColor),
    /// A hollow square.
    Box(RGBColor),
    /// An upright stroke.
    Stroke(RGBColor),
    /// A line of this width.
    Line(RGBColor, f64),
}

/// Draw a mark.
pub fn mark(area: &Area<'_>, (x, y): Place, mark: Mark) -> Drawn {
    match mark {
        Mark::Dot(color) => area.draw(&Circle::new((x, y), px(3.25), color.filled())),
        Mark::Ring(color) => {
            area.draw(&Circle::new((x, y), px(4.0), PAPER.filled()))?;
            area.draw(&Circle::new(
                (x, y),
                px(3.75),
                color.stroke_width(px(1.25) as u32),
            ))
        }
        Mark::Square(color) => square(area, (x, y), 4.5, color),
        Mark::Box(color) => {
            square(area, (x, y), 4.5, color)?;
            square(area, (x, y), 3.0, PAPER)
        }
        Mark::Stroke(color) => line(area, vec![(x, y - px(6.5)), (x, y + px(6.5))], color, 2.5),
        Mark::Line(color, width) => {
            line(area, vec![(x - px(9.0), y), (x + px(9.0), y)], color, width)
        }
    }
}

fn square(area: &Area<'_>, (x, y): Place, half: f64, color: RGBColor) -> Drawn {
    let half = px(half);
    fill(area, [(x - half, y - half), (x + half, y + half)], color)
}

/// Marks and what they mean, side by side, ending at `right` pixels and
/// centred at `middle`.
pub fn key(area: &Area<'_>, right: f64, middle: f64, items: &[(Mark, &str)]) -> Drawn {
    const TO_NAME: f64 = 6.0;
    const TO_NEXT: f64 = 12.0;
    let half = |symbol: &Mark| {
        if matches!(symbol, Mark::Line(..)) {
            9.0
        } else {
            4.0
        }
    };
    let width = |(symbol, name): &(Mark, &str)| 2.0 * half(symbol) + TO_NAME + text_width(name);
    let gaps = TO_NEXT * items.len().saturating_sub(1) as f64;
    let mut left = right - gaps - items.iter().map(width).sum::<f64>();
    for item in items {
        let (symbol, name) = item;
        mark(area, (px(left + half(symbol)), px(middle)), *symbol)?;
        let name_left = left + 2.0 * half(symbol) + TO_NAME;
        note(area, name, (px(name_left), px(middle)), Side::Left, INK)?;
        left += width(item) + TO_NEXT;
    }
    Ok(())
}

/// A panel of a figure: its place, axes and names.
pub struct Frame<'t> {
    pub title: &'t str,
    pub x: Range<f64>,
    pub y: Range<f64>,
    /// Written under the right end of the horizontal axis.
    pub x_name: &'t str,
    /// Labels wished on each axis; none for an axis without labels and grid.
    pub ticks: [usize; 2],
    /// Left, top, right and bottom edge of the plane, pixels.
    pub edges: [f64; 4],
}

/// Height of a panel's title and key over its plane, pixels.
pub const HEADING: f64 = 19.0;

/// A drawn panel: a map from values to places.
pub struct Plane<'c, 'b> {
    area: &'c Area<'b>,
    chart: Chart<'c, 'b>,
}

impl Frame<'_> {
    /// Draw the axes, and the title and name around them.
    pub fn draw<'c, 'b>(&self, area: &'c Area<'b>) -> Drawn<Plane<'c, 'b>> {
        let [left, top, right, bottom] = self.edges.map(px);
        let (width, height) = area.dim_in_pixel();
        let mut chart = ChartBuilder::on(area)
            .margin_top(top)
            .margin_right(width as i32 - right)
            .set_label_area_size(LabelAreaPosition::Left, left)
            .set_label_area_size(LabelAreaPosition::Bottom, height as i32 - bottom)
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        let font = FontDesc::new(
            FontFamily::SansSerif,
            SMALL * SCALE * FONT_UNIT,
            FontStyle::Normal,
        );
        let label = TextStyle::from(font).color(&MUTED);
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(GRID.stroke_width(px(1.0) as u32))
            .axis_style(TRANSPARENT)
            .set_all_tick_mark_size(px(1.5))
            .x_label_style(label.clone())
            .y_label_style(label)
            .x_labels(self.ticks[0])
            .y_labels(self.ticks[1])
            .x_label_formatter(&|value| tick(*value))
            .y_label_formatter(&|value| tick(*value));
        if self.ticks[0] == 0 {
            mesh.disable_x_mesh().disable_x_axis();
        }
        if self.ticks[1] == 0 {
            mesh.disable_y_mesh().disable_y_axis();
        }
        mesh.draw()?;
        if !self.title.is_empty() {
            title(area, self.title, (px(2.0), top - px(HEADING)))?;
        }
        note(
            area,
            self.x_name,
            (right, bottom + px(27.0)),
            Side::Right,
            MUTED,
        )?;
        Ok(Plane { area, chart })
    }
}

impl Plane<'_, '_> {
    /// Where a pair of values lies.
    pub fn place(&self, x: f64, y: f64) -> Place {
        self.chart.backend_coord(&(x, y))
    }

    /// A mark, unless a value is missing.
    pub fn mark(&self, x: f64, y: f64, symbol: Mark) -> Drawn {
        if x.is_finite() && y.is_finite() {
            mark(self.area, self.place(x, y), symbol)?;
        }
        Ok(())
    }

    /// A line through all points; missing values are passed over.
    pub fn line(
        &self,
        points: impl IntoIterator<Item = (f64, f64)>,
        color: RGBColor,
        width: f64,
    ) -> Drawn {
        let finite = points
            .into_iter()
            .filter(|(x, y)| x.is_finite() && y.is_finite());
        let places: Vec<Place> = finite.map(|(x, y)| self.place(x, y)).collect();
        line(self.area, places, color, width)
    }
}

/// The number at a tick: no rounding noise, no negative zero, a true minus.
fn tick(value: f64) -> String {
    let mut text = String::new();
    let _ = write!(text, "{}", (value * 1e6).round() / 1e6 + 0.0);
    text.replace('-', "−")
}
