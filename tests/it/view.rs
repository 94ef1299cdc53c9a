//! The page in the browser, as far as it goes without one; `tools/view_test.py` has
//! the rest.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::common::fixture;

/// A running `midsurf view`, ended with the test.
struct View {
    child: Child,
    host: String,
    token: String,
}

impl View {
    fn of(part: &Path) -> View {
        let mut child = Command::new(env!("CARGO_BIN_EXE_midsurf"))
            .arg("view")
            .arg(part)
            .args(["--coping", "none", "--no-open"])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let address = lines.next().unwrap().unwrap();
        let address = address.strip_prefix("http://").unwrap();
        let (host, token) = address.split_once('/').unwrap();
        View {
            child,
            host: host.to_owned(),
            token: token.trim_end_matches('/').to_owned(),
        }
    }

    /// Sends a request below the token and gives status and body.
    fn ask(&self, method: &str, name: &str, body: &[u8]) -> (u16, Vec<u8>) {
        let host = &self.host;
        let head = format!(
            "{method} /{}/{name} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Length: {}\r\n\r\n",
            self.token,
            body.len()
        );
        self.send(&[head.as_bytes(), body].concat())
    }

    fn send(&self, bytes: &[u8]) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        let _ = stream.write_all(bytes);
        let mut answer = Vec::new();
        // Hanging up in the middle is an answer too.
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n");
        let Some(end) = end else {
            return (0, answer);
        };
        let head = std::str::from_utf8(&answer[..end]).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, answer[end + 4..].to_vec())
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A copy of the plate in a folder of its own.
fn plate() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("plate.obj");
    std::fs::copy(fixture("plate.obj"), &part).unwrap();
    (folder, part)
}

#[test]
fn what_is_tagged_is_saved_and_extracted() {
    let (folder, part) = plate();
    let view = View::of(&part);
    let loaded = midsurf::io::read_mesh(&part).unwrap();
    let tags = fixture("plate.coping.txt");
    let flags = midsurf::coping::read_tags(tags, &loaded, &part)
        .unwrap()
        .flags;
    let body: Vec<u8> = flags.iter().map(|&flag| u8::from(flag)).collect();

    assert_eq!(view.ask("GET", "mid", b"").0, 204);
    let (status, lines) = view.ask("POST", "extract?cell=1t", &body);
    let text = String::from_utf8(lines).unwrap();
    assert_eq!(status, 200);
    assert!(
        text.lines().last().unwrap().contains("\"result\""),
        "{text}"
    );
    let (status, ply) = view.ask("GET", "mid.ply", b"");
    assert!(status == 200 && ply.starts_with(b"ply"));
    let (status, page) = view.ask("GET", "mid.html", b"");
    assert!(status == 200 && page.starts_with(b"<!DOCTYPE html>"));

    // What is tagged since then is what a page and a reload show, saved or not.
    let coping = |pack: &[u8]| -> usize {
        let text = String::from_utf8_lossy(pack);
        assert!(text.contains("coping"));
        pack.len()
    };
    let before = view.ask("GET", "part", b"").1;
    let fewer: Vec<u8> = (0..body.len()).map(|n| u8::from(n == 0)).collect();
    assert_eq!(view.ask("POST", "tags", &fewer).0, 200);
    let after = view.ask("GET", "part", b"").1;
    assert_eq!(coping(&before), coping(&after));
    assert_ne!(before, after);
    assert_ne!(view.ask("GET", "mid.html", b"").1, page);
    assert_eq!(view.ask("POST", "tags", &body).0, 200);
    assert_eq!(view.ask("GET", "part", b"").1, before);
    assert_eq!(view.ask("GET", "mid.html", b"").1, page);
    assert_eq!(view.ask("POST", "tags", b"1").0, 413);

    assert_eq!(view.ask("POST", "save", &body).0, 200);
    let saved = folder.path().join("plate.coping.toml");
    let read = midsurf::coping::read_tags(&saved, &loaded, &part).unwrap();
    assert_eq!(read.flags, flags);
    // Only that one file was written, and again only because it is its own.
    assert_eq!(view.ask("POST", "save", &body).0, 200);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn tags_of_others_are_not_replaced_unasked() {
    let (folder, part) = plate();
    let tags = folder.path().join("plate.coping.toml");
    std::fs::write(&tags, "precious").unwrap();
    let view = View::of(&part);
    assert_eq!(view.ask("POST", "save", &[1; 12]).0, 409);
    assert_eq!(std::fs::read_to_string(&tags).unwrap(), "precious");
    assert_eq!(view.ask("POST", "save?replace", &[1; 12]).0, 200);
    assert!(
        std::fs::read_to_string(&tags)
            .unwrap()
            .contains("coping-tags")
    );
}

/// Whatever is sent, the server answers or hangs up, and goes on.
#[test]
fn nonsense_is_refused() {
    let (_folder, part) = plate();
    let view = View::of(&part);
    let below = format!("/{}/part", view.token);
    let host = &view.host;
    for (text, status) in [
        (format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"), 404),
        (format!("GET {below} HTTP/1.1\r\nHost: {host}\r\n\r\n"), 200),
        (
            format!("GET {below} HTTP/1.1\r\nHost: a.example\r\n\r\n"),
            403,
        ),
        (
            format!("GET {below} HTTP/1.1\r\nHost: {host}\r\nHost: {host}\r\n\r\n"),
            403,
        ),
        (
            format!("GET {below} HTTP/1.1\r\nHost: {host}\r\nOrigin: null\r\n\r\n"),
            403,
        ),
        (format!("GET {below} HTTP/1.1\r\n\r\n"), 403),
        ("GET\r\n\r\n".to_owned(), 0),
        ("\u{1}\u{2}\r\n\r\n".to_owned(), 0),
        (
            format!("GET {below} HTTP/1.1\r\nX: {}\r\n\r\n", "x".repeat(20_000)),
            0,
        ),
    ] {
        assert_eq!(view.send(text.as_bytes()).0, status, "{text}");
    }
    for (name, body, status) in [
        ("save", &[1; 11][..], 413),
        ("extract?cell=1t", &[][..], 413),
        ("extract", &[0; 12][..], 400),
        ("extract?cell=-1", &[0; 12][..], 400),
        ("../Cargo.toml", &[][..], 404),
        ("page.html", &[][..], 404),
    ] {
        assert_eq!(view.ask("POST", name, body).0, status, "{name}");
    }
    let (status, text) = view.ask("POST", "extract?cell=1t", &[1; 12]);
    assert_eq!(status, 200);
    let text = String::from_utf8(text).unwrap();
    assert!(
        text.contains("\"error\"") && text.contains("coping"),
        "{text}"
    );
}

#[test]
fn one_file_holds_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("mid.html");
    let done = Command::new(env!("CARGO_BIN_EXE_midsurf"))
        .arg("extract")
        .arg(fixture("tee.obj"))
        .arg("--coping")
        .arg(fixture("tee.coping.txt"))
        .args(["--quiet", "-o"])
        .arg(&page)
        .status()
        .unwrap();
    assert!(done.success());
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("id=\"pack-part\"") && text.contains("id=\"pack-mid\""));
    assert!(!text.contains("src=") && !text.contains("://"));
}

/// Thickness is told at points of the part before anything is extracted, and cells are
/// counted about right.
#[test]
fn walls_are_measured_where_they_are_pointed_at() {
    let (_folder, part) = plate();
    let view = View::of(&part);
    let told = |query: &str| -> serde_json::Value {
        let (status, body) = view.ask("GET", query, b"");
        assert_eq!(status, 200, "{query}");
        serde_json::from_slice(&body).unwrap()
    };
    let mesh = midsurf::io::read_mesh(&part).unwrap().mesh;
    let large = mesh
        .faces()
        .max_by(|&f, &g| mesh.triangle_area(f).total_cmp(&mesh.triangle_area(g)));
    let face = large.unwrap();
    let at = mesh.corners(face).iter().sum::<glam::DVec3>() / 3.0;
    let query = format!("thickness?{},{},{},{}", face.0, at.x, at.y, at.z);
    assert!(told(&query)["thickness"].is_null());
    let measured = told("measure");
    let thickness = told(&query)["thickness"].as_f64().unwrap();
    assert!((thickness - measured["thickness"].as_f64().unwrap()).abs() < 1e-9);
    for query in ["thickness?", "thickness?1,2,3", "thickness?x,0,0,0"] {
        assert_eq!(view.ask("GET", query, b"").0, 400, "{query}");
    }
    assert!(told("thickness?999999,0,0,0")["thickness"].is_null());
    assert!(told("thickness?0,nan,0,0")["thickness"].is_null());

    let loaded = midsurf::io::read_mesh(&part).unwrap();
    let tags = midsurf::coping::read_tags(fixture("plate.coping.txt"), &loaded, &part).unwrap();
    let flags: Vec<u8> = tags.flags.iter().map(|&flag| u8::from(flag)).collect();
    assert_eq!(view.ask("POST", "tags", &flags).0, 200);
    let measured = told("measure");
    let (_, lines) = view.ask("POST", "extract?cell=1t", &flags);
    let text = String::from_utf8(lines).unwrap();
    let last: serde_json::Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    let cells = last["result"]["cells"].as_f64().unwrap();
    let counted = measured["cells_at_thickness"].as_f64().unwrap();
    assert!(
        (0.5..2.0).contains(&(counted / cells)),
        "{counted} of {cells}"
    );
}
