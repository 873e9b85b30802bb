//! An animated PNG (APNG) of at most 255 colours, written frame by frame: each frame holds only the pixels that differ from the frame before.

use std::{collections::HashMap, io::Write};

use image::{Rgb, RgbImage};
use png::{
    BitDepth, BlendOp, ColorType, DeflateCompression, DisposeOp, Encoder, EncodingError, Filter, SrgbRenderingIntent,
    Writer,
};

use super::super::palette;

/// Index of the colour that leaves a pixel as it was in the frame before.
const UNCHANGED: u8 = 0;
/// Number of greys, from black to white. With more of them the noise of the cameras' images makes a film larger, with fewer steps become visible.
const GREYS: u32 = 25;
/// Shares in percent in which a colour is drawn over another: at smooth edges, and in areas through which one can see.
const SHARES: [u32; 7] = [12, 25, 35, 50, 65, 82, 100];
/// Least number of neighbouring pixels in a row that are left out of a frame because they have not changed. Single ones among changed pixels would
/// disturb the compression: eight frames of three noisy cameras are a sixth smaller than with every unchanged pixel left out.
const LEAST_UNCHANGED: usize = 32;
/// How hard the images are compressed, from 0 to 9. A film is 5 % smaller than by level 6.
const DEFLATE_LEVEL: u8 = 9;

/// An animated PNG that is being written.
pub(super) struct Animation<W: Write> {
    writer: Writer<W>,
    colours: Vec<Rgb<u8>>,
    /// Index of the nearest colour to each colour that has occurred.
    nearest: HashMap<[u8; 3], u8>,
    /// Indices of the colours of the frame before, row by row.
    before: Vec<u8>,
    width_px: usize,
}

/// A rectangle of pixels: the left and upper edges, which belong to it, and the right and lower ones, which do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Changed {
    left: usize,
    top: usize,
    right: usize,
    bottom: usize,
}

impl<W: Write> Animation<W> {
    /// Begins an animation of this size and number of frames, which is shown again and again.
    pub(super) fn begin(out: W, [width_px, height_px]: [u32; 2], n_frames: usize) -> Result<Self, EncodingError> {
        let colours = colours();
        let mut encoder = Encoder::new(out, width_px, height_px);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_palette(colours.iter().flat_map(|colour| colour.0).collect::<Vec<u8>>());
        let opacities: Vec<u8> =
            (0..colours.len()).map(|index| if index == usize::from(UNCHANGED) { 0 } else { 255 }).collect();
        encoder.set_trns(opacities);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        // Neighbouring indices are no neighbouring colours, so that a filter would only disturb the compression.
        encoder.set_filter(Filter::NoFilter);
        encoder.set_deflate_compression(DeflateCompression::Level(DEFLATE_LEVEL));
        // A run has far fewer frames than this; 0 plays means without end.
        encoder.set_animated(u32::try_from(n_frames).unwrap_or(u32::MAX), 0)?;
        encoder.set_dispose_op(DisposeOp::None)?;
        encoder.set_blend_op(BlendOp::Over)?;
        let writer = encoder.write_header()?;
        Ok(Animation { writer, colours, nearest: HashMap::new(), before: Vec::new(), width_px: width_px as usize })
    }

    /// Adds a frame that is shown for so many hundredths of a second.
    pub(super) fn add(&mut self, frame: &RgbImage, shown_hundredths: u16) -> Result<(), EncodingError> {
        let indices: Vec<u8> = frame.pixels().map(|pixel| self.index_of(*pixel)).collect();
        let changed = changed(&self.before, &indices, self.width_px);
        self.writer.set_frame_delay(shown_hundredths, 100)?;
        // The first frame of an animation fills it, and the writer begins with its whole size.
        if !self.before.is_empty() {
            self.writer.reset_frame_position()?;
            self.writer
                .set_frame_dimension(as_u32(changed.right - changed.left), as_u32(changed.bottom - changed.top))?;
            self.writer.set_frame_position(as_u32(changed.left), as_u32(changed.top))?;
        }
        let mut data = Vec::with_capacity((changed.right - changed.left) * (changed.bottom - changed.top));
        for row in changed.top..changed.bottom {
            let part = row * self.width_px + changed.left..row * self.width_px + changed.right;
            let start = data.len();
            data.extend_from_slice(&indices[part.clone()]);
            if let Some(before) = self.before.get(part) {
                leave_out_unchanged(&mut data[start..], before);
            }
        }
        self.before = indices;
        self.writer.write_image_data(&data)
    }

    /// Writes the end of the animation.
    pub(super) fn finish(self) -> Result<(), EncodingError> {
        self.writer.finish()
    }

    /// Index of the colour of the animation that is nearest to a colour.
    fn index_of(&mut self, pixel: Rgb<u8>) -> u8 {
        let colours = &self.colours;
        *self.nearest.entry(pixel.0).or_insert_with(|| {
            let distance = |colour: &Rgb<u8>| -> u32 {
                colour.0.iter().zip(pixel.0).map(|(one, other)| u32::from(one.abs_diff(other)).pow(2)).sum()
            };
            let drawn = colours.iter().enumerate().skip(1);
            // There are at most 256 colours, so that the index fits.
            drawn.min_by_key(|(_, colour)| distance(colour)).map_or(UNCHANGED, |(index, _)| index as u8)
        })
    }
}

/// The colours of every film: the one that leaves pixels unchanged, greys, and the colours of the drawings with those between them and what they are
/// drawn over. They are the same in all frames, because a PNG has one palette.
fn colours() -> Vec<Rgb<u8>> {
    let mut colours = vec![Rgb([0; 3])];
    colours.extend((0..GREYS).map(|index| Rgb([(255 * index / (GREYS - 1)) as u8; 3])));
    colours.extend([
        palette::PAPER,
        palette::INK,
        palette::FAINT_INK,
        palette::WALL,
        palette::JOINT,
        palette::REGION,
        palette::FURNITURE,
    ]);
    let over = |colour: Rgb<u8>, ground: Rgb<u8>| {
        let mixed = move |share: u32| {
            let channel = |index: usize| {
                let (drawn, below) = (u32::from(colour.0[index]), u32::from(ground.0[index]));
                ((drawn * share + below * (100 - share) + 50) / 100) as u8
            };
            Rgb([0, 1, 2].map(channel))
        };
        SHARES.map(mixed)
    };
    let drawn =
        [palette::PEOPLE, palette::MARKER, palette::ROUTE, palette::TRAIL, palette::BOX, palette::MISS, palette::TRUTH];
    for (colour, ground) in drawn.into_iter().flat_map(|colour| [(colour, palette::ROOM), (colour, palette::REGION)]) {
        colours.extend(over(colour, ground));
    }
    for (colour, ground) in [palette::BOX, palette::MISS].map(|colour| (colour, palette::FURNITURE)) {
        colours.extend(over(colour, ground));
    }
    let seen = [palette::SEEN, palette::FALSE, palette::REJECTED];
    for (colour, ground) in seen.into_iter().flat_map(|colour| [(colour, palette::ROOM), (colour, palette::WALL)]) {
        colours.extend(over(colour, ground));
    }
    colours
}

/// Replaces those pixels of a part of a row by [`UNCHANGED`] that are the same as in the frame before over a length worth it.
fn leave_out_unchanged(row: &mut [u8], before: &[u8]) {
    let mut from = 0;
    while from < row.len() {
        let is_same = |at: usize| row[at] == before[at];
        let same = (from..row.len()).take_while(|at| is_same(*at)).count();
        if same >= LEAST_UNCHANGED || same == row.len() {
            row[from..from + same].fill(UNCHANGED);
        }
        from += same.max(1);
    }
}

/// The smallest rectangle that holds all pixels that have changed; the whole frame without a frame before, and one pixel where nothing has changed.
fn changed(before: &[u8], now: &[u8], width_px: usize) -> Changed {
    if before.is_empty() {
        return Changed { left: 0, top: 0, right: width_px, bottom: now.len() / width_px.max(1) };
    }
    let mut bounds: Option<Changed> = None;
    let differing = before.iter().zip(now).enumerate().filter(|(_, (before, now))| before != now);
    for (index, _) in differing {
        let (column, row) = (index % width_px, index / width_px);
        let one = Changed { left: column, top: row, right: column + 1, bottom: row + 1 };
        bounds = Some(bounds.map_or(one, |so_far| Changed {
            left: so_far.left.min(one.left),
            top: so_far.top,
            right: so_far.right.max(one.right),
            bottom: one.bottom,
        }));
    }
    bounds.unwrap_or(Changed { left: 0, top: 0, right: 1, bottom: 1 })
}

fn as_u32(pixels: usize) -> u32 {
    // The size of the animation was given as 32-bit numbers, and no part of it is larger.
    u32::try_from(pixels).unwrap_or(u32::MAX)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_palette_has_each_colour_of_the_drawings_and_fits_into_a_byte() {
        let colours = colours();
        assert!(colours.len() <= 256, "{}", colours.len());
        for colour in [palette::BOX, palette::MISS, palette::TRUTH, palette::SEEN, palette::PAPER, palette::ROOM] {
            assert!(colours[1..].contains(&colour), "{colour:?}");
        }
    }

    type Shown = (Vec<u8>, [u32; 4], u16);

    /// For each frame of an animation the indices of its pixels, its place and size, and how many hundredths of a second it is shown.
    fn shown(bytes: &[u8]) -> Result<Vec<Shown>, png::DecodingError> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info()?;
        let n_frames = reader.info().animation_control().map_or(0, |control| control.num_frames);
        let mut frames = Vec::new();
        for _ in 0..n_frames {
            let mut data = vec![0; 64];
            let length = reader.next_frame(&mut data)?.buffer_size();
            data.truncate(length);
            let placed = reader
                .info()
                .frame_control()
                .map(|frame| ([frame.x_offset, frame.y_offset, frame.width, frame.height], frame.delay_num));
            frames.extend(placed.map(|(place, hundredths)| (data, place, hundredths)));
        }
        Ok(frames)
    }

    #[test]
    fn unchanged_pixels_are_left_out_where_there_are_many_in_a_row() {
        let before = [vec![7; 80], vec![1, 2]].concat();
        let mut row = [vec![7; 40], vec![8], vec![7; 39], vec![3, 2]].concat();
        row[45] = 9;
        leave_out_unchanged(&mut row, &before);
        assert_eq!(row[..40], [UNCHANGED; 40]);
        assert_eq!(row[40..46], [8, 7, 7, 7, 7, 9], "too few between two changed pixels");
        assert_eq!(row[46..80], [UNCHANGED; 34]);
        assert_eq!(row[80..], [3, 2], "too few at the end");
    }

    #[test]
    fn a_frame_holds_only_what_has_changed() {
        let mut bytes = Vec::new();
        let mut animation = Animation::begin(&mut bytes, [4, 3], 3).unwrap();
        let mut frame = RgbImage::from_pixel(4, 3, palette::ROOM);
        animation.add(&frame, 12).unwrap();
        frame.put_pixel(1, 1, palette::BOX);
        frame.put_pixel(2, 2, palette::BOX);
        animation.add(&frame, 12).unwrap();
        animation.add(&frame, 200).unwrap();
        animation.finish().unwrap();
        let frames = shown(&bytes).unwrap();
        let index = |colour: Rgb<u8>| colours().iter().position(|one| *one == colour).unwrap() as u8;
        let (room, boxed) = (index(palette::ROOM), index(palette::BOX));
        assert_eq!(frames[0], (vec![room; 12], [0, 0, 4, 3], 12));
        assert_eq!(frames[1], (vec![boxed, room, room, boxed], [1, 1, 2, 2], 12));
        assert_eq!(frames[2], (vec![UNCHANGED], [0, 0, 1, 1], 200));
    }
}
