//! The preview as friendly, slow and hostile clients meet it.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use tectum_capture::preview::{Fixed, Picture, Preview, Snapshot};
use tectum_capture::{FrameFormat, Health, Layout};

const FORMAT: FrameFormat = FrameFormat {
    layout: Layout::Grey,
    size_px: [64, 32],
    stride_bytes: 64,
    full_range: true,
};

fn preview() -> Preview {
    let fixed = Fixed {
        direction: Some(Box::new(|query| {
            let x = query.iter().find(|(key, _)| key == "x");
            x.map(|(_, x)| format!("{{\"x\":{x}}}"))
                .ok_or_else(|| "needed is x".to_owned())
        })),
        scales_png: None,
        eyes: [
            Some(("one \"eye\"".to_owned(), Arc::new(Health::default()))),
            None,
        ],
    };
    Preview::serve("127.0.0.1:0".parse().unwrap(), fixed).unwrap()
}

fn snapshot(number: u64) -> Snapshot {
    Snapshot {
        number,
        stitched: Some(Picture::new(&[number as u8; 64 * 32], FORMAT)),
        left: None,
        right: None,
    }
}

/// Sends `request` as it is; what comes back until the connection ends.
fn exchange(address: SocketAddr, request: &[u8]) -> Vec<u8> {
    let mut stream = TcpStream::connect(address).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    // A server that refuses half-way may close before all is sent.
    let _ = stream.write_all(request);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    answer
}

fn get(address: SocketAddr, path: &str) -> (u16, Vec<u8>) {
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    split(&exchange(address, request.as_bytes()))
}

/// Status and body.
fn split(answer: &[u8]) -> (u16, Vec<u8>) {
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n");
    let head = String::from_utf8_lossy(&answer[..end.unwrap_or(answer.len())]);
    let status = head.split(' ').nth(1).and_then(|code| code.parse().ok());
    let body = end.map_or(Vec::new(), |end| answer[end + 4..].to_vec());
    (status.unwrap_or(0), body)
}

#[test]
fn the_page_and_nothing_else_is_served() {
    let preview = preview();
    let address = preview.address();
    let (status, page) = get(address, "/");
    assert_eq!(status, 200);
    let page = String::from_utf8(page).unwrap();
    assert!(page.contains("<title>Tectum</title>"));
    assert!(!page.contains("http"), "something from outside: {page}");
    for path in [
        "/page.css",
        "/page.js",
        "/status.json",
        "/icon.svg",
        "/direction.json?x=3",
    ] {
        assert_eq!(get(address, path).0, 200, "{path}");
    }
    for path in [
        "/etc/passwd",
        "/../../etc/passwd",
        "/%2e%2e/x",
        "/page.js/",
        "//",
        "/scales.png",
    ] {
        assert_eq!(get(address, path).0, 404, "{path}");
    }
    assert_eq!(get(address, "/direction.json?y=3").0, 400);
    let status: serde_json::Value =
        serde_json::from_slice(&get(address, "/status.json").1).unwrap();
    assert_eq!(status["left"]["source"], "one \"eye\"");
    assert!(status["right"].is_null());
}

#[test]
fn writing_foreign_names_and_malformed_requests_are_refused() {
    let address = preview().address();
    let code = |request: &str| split(&exchange(address, request.as_bytes())).0;
    for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
        let request = format!(
            "{method} / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"
        );
        assert_eq!(code(&request), 405, "{method}");
    }
    // A name that leads here by someone else's doing.
    assert_eq!(
        code("GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"),
        403
    );
    assert_eq!(code("GET / HTTP/1.0\r\n\r\n"), 403);
    for bad in [
        "nonsense\r\n\r\n",
        "GET /\r\n\r\n",
        "GET / HTTP/9\r\n\r\n",
        "\0\0\0\0\r\n\r\n",
    ] {
        assert_eq!(code(bad), 400, "{bad:?}");
    }
    let long = format!(
        "GET /{} HTTP/1.1\r\nHost: localhost\r\n\r\n",
        "x".repeat(100_000)
    );
    assert!(matches!(code(&long), 414 | 431), "{}", code(&long));
    let headers = "X-Long: y\r\n".repeat(10_000);
    let many = format!("GET / HTTP/1.1\r\nHost: localhost\r\n{headers}\r\n");
    assert_eq!(code(&many), 431);
    // And it is still there.
    assert_eq!(get(address, "/").0, 200);
}

#[test]
fn pictures_are_new_ones_and_the_same_for_all() {
    let preview = preview();
    let address = preview.address();
    assert!(!preview.is_due(), "nobody looks");
    // Nothing yet: the client waits and is told to ask again.
    assert_eq!(get(address, "/stitched.jpg").0, 204);
    assert!(preview.is_due(), "somebody looks");
    preview.publish(snapshot(7));
    assert!(!preview.is_due(), "a picture has just been left");
    let (status, jpeg) = get(address, "/stitched.jpg");
    assert_eq!(status, 200);
    let picture = image::load_from_memory(&jpeg).unwrap().into_luma8();
    assert_eq!(picture.dimensions(), (64, 32));
    assert!(picture.get_pixel(5, 5).0[0].abs_diff(7) <= 2);
    // There is no newer one, and no left eye.
    assert_eq!(get(address, "/stitched.jpg?after=7").0, 204);
    assert_eq!(get(address, "/left.jpg").0, 404);
}

#[test]
fn fifty_clients_of_which_some_stall_do_not_slow_who_publishes() {
    let preview = preview();
    let address = preview.address();
    let over = Arc::new(AtomicBool::new(false));
    // Ten ask and never read; ten never finish asking.
    let mut stalled = Vec::new();
    for i in 0..20 {
        let mut stream = TcpStream::connect(address).unwrap();
        let request: &[u8] = if i % 2 == 0 {
            b"GET /stitched.jpg HTTP/1.1\r\nHost: localhost\r\n\r\n"
        } else {
            b"GET /stitched.jpg HTTP/1.1\r\nHost: loc"
        };
        stream.write_all(request).unwrap();
        stalled.push(stream);
    }
    let clients: Vec<_> = (0..50)
        .map(|_| {
            let over = over.clone();
            std::thread::spawn(move || {
                let mut pictures = 0;
                while !over.load(Ordering::Relaxed) {
                    pictures += u32::from(get(address, "/stitched.jpg").0 == 200);
                }
                pictures
            })
        })
        .collect();
    let mut slowest = Duration::ZERO;
    for number in 0..100 {
        let begun = Instant::now();
        preview.publish(snapshot(number));
        slowest = slowest.max(begun.elapsed());
        std::thread::sleep(Duration::from_millis(10));
    }
    over.store(true, Ordering::Relaxed);
    for client in clients {
        assert!(client.join().unwrap() > 0, "a client got nothing");
    }
    // Not a measure of speed: a publisher that waited for a stalled client would wait for seconds.
    assert!(slowest < Duration::from_secs(2), "{slowest:?}");
    drop(stalled);
}
