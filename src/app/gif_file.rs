//! Pictures to an animated GIF: one palette for all of them, and of each picture only what has changed since the last.

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Write;

/// Entries of the palette; one more stands for what has not changed.
const COLORS: usize = 255;
const UNCHANGED: u8 = COLORS as u8;
/// Pixels that the palette is made from, at most.
const SAMPLE: usize = 120_000;
/// Every which sample the quantiser looks at: 1 is the best and slowest.
const SPEED: i32 = 3;

/// A picture of red, green and blue bytes, row by row.
pub(super) type Pixels = Vec<[u8; 3]>;

/// Writes pictures of `width` x `height` pixels, each shown for `hundredths` of a second, again and again.
///
/// # Errors
/// What the encoder and the file say. Pictures of another size are refused by the encoder.
pub(super) fn write_gif(
    file: impl Write,
    (width, height): (u16, u16),
    pictures: &[Pixels],
    hundredths: u16,
) -> Result<(), EncodingError> {
    let step = (pictures.iter().map(Vec::len).sum::<usize>() / SAMPLE).max(1);
    let opaque = |[r, g, b]: &[u8; 3]| [*r, *g, *b, 255];
    // The quantiser counts in fours and wants a few thousand of them.
    let mut sample: Vec<u8> = pictures.iter().flatten().step_by(step).flat_map(opaque).collect();
    while sample.len() < 4 * 4096 && !sample.is_empty() {
        sample.extend_from_within(..);
    }
    let quantiser = NeuQuant::new(SPEED, COLORS, &sample);
    let palette = quantiser.color_map_rgb();
    let mut encoder = Encoder::new(file, width, height, &palette)?;
    encoder.set_repeat(Repeat::Infinite)?;

    let mut known: HashMap<[u8; 3], u8> = HashMap::new();
    let mut before: Vec<u8> = Vec::new();
    for picture in pictures {
        let find = |color: &[u8; 3]| *known.entry(*color).or_insert_with(|| quantiser.index_of(&opaque(color)) as u8);
        let now: Vec<u8> = picture.iter().map(find).collect();
        let changed = |(k, &index): (usize, &u8)| if before.get(k) == Some(&index) { UNCHANGED } else { index };
        let buffer: Vec<u8> = now.iter().enumerate().map(changed).collect();
        encoder.write_frame(&Frame {
            width,
            height,
            buffer: Cow::Owned(buffer),
            delay: hundredths,
            dispose: DisposalMethod::Keep,
            transparent: Some(UNCHANGED),
            ..Frame::default()
        })?;
        before = now;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a viewer shows after each frame.
    fn shown(bytes: &[u8]) -> Vec<Pixels> {
        let mut decoder = gif::DecodeOptions::new().read_info(bytes).unwrap();
        let palette = decoder.global_palette().unwrap().to_vec();
        let mut screen: Pixels = Vec::new();
        let mut pictures = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            screen.resize(frame.buffer.len(), [0; 3]);
            for (pixel, &index) in screen.iter_mut().zip(frame.buffer.iter()) {
                if Some(index) != frame.transparent {
                    let at = 3 * usize::from(index);
                    *pixel = [palette[at], palette[at + 1], palette[at + 2]];
                }
            }
            pictures.push(screen.clone());
        }
        pictures
    }

    #[test]
    fn a_moving_square_comes_back_as_it_was_drawn() {
        let (ice, cloth) = ([225, 236, 245], [40, 60, 130]);
        let draw = |k: usize| -> Pixels {
            let inside = |x: usize, y: usize| (k..k + 8).contains(&x) && (4..12).contains(&y);
            (0..32 * 16).map(|i| if inside(i % 32, i / 32) { cloth } else { ice }).collect()
        };
        let pictures: Vec<Pixels> = (0..6).map(draw).collect();
        let mut file = Vec::new();
        write_gif(&mut file, (32, 16), &pictures, 5).unwrap();
        let near = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 4);
        for (k, (was, is)) in pictures.iter().zip(shown(&file)).enumerate() {
            assert_eq!(was.len(), is.len());
            assert!(was.iter().zip(is).all(|(a, b)| near(*a, b)), "picture {k} has another colour");
        }
        // Most of a picture is that of the one before, and costs next to nothing.
        assert!(file.len() < 6 * 32 * 16 / 2, "{} bytes", file.len());
    }

    #[test]
    fn a_picture_of_another_size_is_refused() {
        assert!(write_gif(Vec::new(), (32, 16), &[vec![[0; 3]; 7]], 5).is_err());
    }
}
