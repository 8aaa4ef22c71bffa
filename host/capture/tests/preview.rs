//! The preview as friendly, slow and hostile clients meet it.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use tectum_capture::preview::{Fixed, Picture, Preview, Request, Snapshot};
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
        takes_requests: true,
        eyes: [
            Some(("one \"eye\"".to_owned(), Arc::new(Health::default()))),
            None,
        ],
        ..Fixed::default()
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
        "/targets.js",
        "/operator.js",
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
        "/scales.svg?width=300&step=30",
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
    assert_eq!(code("GET / HTTP/1.0\r\n\r\n"), 400);
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

/// Asks with `method` and more lines of the head.
fn ask(address: SocketAddr, method: &str, path: &str, extra: &str) -> (u16, String) {
    let request = format!(
        "{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n{extra}\
         Content-Length: 0\r\n\r\n"
    );
    let (status, body) = split(&exchange(address, request.as_bytes()));
    (status, String::from_utf8(body).unwrap())
}

fn token(preview: &Preview) -> String {
    let notice = preview.notice();
    let start = notice.find("#token=").unwrap() + "#token=".len();
    let rest = &notice[start..];
    rest[..rest.find('\n').unwrap()].to_owned()
}

#[test]
fn at_any_address_foreign_names_are_refused_and_those_that_open_are_told() {
    let any = "0.0.0.0:0".parse().unwrap();
    let preview = Preview::serve(any, Fixed::default()).unwrap();
    let port = preview.address().port();
    let local = SocketAddr::from(([127, 0, 0, 1], port));
    let code = |host: &str| {
        let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        split(&exchange(local, request.as_bytes())).0
    };
    for host in [
        "evil.example",
        "evil.example:8088",
        "localhost.evil.example",
    ] {
        assert_eq!(code(host), 403, "{host}");
    }
    for host in [
        "localhost",
        "127.0.0.1",
        "192.168.1.7:8088",
        "[fd00::1]:8088",
    ] {
        assert_eq!(code(host), 200, "{host}");
    }
    let notice = preview.notice();
    assert!(!notice.contains("0.0.0.0"), "{notice}");
    assert!(notice.contains(&format!("preview: http://127.0.0.1:{port}/")));
    assert!(notice.contains("warning: everyone on the network can watch"));
    // What it prints can be opened.
    for line in notice.lines() {
        let Some(url) = line.strip_prefix("preview: http://") else {
            continue;
        };
        let address = url.trim_end_matches('/').parse().unwrap();
        assert_eq!(get(address, "/").0, 200, "{line}");
    }
    let alone = "127.0.0.1:0".parse().unwrap();
    let notice = Preview::serve(alone, Fixed::default()).unwrap().notice();
    assert!(!notice.contains("warning"), "{notice}");
    assert!(
        !notice.contains("token"),
        "nothing can be changed: {notice}"
    );
}

#[test]
fn changes_need_the_token_and_are_answered_by_the_capturing_thread() {
    let preview = preview();
    let address = preview.address();
    let with_token = format!("X-Tectum-Token: {}\r\n", token(&preview));
    for (extra, wanted) in [
        (String::new(), 403),
        ("X-Tectum-Token: 00\r\n".to_owned(), 403),
        (format!("{with_token}Origin: http://evil.example\r\n"), 403),
    ] {
        for path in ["/snapshot", "/record?on=1", "/mark?name=a", "/lock"] {
            assert_eq!(ask(address, "POST", path, &extra).0, wanted, "{path}");
        }
        let (_, status) = ask(address, "GET", "/status.json", &extra);
        assert!(status.contains("\"may_change\":false"), "{status}");
    }
    assert!(preview.next_request().is_none(), "nothing got through");
    // A request that reads cannot change.
    assert_eq!(ask(address, "GET", "/snapshot", &with_token).0, 405);
    let (_, status) = ask(address, "GET", "/status.json", &with_token);
    assert!(status.contains("\"may_change\":true"), "{status}");
    // Without controls there is nothing to lock.
    assert_eq!(ask(address, "POST", "/lock", &with_token).0, 409);
    assert_eq!(
        ask(address, "POST", "/exposure?value=x", &with_token).0,
        400
    );
    let asking = std::thread::spawn(move || {
        ask(
            address,
            "POST",
            "/mark?name=shark%20%22A%22%0A",
            &with_token,
        )
    });
    let asked = loop {
        match preview.next_request() {
            Some(asked) => break asked,
            None => std::thread::sleep(Duration::from_millis(1)),
        }
    };
    assert_eq!(asked.request, Request::Mark("shark \"A\"".to_owned()));
    asked.answer(Ok("marked".to_owned()));
    assert_eq!(asking.join().unwrap(), (200, "marked".to_owned()));
}

#[test]
fn slow_clients_do_not_keep_others_out() {
    let preview = preview();
    let address = preview.address();
    let stalled: Vec<_> = (0..120)
        .map(|_| {
            let mut stream = TcpStream::connect(address).unwrap();
            stream.write_all(b"GET / HTTP/1.1\r\nHost: loc").unwrap();
            stream.set_nonblocking(true).unwrap();
            stream
        })
        .collect();
    for _ in 0..20 {
        assert_eq!(get(address, "/status.json").0, 200);
    }
    // Others were let in while slow ones still had their time.
    let waiting = |mut stream: &TcpStream| match stream.read(&mut [0; 1]) {
        Err(error) => error.kind() == std::io::ErrorKind::WouldBlock,
        Ok(_) => false,
    };
    assert!(stalled.iter().any(waiting));
}

#[test]
fn a_stall_is_told_and_an_end_is_no_stall() {
    let fixed = Fixed {
        period_ns: Some(1_000_000),
        ..Fixed::default()
    };
    let preview = Preview::serve("127.0.0.1:0".parse().unwrap(), fixed).unwrap();
    let status = || -> serde_json::Value {
        serde_json::from_slice(&get(preview.address(), "/status.json").1).unwrap()
    };
    preview.frame_came();
    let begun = Instant::now();
    while status()["stalled"] == false {
        assert!(begun.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(status()["frame_age_ms"].as_i64().unwrap() > 1000);
    preview.set_status(serde_json::json!({ "ended": true }));
    assert_eq!(status()["stalled"], false);
}
