//! Curves as a PNG, without a GPU.

use super::font::{draw_text, text_width};
use super::frame::StoryboardError;
use tiny_skia::{Color, Paint, PathBuilder, Pixmap, Rect, Stroke, Transform};

/// One line of a chart.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points (x, y); those that are not finite are left out.
    pub points: Vec<(f64, f64)>,
}

/// A chart: lines over a common x axis, y from `low` to `high`.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// What x counts.
    pub x_label: String,
    /// Lower end of the y axis.
    pub low: f64,
    /// Upper end of the y axis.
    pub high: f64,
    /// The lines.
    pub curves: Vec<Curve>,
}

const COLORS: [[u8; 3]; 8] = [
    [31, 97, 167],
    [214, 90, 30],
    [50, 140, 60],
    [130, 70, 160],
    [110, 110, 110],
    [196, 160, 20],
    [20, 160, 170],
    [200, 40, 90],
];
/// Height of a line of the legend, where it has lines of its own.
const LEGEND_LINE: f32 = 14.0;
const LEFT: f32 = 56.0;
const RIGHT: f32 = 16.0;
const TOP: f32 = 34.0;
const BOTTOM: f32 = 34.0;

fn paint(color: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(color[0], color[1], color[2], 255);
    paint.anti_alias = true;
    paint
}

/// A number in few characters.
fn short(x: f64) -> String {
    match x.abs() {
        a if a >= 1e6 => format!("{:.1}M", x / 1e6),
        a if a >= 1e4 => format!("{:.0}k", x / 1e3),
        a if a >= 10.0 => format!("{x:.0}"),
        _ => format!("{x:.2}"),
    }
}

/// Draws charts one below the other, each `width` x `height` pixels, and encodes them as PNG.
pub fn charts_png(charts: &[Chart], width: u32, height: u32) -> Result<Vec<u8>, StoryboardError> {
    let total = height.saturating_mul(charts.len() as u32);
    let bad = StoryboardError::Option { option: "height", value: f64::from(total), valid: "1 to 16384" };
    let mut pixmap = Pixmap::new(width, total).filter(|_| total <= 16384).ok_or(bad)?;
    pixmap.fill(Color::WHITE);
    for (n, chart) in charts.iter().enumerate() {
        draw(&mut pixmap, chart, (n as u32 * height) as f32, width as f32, height as f32);
    }
    pixmap.encode_png().map_err(|e| StoryboardError::Encode(e.to_string()))
}

fn draw(pixmap: &mut Pixmap, chart: &Chart, top: f32, width: f32, height: f32) {
    let ink = Color::from_rgba8(40, 40, 46, 255);
    let (names, rows) = legend(chart, LEFT, width - RIGHT);
    let (x0, x1, y0) = (LEFT, width - RIGHT, top + height - BOTTOM);
    let y1 = top + TOP + LEGEND_LINE * rows as f32;
    let finite =
        |c: &Curve| c.points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect::<Vec<_>>();
    let lines: Vec<Vec<(f64, f64)>> = chart.curves.iter().map(finite).collect();
    let all = || lines.iter().flatten().map(|p| p.0);
    let (left, right) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let (left, right) = if left < right { (left, right) } else { (0.0, 1.0) };
    let span = (chart.high - chart.low).max(1e-12);
    let place = |(x, y): (f64, f64)| {
        let u = ((x - left) / (right - left)) as f32;
        let v = (((y - chart.low) / span).clamp(0.0, 1.0)) as f32;
        (x0 + u * (x1 - x0), y0 + v * (y1 - y0))
    };

    // Grid and labels.
    for k in 0..=4 {
        let part = k as f32 / 4.0;
        let y = y0 + part * (y1 - y0);
        if let Some(rect) = Rect::from_xywh(x0, y - 0.5, x1 - x0, 1.0) {
            pixmap.fill_rect(rect, &paint([226, 228, 232]), Transform::identity(), None);
        }
        let label = short(chart.low + f64::from(part) * span);
        draw_text(pixmap, &label, x0 - 8.0 - text_width(&label, 8.0), y + 4.0, 8.0, ink);
        let label = short(left + f64::from(part) * (right - left));
        let x = x0 + part * (x1 - x0) - 0.5 * text_width(&label, 8.0);
        draw_text(pixmap, &label, x, y0 + 14.0, 8.0, ink);
    }
    draw_text(pixmap, &chart.title, x0, top + 20.0, 10.0, ink);
    let label = &chart.x_label;
    draw_text(pixmap, label, x1 - text_width(label, 8.0), y0 + 28.0, 8.0, ink);

    // Lines and legend.
    for (n, points) in lines.iter().enumerate() {
        let color = COLORS[n % COLORS.len()];
        let ([r, g, b], (x, y)) = (color, names[n]);
        draw_text(pixmap, &chart.curves[n].name, x, top + y, 8.0, Color::from_rgba8(r, g, b, 255));
        let mut builder = PathBuilder::new();
        for (k, &p) in points.iter().enumerate() {
            let (x, y) = place(p);
            if k == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
        }
        if let Some(path) = builder.finish() {
            let stroke = Stroke { width: 1.6, ..Stroke::default() };
            pixmap.stroke_path(&path, &paint(color), &stroke, Transform::identity(), None);
        }
    }
}

/// Where the names of the curves are written, and how many lines of their own they take: none, at the right of the title,
/// where they fit there.
fn legend(chart: &Chart, x0: f32, x1: f32) -> (Vec<(f32, f32)>, usize) {
    let wide = |curve: &Curve| text_width(&curve.name, 8.0) + 16.0;
    let total: f32 = chart.curves.iter().map(wide).sum();
    let mut x = x1;
    if x0 + text_width(&chart.title, 10.0) + total <= x1 {
        let mut place = |curve| {
            x -= wide(curve);
            (x, 20.0)
        };
        return (chart.curves.iter().map(&mut place).collect(), 0);
    }
    let mut rows = 0;
    let place = |curve| {
        if rows == 0 || x + wide(curve) > x1 {
            (x, rows) = (x0, rows + 1);
        }
        let at = (x, 20.0 + LEGEND_LINE * rows as f32);
        x += wide(curve);
        at
    };
    (chart.curves.iter().map(place).collect(), rows)
}
