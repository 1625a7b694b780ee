//! HTML pages in a single file, without script or network, light or dark, for any width.

use vibro_figures::html::escape;

const STYLE: &str = ":root{color-scheme:light dark;--text:#222;--paper:#fff;--line:#ccc;--head:#f3f3f3;--yes:#e2f2e6;\
--partly:#fdf3d8;--no:#f9dedc;--note:#eef3fa;--small:#555}\
@media (prefers-color-scheme:dark){:root{--text:#e4e4e4;--paper:#16181b;--line:#555;--head:#2a2d31;--yes:#173a24;\
--partly:#423510;--no:#4a2020;--note:#1f2c3c;--small:#b8b8b8}}\
body{font:16px/1.5 sans-serif;color:var(--text);background:var(--paper);max-width:1200px;margin:2em auto;padding:0 1em;\
overflow-wrap:break-word}h1,h2,h3{line-height:1.2}.wide{overflow-x:auto}table{border-collapse:collapse;width:100%}\
td,th{border:1px solid var(--line);padding:.4em .6em;text-align:left;vertical-align:top}th{background:var(--head)}\
td.n{text-align:right;white-space:nowrap}img{max-width:100%;height:auto;border:1px solid var(--line)}\
.agrees{background:var(--yes)}.partly{background:var(--partly)}.differs{background:var(--no)}\
.note{background:var(--note);padding:.8em 1em}small{color:var(--small)}\
figure{margin:1em 0;background:#fff}figure svg{width:100%;min-width:760px;height:auto;display:block}.verdict{padding:.8em 1em}pre{white-space:pre-wrap}";

/// A page with a title and the HTML of its body.
pub(super) fn document(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>{}</title>\
         <style>{STYLE}</style></head>\n<body>\n{body}</body></html>\n",
        escape(title)
    )
}

/// A table with a heading. Cells are HTML, in columns that scroll if the page is narrow.
pub(super) fn table(header: &[String], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let row = |cells: Vec<String>| {
        let cell = |(i, cell): (usize, &String)| match i {
            0 => format!("<th>{cell}</th>"),
            _ => format!("<td class=\"n\">{cell}</td>"),
        };
        format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
    };
    let names: String = header.iter().map(|name| format!("<th>{name}</th>")).collect();
    let rows: String = rows.into_iter().map(row).collect();
    format!("<div class=\"wide\"><table><tr>{names}</tr>\n{rows}</table></div>\n")
}
