//! The documentation page: complete, self-contained, well-formed; and, on request, as displayed by
//! Chromium.

use fmu_build::page;
use quick_xml::events::Event;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use vibro_paper_component::component::variables::{Kind, VARIABLES, find};

/// The page of an archive without the live page.
fn page() -> String {
    page::page(false)
}

#[test]
fn every_variable_has_name_unit_range_and_meaning() {
    let page = page();
    let rows: Vec<Vec<&str>> = page
        .lines()
        .filter_map(|line| line.strip_prefix("<tr><td><code>"))
        .map(|row| row.trim_end_matches("</td></tr>").split("</td><td>").collect())
        .collect();
    assert_eq!(rows.len(), VARIABLES.len());
    for variable in &VARIABLES {
        let cell = format!("{}</code>", variable.name);
        let row = rows.iter().find(|row| row[0] == cell).expect(variable.name);
        let [_, meaning, unit, start, range, kind] = row[..] else { panic!("{row:?}") };
        assert!(meaning.len() > 3 && !range.is_empty() && kind.contains(", "), "{row:?}");
        assert_eq!(start.is_empty(), variable.start().is_none(), "{row:?}");
        if let Kind::Real { .. } = variable.kind {
            let (unit, lengths) = unit.split_once('[').unwrap_or((unit, ""));
            assert_eq!(unit.trim(), variable.unit().unwrap_or(""), "{row:?}");
            assert_eq!(lengths.is_empty(), variable.dimensions.is_empty(), "{row:?}");
        }
    }
}

/// A new variable is at the end of the table and still under its own heading.
#[test]
fn every_variable_stands_under_its_heading() {
    let page = page();
    let mut heading = "";
    for line in page.lines() {
        if let Some(rest) = line.strip_prefix("<tr class=\"group\"><th colspan=\"6\">") {
            heading = rest.trim_end_matches("</th></tr>");
        } else if let Some(rest) = line.strip_prefix("<tr><td><code>") {
            let variable = find(rest.split("</code>").next().unwrap()).unwrap();
            assert_eq!(heading, variable.section.heading(), "{}", variable.name);
        }
    }
}

#[test]
fn the_recipes_are_those_of_the_documentation() {
    let page = page();
    let page_of_docs = include_str!("../../docs/paper-machine.md");
    let (_, recipes) = page_of_docs.split_once("\n## Recipes\n").expect("the section");
    let titles: Vec<&str> = recipes.lines().filter_map(|line| line.strip_prefix("### ")).collect();
    assert_eq!(titles.len(), 4);
    for title in titles {
        assert!(page.contains(&format!("<h3>{title}</h3>")), "{title}");
    }
    assert_eq!(page.matches("language-python").count(), recipes.matches("```python").count());
    for absent in ["vibro run --config", "use vibro_impact", "target/VibroImpact3DOF.fmu"] {
        assert!(!page.contains(absent), "{absent}");
    }
}

/// Element by element: every tag is closed, no address loads anything, there is no script, and
/// every internal link has a target.
#[test]
fn the_page_needs_nothing_from_outside() {
    let page = page();
    assert!(!page.contains("{{"), "a part of the template was not filled in");
    let mut reader = quick_xml::Reader::from_str(&page);
    let (mut ids, mut links, mut pictures, mut formulas) = (BTreeSet::new(), BTreeSet::new(), 0, 0);
    loop {
        let event = reader.read_event().unwrap_or_else(|e| panic!("{e} at {}", reader.error_position()));
        let (Event::Start(tag) | Event::Empty(tag)) = &event else {
            if matches!(event, Event::Eof) { break } else { continue }
        };
        let name = tag.name().as_ref().to_owned();
        assert!(!["script", "link", "iframe", "object", "embed"].contains(&name.as_str()), "<{name}>");
        pictures += usize::from(name == "svg");
        formulas += usize::from(name == "math");
        for attribute in tag.attributes() {
            let attribute = attribute.unwrap();
            let key = attribute.key.as_ref();
            let value = attribute.value.as_ref();
            match key {
                "id" => assert!(ids.insert(value.to_owned()), "{value} twice"),
                // The only file next to it, which is packed with it.
                "href" if value == "fmi-ls-ref.txt" => {}
                "href" => drop(links.insert(value.strip_prefix('#').expect("within the page").to_owned())),
                "src" | "xlink:href" | "data" | "srcset" => panic!("{key}={value}"),
                _ => {}
            }
        }
    }
    // Anything referred to by an address is in the page.
    let addresses = page.split("url(").skip(1).map(|rest| rest.split(')').next().unwrap_or_default());
    links.extend(addresses.map(|a| a.strip_prefix('#').expect("within the page").to_owned()));
    assert!(!page.contains("@import"));
    assert!(links.is_subset(&ids), "{:?}", links.difference(&ids));
    assert_eq!(pictures, 3, "sketch, run, response");
    assert!(formulas > 10, "{formulas}");
}

#[test]
fn the_live_page_is_linked_where_it_is_packed_and_nothing_else_changes() {
    let (with, without) = (page::page(true), page());
    let link = "<a href=\"explorer.html\">";
    assert_eq!((with.matches(link).count(), without.matches(link).count()), (1, 0));
    let rest: String = with.lines().filter(|line| !line.contains(link)).collect();
    assert_eq!(rest, without.replace('\n', ""));
    assert!(!with.contains("<script"));
}

/// Path of Chromium, from `CHROMIUM` or the path.
fn chromium() -> PathBuf {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let usual = ["chromium", "chromium-browser", "google-chrome"].map(PathBuf::from);
    let candidates = named.map_or_else(|| usual.to_vec(), |path| vec![path]);
    let works = |path: &&PathBuf| Command::new(path).arg("--version").output().is_ok();
    candidates.iter().find(works).cloned().unwrap_or_else(|| {
        panic!("none of {candidates:?} runs: install Chromium (Debian: apt install chromium) or name it in CHROMIUM")
    })
}

fn browse(arguments: &[&str], page: &Path, profile: &Path) -> (String, String) {
    let output = Command::new(chromium())
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--force-device-scale-factor=1",
        ])
        .args(["--enable-logging=stderr", "--virtual-time-budget=5000"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(arguments)
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}", text(&output.stderr));
    (text(&output.stdout), text(&output.stderr))
}

/// Inspects the page from inside and stores the findings in an attribute of the document.
const PROBE: &str = r#"<script>
const errors = [];
addEventListener("error", (e) => errors.push(e.message || ("cannot load " + e.target.outerHTML)), true);
addEventListener("load", () => {
  const shown = (e) => { const r = e.getBoundingClientRect(); return r.width > 3 && r.height > 3; };
  for (const svg of document.querySelectorAll("svg")) {
    const drawn = [...svg.querySelectorAll("path, polyline, rect, text, circle, line, polygon")].filter((e) => {
      const b = e.getBBox(); return b.width > 0 || b.height > 0; });
    if (!shown(svg) || drawn.length < 10) errors.push("picture not drawn: " + svg.getAttribute("aria-label"));
    if (svg.getBoundingClientRect().right > innerWidth) errors.push("picture cut off: " + svg.getAttribute("aria-label"));
  }
  for (const image of document.images) if (!image.naturalWidth) errors.push("picture missing: " + image.src);
  for (const formula of document.querySelectorAll("math")) {
    if (!shown(formula)) errors.push("formula not shown: " + formula.textContent);
  }
  // Text on its background by WCAG 2.2, 1.4.3.
  const light = (c) => { const [r, g, b] = c.match(/[\d.]+/g).map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92
    : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05; };
  const ground = (e) => { const c = getComputedStyle(e).backgroundColor;
    return c !== "rgba(0, 0, 0, 0)" ? c : e.parentElement ? ground(e.parentElement) : "rgb(255, 255, 255)"; };
  for (const e of document.querySelectorAll("p, li, a, th, td, pre, code, figcaption, h1, h2, h3, dt, dd, math")) {
    const [a, b] = [light(getComputedStyle(e).color), light(ground(e))];
    if (Math.max(a, b) / Math.min(a, b) < 4.5) errors.push("unreadable: " + e.textContent.slice(0, 40));
  }
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.setAttribute("data-scheme", dark && light(ground(document.body)) < 0.3 ? "dark" : "light");
  const fraction = document.querySelector("mfrac");
  const high = fraction.getBoundingClientRect().height / parseFloat(getComputedStyle(fraction).fontSize);
  if (high < 1.5) errors.push("MathML is not laid out");
  if (document.documentElement.scrollWidth > innerWidth) errors.push("the page is wider than the window");
  for (const r of performance.getEntriesByType("resource")) errors.push("loaded " + r.name);
  document.documentElement.setAttribute("data-found", "found:" + errors.join("; ") + ":end");
});
</script>"#;

#[test]
#[ignore = "needs Chromium (Debian: apt install chromium)"]
fn chromium_shows_the_page_without_errors_or_missing_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let (file, profile) = (folder.path().join("index.html"), folder.path().join("profile"));
    // Headless Chromium's narrowest window is 500 pixels wide.
    for (width, scheme) in [(1280, "light"), (1280, "dark"), (700, "light"), (500, "light"), (500, "dark")] {
        std::fs::write(&file, page().replacen("</title>", &format!("</title>{PROBE}"), 1)).unwrap();
        let size = format!("--window-size={width},900");
        let preferred = format!("--blink-settings=preferredColorScheme={}", u8::from(scheme == "light"));
        let (dom, log) = browse(&[&size, &preferred, "--dump-dom"], &file, &profile);
        let found = dom.split("data-found=\"found:").nth(1).and_then(|rest| rest.split(":end\"").next());
        assert_eq!(found, Some(""), "at {width} pixels, {scheme}");
        assert!(dom.contains(&format!("data-scheme=\"{scheme}\"")), "{scheme}");
        let complaints: Vec<&str> = log.lines().filter(|line| line.contains(":CONSOLE")).collect();
        assert!(complaints.is_empty(), "{complaints:?}");
    }
    // Kept for inspection by a person.
    std::fs::write(&file, page()).unwrap();
    let picture = fmu_build::compile::target().join("documentation.png");
    let target = format!("--screenshot={}", picture.display());
    browse(&["--window-size=1200,6200", &target], &file, &profile);
    println!("{}", picture.display());
    assert!(std::fs::metadata(&picture).unwrap().len() > 100_000);
}

/// A test of the probe: it reports a missing picture.
#[test]
#[ignore = "needs Chromium (Debian: apt install chromium)"]
fn chromium_tells_of_a_missing_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (file, profile) = (folder.path().join("index.html"), folder.path().join("profile"));
    let broken = page().replacen("</title>", &format!("</title>{PROBE}"), 1);
    std::fs::write(&file, broken.replacen("<h2", "<img src=\"nothing.png\" alt=\"\"/><h2", 1)).unwrap();
    let (dom, _) = browse(&["--window-size=1280,900", "--dump-dom"], &file, &profile);
    assert!(dom.contains("picture missing") && dom.contains("cannot load"), "{}", &dom[..400]);
}

/// Draws each picture of `pictures` in a canvas at each width and counts the data of its diagrams
/// (the bordered rectangles) over whose middle no pixel has the colour of a datum.
const COUNT: &str = r#"<script>
addEventListener("load", async () => {
  const lines = [];
  for (const text of pictures) {
    const svg = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    const [, , across, up] = svg.getAttribute("viewBox").split(" ").map(Number);
    const paths = [...svg.querySelectorAll("path[shape-rendering]")];
    const channels = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
    const colours = new Set(paths.map((p) => channels(p.getAttribute("fill")).join()));
    const data = paths.flatMap((path) => {
      let [x, y] = [0, 0];
      for (let e = path.parentElement; e; e = e.parentElement) {
        const by = /translate\(([-\d.]+) ([-\d.]+)\)/.exec(e.getAttribute("transform") ?? "");
        if (by) [x, y] = [x + Number(by[1]), y + Number(by[2])];
      }
      const each = path.getAttribute("d").matchAll(/M([-\d.]+) ([-\d.]+)h([\d.]+)v([\d.]+)/g);
      return [...each].map((m) => m.slice(1).map(Number)).map(([a, b, w, h]) => [a + x + w / 2, b + y, h]);
    });
    const image = new Image();
    image.src = "data:image/svg+xml," + encodeURIComponent(text);
    await image.decode();
    for (const width of widths) {
      const scale = width / across, height = Math.round(up * scale);
      const paper = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
      paper.drawImage(image, 0, 0, width, height);
      const pixels = paper.getImageData(0, 0, width, height).data;
      const coloured = (x, y) => { const i = 4 * (y * width + x);
        return colours.has([pixels[i], pixels[i + 1], pixels[i + 2]].join()); };
      const seen = data.filter(([x, y, h]) => { const column = Math.floor(x * scale);
        for (let row = Math.floor(y * scale - 1); row <= Math.ceil((y + h) * scale); row++) {
          if (coloured(column, row)) return true;
        } return false; });
      lines.push(seen.length + " of " + data.length);
    }
  }
  document.documentElement.setAttribute("data-found", "found:" + lines.join(",") + ":end");
});
</script>"#;

/// Every datum of two diagrams of the gallery is drawn at widths from a phone's up: one diagram
/// has bars of one pixel at the native width, the other thousands of cells.
#[test]
#[ignore = "needs Chromium (Debian: apt install chromium)"]
fn chromium_draws_every_datum_of_a_diagram_at_any_width() {
    /// Widths in pixels: of a phone, of a text column, and the pictures' own.
    const WIDTHS: [u32; 5] = [300, 500, 700, 830, 988];
    /// Minimum numbers of rectangles in the two pictures.
    const LEAST: [usize; 2] = [60, 200];
    let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/gallery");
    let read = |name: &str| std::fs::read_to_string(gallery.join(name)).unwrap();
    let pictures = ["iwan_joint_response.svg", "paper_machine.svg"].map(read);
    let page =
        format!("<!DOCTYPE html><script>const pictures = {pictures:?}, widths = {WIDTHS:?};</script>{COUNT}");
    let folder = tempfile::tempdir().unwrap();
    let (file, profile) = (folder.path().join("index.html"), folder.path().join("profile"));
    std::fs::write(&file, page).unwrap();
    let (dom, log) = browse(&["--dump-dom"], &file, &profile);
    let found = dom.split("data-found=\"found:").nth(1).and_then(|rest| rest.split(":end\"").next());
    let counts: Vec<&str> = found.unwrap_or_else(|| panic!("{log}")).split(',').collect();
    assert_eq!(counts.len(), WIDTHS.len() * pictures.len());
    for (count, least) in counts.iter().zip(LEAST.into_iter().flat_map(|least| [least; WIDTHS.len()])) {
        let (seen, all) = count.split_once(" of ").unwrap();
        assert!(seen == all && all.parse::<usize>().unwrap() >= least, "{counts:?}");
    }
}
