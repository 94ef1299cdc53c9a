//! As much of HTTP/1.1 as one page needs: a request a connection, answered and
//! closed.
//!
//! A thread a connection, so that connections that a browser opens ahead of need
//! keep nobody waiting; how many, how long and how much is bounded.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Duration;

/// Longest request line and headers together; browsers send one or two thousand.
const HEAD_LIMIT: u64 = 16 << 10;

/// Most headers of a request.
const HEADERS_LIMIT: usize = 64;

/// Silence after which a connection is given up.
const PATIENCE: Duration = Duration::from_secs(30);

/// Sent with every answer: nothing is kept, guessed, framed or asked from elsewhere.
const HEADERS: &str = "Connection: close\r\n\
    Cache-Control: no-store\r\n\
    X-Content-Type-Options: nosniff\r\n\
    Referrer-Policy: no-referrer\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'\r\n";

/// What was asked.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) method: String,
    /// Path and query.
    pub(super) target: String,
    pub(super) host: Option<String>,
    pub(super) origin: Option<String>,
    /// Length of the body, if it is stated as a number.
    pub(super) length: Option<usize>,
    stream: BufReader<TcpStream>,
}

/// What is answered.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) status: &'static str,
    /// Media type.
    pub(super) kind: &'static str,
    /// Name under which the browser saves it, if it should.
    pub(super) save_as: Option<String>,
    pub(super) body: Vec<u8>,
}

impl Answer {
    pub(super) fn data(kind: &'static str, body: Vec<u8>) -> Answer {
        Answer {
            status: "200 OK",
            kind,
            save_as: None,
            body,
        }
    }

    pub(super) fn text(status: &'static str, words: &str) -> Answer {
        Answer {
            status,
            ..Answer::data("text/plain; charset=utf-8", words.as_bytes().to_vec())
        }
    }
}

impl Request {
    /// Reads the head of a request; what is none, or too long, is an error.
    pub(super) fn read(stream: TcpStream) -> io::Result<Request> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut stream = BufReader::new(stream);
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let left = HEAD_LIMIT.saturating_sub(head.len() as u64);
            let got = stream.by_ref().take(left).read_until(b'\n', &mut head)?;
            if got == 0 {
                return Err(io::ErrorKind::InvalidData.into());
            }
        }
        let mut headers = [httparse::EMPTY_HEADER; HEADERS_LIMIT];
        let mut parsed = httparse::Request::new(&mut headers);
        let status = parsed.parse(&head).map_err(io::Error::other)?;
        let (Some(method), Some(target), true) = (parsed.method, parsed.path, status.is_complete())
        else {
            return Err(io::ErrorKind::InvalidData.into());
        };
        let header = |name: &str| {
            let mut found = parsed
                .headers
                .iter()
                .filter(|h| h.name.eq_ignore_ascii_case(name));
            let value = found.next().and_then(|h| std::str::from_utf8(h.value).ok());
            // Said twice is not said.
            value.filter(|_| found.next().is_none()).map(str::to_owned)
        };
        Ok(Request {
            method: method.to_owned(),
            target: target.to_owned(),
            host: header("Host"),
            origin: header("Origin"),
            length: header("Content-Length").and_then(|text| text.parse().ok()),
            stream,
        })
    }

    /// The body, which must be of this length.
    pub(super) fn body(&mut self, length: usize) -> io::Result<Vec<u8>> {
        let mut body = vec![0; length];
        self.stream.read_exact(&mut body)?;
        Ok(body)
    }

    /// Answers and closes.
    pub(super) fn answer(self, answer: &Answer) -> io::Result<()> {
        let Answer {
            status,
            kind,
            save_as,
            body,
        } = answer;
        let mut stream = self.stream.into_inner();
        let save = save_as.as_ref().map_or(String::new(), |name| {
            format!("Content-Disposition: attachment; filename=\"{name}\"\r\n")
        });
        let length = body.len();
        write!(
            stream,
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{save}{HEADERS}\r\n"
        )?;
        stream.write_all(body)?;
        stream.flush()?;
        // What was not read would reset the connection before the answer is there.
        stream.shutdown(Shutdown::Write)?;
        let _ = io::copy(&mut stream.take(HEAD_LIMIT), &mut io::sink());
        Ok(())
    }

    /// An answer that comes line by line, each sent at once; it ends when the
    /// connection is closed.
    pub(super) fn lines(self) -> io::Result<Lines> {
        let mut stream = self.stream.into_inner();
        write!(
            stream,
            "HTTP/1.1 200 OK\r\nContent-Type: application/x-ndjson\r\n{HEADERS}\r\n"
        )?;
        stream.flush()?;
        Ok(Lines { stream })
    }
}

/// See [`Request::lines`].
#[derive(Debug)]
pub(super) struct Lines {
    stream: TcpStream,
}

impl Lines {
    pub(super) fn send(&mut self, line: &str) -> io::Result<()> {
        writeln!(self.stream, "{line}")?;
        self.stream.flush()
    }
}
