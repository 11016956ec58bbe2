//! A connection: one request of HTTP/1.1 and its answer, then it ends.
//!
//! A browser opens connections ahead of its requests and keeps them open. Each has a thread of its own, so that
//! none waits for another; one on which nothing comes is closed after a while. tiny_http 0.12 was tried and left
//! a request waiting now and then: its pool hands two connections to one idle thread.

use super::http::{Answer, Request};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// Longest wait for a request.
const PATIENCE: Duration = Duration::from_secs(20);
/// Longest head of a request, bytes.
const HEAD_MAX: u64 = 16_384;
/// Longest body of an order, and longest that is read to be refused, bytes.
const BODY_MAX: u64 = 4096;
const REFUSED_MAX: u64 = 65_536;

/// Headers of every answer: nothing from elsewhere is loaded, nowhere is it framed, nothing is stored.
const HEADERS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
                       img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
                       frame-ancestors 'none'\r\nX-Content-Type-Options: nosniff\r\n\
                       Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
                       Cache-Control: no-store\r\nConnection: close\r\n";

/// Reads the request of a connection and has it answered.
///
/// # Errors
/// When the connection breaks off.
pub fn serve(stream: TcpStream, answer: impl FnOnce(&Request<'_>) -> Answer) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut reader = BufReader::new(&stream);
    let mut head = String::new();
    let mut lines = (&mut reader).take(HEAD_MAX);
    // A head ends with an empty line.
    while !head.ends_with("\r\n\r\n") {
        if lines.read_line(&mut head)? == 0 {
            return Ok(());
        }
    }
    let (first, headers) = head.split_once("\r\n").unwrap_or((&head, ""));
    let header = |name: &str| {
        let mut named = headers.lines().filter_map(|line| line.split_once(':'));
        named.find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, value)| value.trim())
    };
    let length: u64 = header("Content-Length").and_then(|length| length.parse().ok()).unwrap_or(0);
    let mut body = vec![0; length.min(REFUSED_MAX) as usize];
    reader.read_exact(&mut body)?;
    let mut words = first.split(' ');
    let (method, url) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let answer = match method {
        _ if length > BODY_MAX => Answer::text(413, "no order is so long"),
        "GET" | "HEAD" | "POST" => answer(&Request {
            is_order: method == "POST",
            url,
            host: header("Host"),
            origin: header("Origin"),
            body: &body,
        }),
        _ => Answer::text(405, "only GET, HEAD and POST are answered"),
    };
    let Answer { status, kind, body } = answer;
    let head = format!(
        "HTTP/1.1 {status} {}\r\n{HEADERS}Content-Type: {kind}\r\nContent-Length: {}\r\n\r\n",
        if status == 200 { "OK" } else { "Refused" },
        body.len()
    );
    let mut writer = &stream;
    writer.write_all(head.as_bytes())?;
    if method != "HEAD" {
        writer.write_all(&body)?;
    }
    writer.flush()
}
