//! A4 pages of a PDF with discs, lines and text, placed in millimetres from the upper-left corner.

use pdf_writer::{Content, Name, Pdf, Rect, Ref, Str};

/// Width and height of an A4 page.
pub(super) const A4_MM: [f64; 2] = [210.0, 297.0];
const POINTS_PER_MM: f64 = 72.0 / 25.4;
/// Length of the control handles, as a share of the radius, of a cubic curve that approximates a quarter of a circle to 0.03 % of its radius.
const QUARTER: f64 = 0.552_285;
/// Name by which pages refer to the one font of the file.
const FONT: Name = Name(b"F");

/// One page of a PDF with what is drawn on it.
pub(super) struct Page {
    content: Content,
}

impl Page {
    /// An empty page.
    pub(super) fn new() -> Page {
        let mut content = Content::new();
        // Transforms positions on the page from millimetres, with y pointing down, into points, with y pointing up.
        let scale = POINTS_PER_MM as f32;
        content.transform([scale, 0.0, 0.0, -scale, 0.0, (A4_MM[1] * POINTS_PER_MM) as f32]);
        Page { content }
    }

    /// Draws a black disc.
    pub(super) fn disc(&mut self, [x, y]: [f64; 2], radius_mm: f64) {
        let (r, q) = (radius_mm, QUARTER * radius_mm);
        self.content.move_to((x + r) as f32, y as f32);
        for [a, b, c, d, e, f] in
            [[r, q, q, r, 0.0, r], [-q, r, -r, q, -r, 0.0], [-r, -q, -q, -r, 0.0, -r], [q, -r, r, -q, r, 0.0]]
        {
            let [a, b, c, d, e, f] = [x + a, y + b, x + c, y + d, x + e, y + f].map(|at| at as f32);
            self.content.cubic_to(a, b, c, d, e, f);
        }
        self.content.fill_nonzero();
    }

    /// Draws a thin black line.
    pub(super) fn line(&mut self, [x, y]: [f64; 2], [to_x, to_y]: [f64; 2]) {
        self.content.set_line_width(0.2);
        self.content.move_to(x as f32, y as f32).line_to(to_x as f32, to_y as f32).stroke();
    }

    /// Writes a line of ASCII text that begins at a point on its baseline.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], height_mm: f64, text: &str) {
        self.content.begin_text().set_font(FONT, height_mm as f32);
        self.content.set_text_matrix([1.0, 0.0, 0.0, -1.0, x as f32, y as f32]);
        self.content.show(Str(text.as_bytes())).end_text();
    }
}

/// A PDF file of the given pages.
pub(super) fn document(pages: Vec<Page>) -> Vec<u8> {
    let mut numbers = (1..).map(Ref::new);
    let mut next = || numbers.next().unwrap_or(Ref::new(1));
    let (catalog, tree, font) = (next(), next(), next());
    let pages: Vec<(Ref, Ref, Page)> = pages.into_iter().map(|page| (next(), next(), page)).collect();
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(tree);
    pdf.pages(tree).kids(pages.iter().map(|(page, ..)| *page)).count(pages.len() as i32);
    pdf.type1_font(font).base_font(Name(b"Helvetica"));
    let [width, height] = A4_MM.map(|side_mm| (side_mm * POINTS_PER_MM) as f32);
    for (page, content, drawn) in pages {
        let mut sheet = pdf.page(page);
        sheet.parent(tree).media_box(Rect::new(0.0, 0.0, width, height)).contents(content);
        sheet.resources().fonts().pair(FONT, font);
        drop(sheet);
        pdf.stream(content, &drawn.content.finish());
    }
    pdf.finish()
}
