//! The server behind the page: one part, one page, this machine alone.
//!
//! It answers on loopback to whom [`Guard`] admits. It reads no file after it has
//! started and writes none but the tag file that it was started with. A request's
//! body is as long as the part has triangles, or the request is refused. One
//! extraction runs at a time, in the answer to the request that asked for it: when
//! the page goes away, its connection breaks, and the work stops.

use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

use glam::DVec3;
use serde_json::json;

use super::guard::{Guard, Refusal};
use super::http::{Answer, Request};
use super::job;
use super::page::{self, Asset};
use super::session::{Saved, Session, Subject};
use crate::io::write::{SurfaceFormat, SurfaceOptions, write_surface};
use crate::settings::cell::CellSize;
use crate::settings::progress::{Progress, Stop};

/// Connections at a time; a browser opens some six.
const CONNECTIONS: usize = 32;

/// Files that the browser can save the mid-surface as.
const DOWNLOADS: [&str; 5] = ["mid.html", "mid.obj", "mid.ply", "mid.stl", "mid.vtu"];

const BYTES: &str = "application/octet-stream";

/// A page that waits for its browser.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    guard: Guard,
    session: Session,
    ended: AtomicBool,
}

impl Server {
    /// Takes a port of loopback, a free one for 0.
    ///
    /// # Errors
    ///
    /// The system's, as when the port is taken.
    pub fn bind(subject: Subject, port: u16) -> io::Result<Server> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let port = listener.local_addr()?.port();
        Ok(Server {
            listener,
            guard: Guard::new(port).map_err(io::Error::other)?,
            session: Session::new(subject),
            ended: AtomicBool::new(false),
        })
    }

    /// The address to open, with its token.
    pub fn url(&self) -> String {
        self.guard.url()
    }

    /// Answers until the process ends, or [`Server::end`].
    pub fn run(&self) {
        let open = AtomicUsize::new(0);
        thread::scope(|scope| {
            for stream in self.listener.incoming() {
                if self.ended.load(Ordering::Relaxed) {
                    return;
                }
                let Ok(stream) = stream else { continue };
                if open.fetch_add(1, Ordering::Relaxed) < CONNECTIONS {
                    let serve = || {
                        // One that breaks off asks for nothing more.
                        let _ = self.serve(stream);
                        open.fetch_sub(1, Ordering::Relaxed);
                    };
                    // Without a thread for it the connection is closed, as one too many is.
                    if thread::Builder::new().spawn_scoped(scope, serve).is_err() {
                        open.fetch_sub(1, Ordering::Relaxed);
                    }
                } else {
                    open.fetch_sub(1, Ordering::Relaxed);
                }
            }
        });
    }

    /// Lets [`Server::run`] return once what runs is done.
    ///
    /// # Errors
    ///
    /// The system's, if the server cannot be woken.
    pub fn end(&self) -> io::Result<()> {
        self.ended.store(true, Ordering::Relaxed);
        TcpStream::connect(self.listener.local_addr()?).map(|_| ())
    }

    fn serve(&self, stream: TcpStream) -> io::Result<()> {
        let mut request = Request::read(stream)?;
        let target = match self.guard.admit(&request) {
            Ok(target) => target,
            Err(refusal) => return request.answer(&refused(refusal)),
        };
        let (path, query) = target.split_once('?').unwrap_or((&target, ""));
        let answer = match (request.method.as_str(), path) {
            ("GET", "part") => Answer::data(BYTES, self.session.part_pack()),
            ("GET", "measure") => {
                let told = self.session.measure().to_string();
                Answer::data("application/json", told.into_bytes())
            }
            ("GET", "thickness") => match place(query) {
                Some((triangle, at)) => {
                    let told = json!({ "thickness": self.session.thickness(triangle, at) });
                    Answer::data("application/json", told.to_string().into_bytes())
                }
                None => Answer::text("400 Bad Request", "TRIANGLE,X,Y,Z is missing"),
            },
            ("GET", "mid") => match self.session.shown() {
                Some(shown) => Answer::data(BYTES, shown.pack.clone()),
                None => Answer::text("204 No Content", ""),
            },
            ("GET", name) if DOWNLOADS.contains(&name) => self.download(name),
            ("GET", name) => match page::asset(name) {
                Some(Asset { text, kind }) => Answer::data(kind, text.as_bytes().to_vec()),
                None => refused(Refusal::Unknown),
            },
            ("POST", "tags") => match self.flags(&mut request)? {
                Some(flags) => {
                    self.session.tag(&flags);
                    Answer::text("200 OK", "")
                }
                None => wrong_length(),
            },
            ("POST", "save") => match self.flags(&mut request)? {
                Some(flags) => self.save(&flags, query == "replace"),
                None => wrong_length(),
            },
            ("POST", "extract") => match self.flags(&mut request)? {
                Some(flags) => return self.extract(request, flags, query),
                None => wrong_length(),
            },
            _ => refused(Refusal::Unknown),
        };
        request.answer(&answer)
    }

    /// The body: a byte a triangle, 1 for coping. None if its length is another.
    fn flags(&self, request: &mut Request) -> io::Result<Option<Vec<bool>>> {
        let count = self.session.subject().mesh.triangles.len();
        if request.length != Some(count) {
            return Ok(None);
        }
        let body = request.body(count)?;
        Ok(Some(body.into_iter().map(|byte| byte == 1).collect()))
    }

    fn save(&self, flags: &[bool], replace: bool) -> Answer {
        match self.session.save(flags, replace) {
            Ok(Saved::Written) => Answer::text("200 OK", ""),
            Ok(Saved::Exists) => Answer::text("409 Conflict", "exists"),
            Err(error) => Answer::text("500 Internal Server Error", &error.to_string()),
        }
    }

    fn extract(&self, request: Request, flags: Vec<bool>, query: &str) -> io::Result<()> {
        let cell = match query.strip_prefix("cell=").map(str::parse::<CellSize>) {
            Some(Ok(cell)) => cell,
            _ => {
                return request.answer(&Answer::text("400 Bad Request", "cell=LENGTH is missing"));
            }
        };
        let Some(_heavy) = self.session.heavy() else {
            let answer = Answer::text("409 Conflict", "an extraction is running already");
            return request.answer(&answer);
        };
        let work =
            |progress: &Progress, stop: &Stop| self.session.extract(flags, cell, progress, stop);
        job::stream(request.lines()?, work);
        Ok(())
    }

    /// The mid-surface as a file for the browser to save.
    fn download(&self, name: &str) -> Answer {
        let Some(shown) = self.session.shown() else {
            return refused(Refusal::Unknown);
        };
        let subject = self.session.subject();
        let mut bytes = Vec::new();
        let written = if name == "mid.html" {
            let Subject { title, mesh, .. } = subject;
            let coping = self.session.coping();
            page::write(title, mesh, &coping, &shown.pack, &mut bytes)
        } else {
            let Ok(format) = SurfaceFormat::of(name.as_ref()) else {
                return refused(Refusal::Unknown);
            };
            let options = SurfaceOptions::default();
            write_surface(&shown.surface, format, options, &mut bytes)
        };
        match written {
            Ok(()) => Answer {
                save_as: Some(name.to_owned()),
                ..Answer::data(BYTES, bytes)
            },
            Err(error) => Answer::text("500 Internal Server Error", &error.to_string()),
        }
    }
}

/// A triangle and a point: `TRIANGLE,X,Y,Z`.
fn place(query: &str) -> Option<(u32, DVec3)> {
    let mut words = query.split(',');
    let triangle = words.next()?.parse().ok()?;
    let mut number = || words.next()?.parse::<f64>().ok();
    Some((triangle, DVec3::new(number()?, number()?, number()?)))
}

fn refused(refusal: Refusal) -> Answer {
    match refusal {
        Refusal::Foreign => Answer::text(
            "403 Forbidden",
            "this page is for the browser that was sent here",
        ),
        Refusal::Unknown => Answer::text("404 Not Found", "nothing here"),
    }
}

fn wrong_length() -> Answer {
    Answer::text(
        "413 Content Too Large",
        "the body must hold a byte a triangle",
    )
}
