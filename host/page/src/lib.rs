//! Reports as one HTML file with all its pictures inside, for screen and print.
//!
//! [`svg`] draws, [`plot`] draws over axes, [`picture`] puts pictures into the page, and [`html`]
//! makes the page.

pub mod picture;
pub mod plot;
pub mod svg;

/// A page that needs no other file and no network. `body` is HTML; `title` is any text.
pub fn html(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>Tectum: {title}</title>\
         <style>{style}</style></head>\n<body>\n{body}</body>\n</html>\n",
        title = svg::escape(title),
        style = include_str!("style.css"),
    )
}
