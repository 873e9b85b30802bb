//! Images of a log as grey levels.

use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};

use super::messages::RawImage;

/// The grey levels of an image, or what is wrong with it.
pub(super) fn grey(raw: &RawImage<'_>) -> Result<GrayImage, String> {
    let [width, height] = raw.size_px;
    let (channels, bytes_per_channel, order) = match raw.encoding {
        "mono8" | "8UC1" => (1, 1, [0, 0, 0]),
        "mono16" | "16UC1" => (1, 2, [0, 0, 0]),
        "rgb8" => (3, 1, [0, 1, 2]),
        "bgr8" | "8UC3" => (3, 1, [2, 1, 0]),
        "rgba8" => (4, 1, [0, 1, 2]),
        "bgra8" | "8UC4" => (4, 1, [2, 1, 0]),
        other => {
            return Err(format!(
                "the encoding `{other}`, of which only mono8, mono16, rgb8, bgr8, rgba8 and bgra8 are read"
            ));
        }
    };
    let row_bytes = (width as usize).saturating_mul(channels * bytes_per_channel);
    let whole = raw.step.saturating_mul(height as usize);
    if raw.step < row_bytes || raw.data.len() < whole || width == 0 || height == 0 {
        let n_bytes = raw.data.len();
        return Err(format!("{n_bytes} bytes, where {width} × {height} pixels of `{}` need more", raw.encoding));
    }
    // Of a value of two bytes the more significant one is taken.
    let significant = if bytes_per_channel == 2 && !raw.is_big_endian { 1 } else { 0 };
    let rows = raw.data.chunks_exact(raw.step).take(height as usize).map(|row| &row[..row_bytes]);
    let pixels = rows.flat_map(|row| row.chunks_exact(channels * bytes_per_channel));
    if channels == 1 {
        let levels: Vec<u8> = pixels.map(|pixel| pixel[significant]).collect();
        return GrayImage::from_raw(width, height, levels).ok_or_else(|| "too few pixels".to_owned());
    }
    let colours: Vec<u8> = pixels.flat_map(|pixel| order.map(|channel| pixel[channel])).collect();
    let image = RgbImage::from_raw(width, height, colours).ok_or_else(|| "too few pixels".to_owned())?;
    Ok(DynamicImage::ImageRgb8(image).into_luma8())
}

/// The grey levels of an image in a file of its own, or what is wrong with it. The format is that of the file's first bytes, as what a message calls
/// its format differs from writer to writer.
pub(super) fn grey_of_file(format: &str, data: &[u8]) -> Result<GrayImage, String> {
    let known = image::guess_format(data).ok().filter(|kind| [ImageFormat::Jpeg, ImageFormat::Png].contains(kind));
    let Some(kind) = known else { return Err(format!("the format `{format}`, of which only JPEG and PNG are read")) };
    let decoded = image::load_from_memory_with_format(data, kind);
    decoded.map(DynamicImage::into_luma8).map_err(|error| format!("an image that does not decode: {error}"))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn raw<'a>(encoding: &'a str, step: usize, data: &'a [u8]) -> RawImage<'a> {
        RawImage { size_px: [2, 1], encoding, is_big_endian: false, step, data }
    }

    #[test]
    fn each_encoding_gives_its_grey_levels() {
        assert_eq!(grey(&raw("mono8", 3, &[7, 9, 0])).unwrap().into_raw(), [7, 9]);
        assert_eq!(grey(&raw("mono16", 4, &[1, 7, 2, 9])).unwrap().into_raw(), [7, 9]);
        let red_then_blue = grey(&raw("rgb8", 6, &[255, 0, 0, 0, 0, 255])).unwrap().into_raw();
        let blue_then_red = grey(&raw("bgr8", 6, &[255, 0, 0, 0, 0, 255])).unwrap().into_raw();
        assert!(red_then_blue[0] > red_then_blue[1] && red_then_blue[0] == blue_then_red[1], "{red_then_blue:?}");
    }

    #[test]
    fn an_unknown_encoding_and_too_few_bytes_are_named() {
        assert!(grey(&raw("bayer_rggb8", 2, &[0, 0])).unwrap_err().contains("bayer_rggb8"));
        assert!(grey(&raw("rgb8", 6, &[0; 5])).unwrap_err().contains("5 bytes"));
        assert!(grey(&raw("rgb8", 5, &[0; 9])).is_err());
    }

    #[test]
    fn the_more_significant_bytes_of_padded_rows_are_read_in_either_order() {
        let of = |is_big_endian: bool, data: &[u8]| {
            grey(&RawImage { size_px: [2, 2], encoding: "mono16", is_big_endian, step: 6, data }).unwrap().into_raw()
        };
        assert_eq!(of(true, &[7, 1, 9, 2, 50, 51, 11, 3, 13, 4, 52, 53]), [7, 9, 11, 13]);
        assert_eq!(of(false, &[1, 7, 2, 9, 50, 51, 3, 11, 4, 13, 52, 53]), [7, 9, 11, 13]);
    }
}
