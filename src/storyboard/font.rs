//! Digits and letters as strokes, so that no font file is needed.
//!
//! A glyph is a list of polylines on a grid four units wide and six high, `y` down, two digits a point, a space between
//! polylines; a polyline of one point is a dot. Small letters are small capitals.

use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, Transform};

/// Width of a glyph and the gap after it, in heights of a capital.
const ADVANCE: f32 = 5.6 / 6.0;
/// Size of a small letter relative to a capital.
const SMALL: f32 = 0.76;

fn strokes(c: char) -> &'static str {
    match c {
        '0' | 'O' => "103041453616050110",
        '1' => "112026 1636",
        '2' => "01103041420646",
        '3' => "0110304142334445361605 1333",
        '4' => "300444 3036",
        '5' => "400003334445361605",
        '6' => "4130100105163645443303",
        '7' => "004016",
        '8' => "103041423313020110 1304051636454433",
        '9' => "4313020110304145361605",
        'A' => "0602204246 0444",
        'B' => "00063645443303 0030414233",
        'C' => "4130100105163645",
        'D' => "00063645413000",
        'E' => "40000646 0333",
        'F' => "400006 0333",
        'G' => "41301001051636454323",
        'H' => "0006 4046 0343",
        'I' => "1030 2026 1636",
        'J' => "4045361605",
        'K' => "0006 400346",
        'L' => "000646",
        'M' => "0600234046",
        'N' => "06004640",
        'P' => "06003041423303",
        'Q' => "103041453616050110 2446",
        'R' => "06003041423303 2346",
        'S' => "413010010213334445361605",
        'T' => "0040 2026",
        'U' => "000516364540",
        'V' => "002640",
        'W' => "0016233640",
        'X' => "0046 4006",
        'Y' => "002340 2326",
        'Z' => "00400646",
        '.' => "26",
        ',' => "2617",
        ':' => "22 25",
        '-' => "1333",
        '+' => "0343 2125",
        '/' => "0640",
        '(' => "30121436",
        ')' => "10323416",
        '%' => "0640 01 45",
        '=' => "0242 0444",
        '_' => "0646",
        '\'' => "2022",
        '<' => "410345",
        '>' => "014305",
        ' ' => "",
        // Anything else is a small box, so that it is seen that something is missing.
        _ => "1131351511",
    }
}

fn scale_of(c: char, size: f32) -> f32 {
    if c.is_ascii_lowercase() { size * SMALL } else { size }
}

fn advance_of(c: char, size: f32) -> f32 {
    let narrow = match c {
        '.' | ',' | ':' | '\'' => 0.6,
        ' ' => 0.65,
        _ => 1.0,
    };
    scale_of(c, size) * ADVANCE * narrow
}

/// Width of a line of text with capitals of this height, pixels.
pub(crate) fn text_width(text: &str, size: f32) -> f32 {
    text.chars().map(|c| advance_of(c, size)).sum()
}

/// Draws one line of text; `x` is the left edge, `y` the base line, `size` the height of a capital, pixels.
pub(crate) fn draw_text(pixmap: &mut Pixmap, text: &str, x: f32, y: f32, size: f32, color: Color) {
    let mut paint = Paint { anti_alias: true, ..Default::default() };
    paint.set_color(color);
    let width = (size * 0.135).max(1.0);
    let stroke = Stroke { width, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Default::default() };
    let (mut lines, mut dots) = (PathBuilder::new(), PathBuilder::new());
    let mut pen = x;
    for c in text.chars() {
        let unit = scale_of(c, size) / 6.0;
        let advance = advance_of(c, size);
        // Narrow glyphs are drawn around the middle of their advance.
        let left = pen + (advance - scale_of(c, size) * ADVANCE) / 2.0;
        for polyline in strokes(c.to_ascii_uppercase()).split_ascii_whitespace() {
            let digits: Vec<f32> = polyline.bytes().map(|b| f32::from(b - b'0')).collect();
            let at = |p: &[f32]| (left + p[0] * unit, y + (p[1] - 6.0) * unit);
            if digits.len() == 2 {
                let (px, py) = at(&digits);
                dots.push_circle(px, py, width * 0.62);
            }
            for (i, p) in digits.chunks_exact(2).enumerate().take_while(|_| digits.len() > 2) {
                let (px, py) = at(p);
                if i == 0 { lines.move_to(px, py) } else { lines.line_to(px, py) }
            }
        }
        pen += advance;
    }
    if let Some(path) = lines.finish() {
        pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }
    if let Some(path) = dots.finish() {
        pixmap.fill_path(&path, &paint, FillRule::Winding, Transform::identity(), None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_glyph_is_on_its_grid() {
        for c in (' '..='~').chain(['é']) {
            for polyline in strokes(c.to_ascii_uppercase()).split_ascii_whitespace() {
                assert_eq!(polyline.len() % 2, 0, "{c}");
                for p in polyline.as_bytes().chunks(2) {
                    assert!((b'0'..=b'4').contains(&p[0]) && (b'0'..=b'7').contains(&p[1]), "{c}");
                }
            }
        }
    }
}
