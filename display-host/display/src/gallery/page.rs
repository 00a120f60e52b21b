//! The page of all pictures, and the contact sheet.

use std::fmt::Write as _;

use figures::html::escape;
use image::RgbaImage;
use image::imageops::{FilterType, replace, resize};

use super::{Chapter, Picture};

/// Number of pictures in a row of the sheet.
const COLUMNS: u32 = 5;
/// Width of a picture on the sheet, pixels.
const THUMB_WIDTH_PX: u32 = 320;
/// Gap between pictures on the sheet, pixels.
const GAP_PX: u32 = 6;

const STYLE: &str = "\
body{background:#14161a;color:#e6e6e6;font:16px/1.4 system-ui,sans-serif;margin:24px}\
main{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:14px}\
figure{margin:0}img{width:100%;display:block;border-radius:4px;background:#000}\
figcaption{padding:4px 2px;color:#b9c0c8}h1{font-size:22px}h2{font-size:18px;margin-top:28px}";

/// The page: chapters of pictures, each linked to its full-size file.
pub(super) fn html(scene: &str, adapter: &str, pictures: &[Picture]) -> String {
    let (scene, adapter) = (escape(scene), escape(adapter));
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot's gallery: {scene}</title>\
         <style>{STYLE}</style><h1>{scene}</h1><p>{} pictures, drawn by {adapter}</p>\n",
        pictures.len()
    );
    for chapter in Chapter::ALL {
        let mut found = pictures.iter().filter(|p| p.chapter == chapter).peekable();
        if found.peek().is_none() {
            continue;
        }
        let _ = writeln!(page, "<h2>{}</h2><main>", chapter.title());
        for Picture { file, title, .. } in found {
            let title = escape(title);
            let _ = writeln!(
                page,
                "<figure><a href=\"{file}\"><img src=\"{file}\" alt=\"{title}\" loading=\"lazy\">\
                 </a><figcaption>{title}</figcaption></figure>"
            );
        }
        page.push_str("</main>\n");
    }
    page + "</html>\n"
}

/// All pictures side by side, reduced.
pub(super) fn sheet(pictures: &[RgbaImage]) -> RgbaImage {
    let Some((width, height)) = pictures.first().map(RgbaImage::dimensions) else {
        return RgbaImage::new(1, 1);
    };
    let thumb = [
        THUMB_WIDTH_PX,
        (THUMB_WIDTH_PX * height / width.max(1)).max(1),
    ];
    let rows = (pictures.len() as u32).div_ceil(COLUMNS);
    let grey = image::Rgba([40, 43, 48, 255]);
    let place = |cell: u32, side: u32| cell * (side + GAP_PX) + GAP_PX;
    let mut sheet = RgbaImage::from_pixel(place(COLUMNS, thumb[0]), place(rows, thumb[1]), grey);
    for (cell, picture) in (0..).zip(pictures) {
        let small = resize(picture, thumb[0], thumb[1], FilterType::Triangle);
        let [x, y] = [
            place(cell % COLUMNS, thumb[0]),
            place(cell / COLUMNS, thumb[1]),
        ];
        replace(&mut sheet, &small, i64::from(x), i64::from(y));
    }
    sheet
}
