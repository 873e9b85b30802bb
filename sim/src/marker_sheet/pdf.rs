//! Just enough of PDF 1.4 (ISO 32000) for pages of A4 with discs, lines and text, in millimetres from the upper left corner.

use std::fmt::Write as _;

/// Width and height of A4.
pub(super) const A4_MM: [f64; 2] = [210.0, 297.0];
const POINTS_PER_MM: f64 = 72.0 / 25.4;
/// Handle of the cubic that is a quarter of a circle to 0.03 % of its radius.
const QUARTER: f64 = 0.552_285;

/// One page: what is drawn on it.
#[derive(Clone, Debug)]
pub(super) struct Page {
    content: String,
}

impl Page {
    /// An empty one.
    pub(super) fn new() -> Page {
        // From millimetres downwards to points upwards.
        let [_, height_mm] = A4_MM;
        Page { content: format!("{POINTS_PER_MM} 0 0 {} 0 {} cm\n", -POINTS_PER_MM, height_mm * POINTS_PER_MM) }
    }

    /// A black disc.
    pub(super) fn disc(&mut self, [x, y]: [f64; 2], radius_mm: f64) {
        let (r, q) = (radius_mm, QUARTER * radius_mm);
        let _ = writeln!(self.content, "{} {y} m", x + r);
        for [a, b, c, d, e, f] in
            [[r, q, q, r, 0.0, r], [-q, r, -r, q, -r, 0.0], [-r, -q, -q, -r, 0.0, -r], [q, -r, r, -q, r, 0.0]]
        {
            let _ = writeln!(self.content, "{} {} {} {} {} {} c", x + a, y + b, x + c, y + d, x + e, y + f);
        }
        self.content.push_str("f\n");
    }

    /// A thin black line.
    pub(super) fn line(&mut self, [x, y]: [f64; 2], [to_x, to_y]: [f64; 2]) {
        let _ = writeln!(self.content, "0.2 w {x} {y} m {to_x} {to_y} l S");
    }

    /// A line of text of ASCII letters, begun at a place on its base line.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], height_mm: f64, text: &str) {
        let escaped = text.replace('\\', "\\\\").replace('(', "\\(").replace(')', "\\)");
        let _ = writeln!(self.content, "BT /F {height_mm} Tf 1 0 0 -1 {x} {y} Tm ({escaped}) Tj ET");
    }
}

/// A file of these pages.
pub(super) fn document(pages: &[Page]) -> String {
    let [width, height] = A4_MM.map(|side_mm| side_mm * POINTS_PER_MM);
    let kids: String = (0..pages.len()).map(|index| format!("{} 0 R ", 4 + 2 * index)).collect();
    let mut objects = vec![
        "<< /Type /Catalog /Pages 2 0 R >>".to_owned(),
        format!("<< /Type /Pages /Kids [{kids}] /Count {} >>", pages.len()),
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>".to_owned(),
    ];
    for (index, page) in pages.iter().enumerate() {
        objects.push(format!(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Resources << /Font << /F 3 0 R >> >> /Contents {} 0 R >>",
            5 + 2 * index
        ));
        objects.push(format!("<< /Length {} >>\nstream\n{}endstream", page.content.len(), page.content));
    }
    let mut file = "%PDF-1.4\n".to_owned();
    let mut offsets = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        offsets.push(file.len());
        let _ = write!(file, "{} 0 obj\n{object}\nendobj\n", index + 1);
    }
    let table_at = file.len();
    let _ = write!(file, "xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for offset in offsets {
        let _ = writeln!(file, "{offset:010} 00000 n ");
    }
    let _ = write!(file, "trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{table_at}\n%%EOF\n", objects.len() + 1);
    file
}
