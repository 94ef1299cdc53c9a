//! The page itself: its files, and how they become one.

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

use super::scene;
use crate::mesh::TriMesh;

const HTML: &str = include_str!("page/page.html");
const CSS: &str = include_str!("page/page.css");

/// In the order in which they build on each other.
const SCRIPTS: [(&str, &str); 10] = [
    ("camera.js", include_str!("page/camera.js")),
    ("shaders.js", include_str!("page/shaders.js")),
    ("scene.js", include_str!("page/scene.js")),
    ("tagging.js", include_str!("page/tagging.js")),
    ("colors.js", include_str!("page/colors.js")),
    ("panel.js", include_str!("page/panel.js")),
    ("places.js", include_str!("page/places.js")),
    ("work.js", include_str!("page/work.js")),
    ("input.js", include_str!("page/input.js")),
    ("start.js", include_str!("page/start.js")),
];

/// Where the page names its style and its scripts, to be replaced by them.
const STYLE_LINK: &str = "<link rel=\"stylesheet\" href=\"page.css\">";

/// A file of the page.
pub(super) struct Asset {
    pub(super) text: &'static str,
    pub(super) kind: &'static str,
}

/// A file by the name that the page asks for.
pub(super) fn asset(name: &str) -> Option<Asset> {
    let (text, kind) = match name {
        "" => (HTML, "text/html; charset=utf-8"),
        "page.css" => (CSS, "text/css; charset=utf-8"),
        _ => {
            let (_, text) = SCRIPTS.iter().find(|(script, _)| *script == name)?;
            (*text, "text/javascript; charset=utf-8")
        }
    };
    Some(Asset { text, kind })
}

/// Writes the page as one file: style, scripts, part and mid-surface inside. It may
/// ask nothing of any network, and says so to the browser.
pub(super) fn write(
    title: &str,
    mesh: &TriMesh,
    coping: &[bool],
    surface: &[u8],
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut part = scene::part(mesh, coping, &[], false);
    part.fact("title", title);
    let part = part.finish();
    let policy = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
                  script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:\">";
    let mut html = HTML.replace(STYLE_LINK, &format!("{policy}\n<style>\n{CSS}</style>"));
    for (name, text) in SCRIPTS {
        let link = format!("<script defer src=\"{name}\"></script>\n");
        html = html.replace(&link, "");
        // Inline scripts run where they stand, so they stand at the end.
        html = html.replace("</body>", &format!("<script>\n{text}</script>\n</body>"));
    }
    let (head, rest) = html.split_once("<script>").unwrap_or((&html, ""));
    out.write_all(head.as_bytes())?;
    for (id, pack) in [("pack-part", part.as_slice()), ("pack-mid", surface)] {
        write!(out, "<script type=\"application/gzip\" id=\"{id}\">")?;
        let mut zip = GzEncoder::new(Vec::new(), Compression::default());
        zip.write_all(pack)?;
        out.write_all(STANDARD.encode(zip.finish()?).as_bytes())?;
        writeln!(out, "</script>")?;
    }
    write!(out, "<script>{rest}")
}

#[cfg(test)]
mod tests {
    use super::{HTML, SCRIPTS, STYLE_LINK, asset, write};
    use crate::mesh::TriMesh;

    #[test]
    fn the_page_names_all_its_files_and_no_others() {
        assert!(HTML.contains(STYLE_LINK));
        for (name, _) in SCRIPTS {
            let link = format!("<script defer src=\"{name}\"></script>\n");
            assert_eq!(HTML.matches(&link).count(), 1, "{name}");
            assert!(asset(name).is_some());
        }
        assert_eq!(HTML.matches("src=").count(), SCRIPTS.len());
        for name in ["..", "page/page.css", "/etc/passwd", "mod.rs"] {
            assert!(asset(name).is_none(), "{name}");
        }
    }

    #[test]
    fn one_file_names_no_other() {
        let mut out = Vec::new();
        let mesh = TriMesh::default();
        write("a <b>", &mesh, &[], b"", &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(!text.contains("src=") && !text.contains("href=\"page"));
        for (_, script) in SCRIPTS {
            assert!(text.contains(script));
        }
        assert!(!text.contains("http://") && !text.contains("https://"));
    }
}
