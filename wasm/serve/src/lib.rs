//! A folder on a local port, for this machine alone: what `cargo web serve` and `voxdag view` have in common.
//!
//! In: a folder, files from elsewhere under names of their own, a port. Out: answers to GET with the MIME types that
//! browsers insist on for modules and wasm. Nothing outside the folder and those files can be asked for.

use std::fs::File;
use std::io;
use std::path::{Component, Path, PathBuf};

use tiny_http::{Header, Method, Request, Response, Server};

/// Requests that are answered at the same time.
const THREADS: usize = 8;

/// A folder that is ready to be served.
pub struct Site {
    server: Server,
    root: PathBuf,
    /// By name.
    others: Vec<(String, PathBuf)>,
}

impl Site {
    /// Takes the port on 127.0.0.1, 0 for any free one.
    pub fn new(root: &Path, port: u16) -> io::Result<Site> {
        let server = Server::http(("127.0.0.1", port)).map_err(io::Error::other)?;
        Ok(Site { server, root: root.to_path_buf(), others: Vec::new() })
    }

    /// Also serves a file from elsewhere, under a name in the folder.
    pub fn with(mut self, name: &str, path: &Path) -> Site {
        self.others.push((name.to_owned(), path.to_path_buf()));
        self
    }

    /// Where it is found.
    pub fn url(&self) -> String {
        let address = self.server.server_addr().to_ip();
        address.map_or(String::new(), |address| format!("http://{address}/"))
    }

    /// Answers requests, for ever; some at a time, as a browser that reads slowly would hold up the others.
    pub fn run(&self) {
        std::thread::scope(|threads| {
            for _ in 0..THREADS {
                threads.spawn(|| {
                    while let Ok(request) = self.server.recv() {
                        // A browser that went away is no reason to stop.
                        let _ = self.answer(request);
                    }
                });
            }
        });
    }

    fn answer(&self, request: Request) -> io::Result<()> {
        if !matches!(request.method(), Method::Get | Method::Head) {
            return request.respond(Response::empty(405));
        }
        let found = self.find(request.url()).and_then(|path| Some((mime(&path), File::open(&path).ok()?)));
        let Some((kind, file)) = found else {
            return request.respond(Response::from_string("there is no such file\n").with_status_code(404));
        };
        let header =
            |name: &str, value: &str| Header::from_bytes(name, value).map_err(|()| io::ErrorKind::InvalidInput);
        let kind = header("Content-Type", kind)?;
        // What was built again is to be seen at once.
        request.respond(Response::from_file(file).with_header(kind).with_header(header("Cache-Control", "no-cache")?))
    }

    /// The file that a URL stands for.
    fn find(&self, url: &str) -> Option<PathBuf> {
        let name = url.split(['?', '#']).next()?.trim_start_matches('/');
        if let Some((_, path)) = self.others.iter().find(|(other, _)| other == name) {
            return Some(path.clone());
        }
        let inside = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        let path = self.root.join(if name.is_empty() { "index.html" } else { name });
        (inside && path.is_file()).then_some(path)
    }
}

/// By the end of the name.
fn mime(path: &Path) -> &'static str {
    match path.extension().and_then(|end| end.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("json") => "application/json",
        Some("png") => "image/png",
        Some("svg") => "image/svg+xml",
        Some("ts" | "md" | "obj" | "mtl") => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::TcpStream;

    /// The status and the type of what is answered.
    fn ask(address: &str, path: &str) -> (String, String) {
        let mut stream = TcpStream::connect(address).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: here\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let status = answer.lines().next().unwrap().split(' ').nth(1).unwrap().to_owned();
        let kind = answer.lines().find_map(|line| line.strip_prefix("Content-Type: ")).unwrap_or("").to_owned();
        (status, kind)
    }

    #[test]
    fn files_of_the_folder_and_no_others() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let site = Site::new(&root.join("src"), 0).unwrap().with("scene.vxd", &root.join("Cargo.toml"));
        let address = site.url().trim_start_matches("http://").trim_end_matches('/').to_owned();
        std::thread::spawn(move || site.run());
        assert_eq!(ask(&address, "/lib.rs?x=1"), ("200".into(), "application/octet-stream".into()));
        assert_eq!(ask(&address, "/scene.vxd").0, "200");
        for outside in ["/", "/../Cargo.toml", "//etc/passwd", "/lib.rs/..", "/nothing"] {
            assert_eq!(ask(&address, outside).0, "404", "{outside}");
        }
        assert_eq!(mime(Path::new("a/b.wasm")), "application/wasm");
    }
}
