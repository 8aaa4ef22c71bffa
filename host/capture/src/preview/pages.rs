//! What is served: the page, pictures, status and directions, to `GET` and `HEAD` alone.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};

use super::{Picture, Shared, Snapshot};
use crate::monotonic_ns;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// Two overlapping eyes.
const ICON: &str = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 16 16'>\
                    <circle cx='6' cy='8' r='5' fill='#56b4e9'/>\
                    <circle cx='10' cy='8' r='5' fill='#e69f00' fill-opacity='.8'/></svg>";
const SCRIPT: &str = include_str!("page.js");
/// A picture that does not come within this is none; the client asks again.
const WAIT: Duration = Duration::from_secs(2);
/// Nothing but the page's own files runs, and nothing else may show it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
                      img-src 'self' blob:; connect-src 'self'; frame-ancestors 'none'; \
                      base-uri 'none'; form-action 'none'";

type Answer = Response<Full<Bytes>>;

/// Answers one request.
pub(super) async fn respond(request: &Request<Incoming>, shared: &Arc<Shared>) -> Answer {
    if !matches!(*request.method(), Method::GET | Method::HEAD) {
        let mut answer = refuse(StatusCode::METHOD_NOT_ALLOWED, "this page can only be read");
        let allowed = HeaderValue::from_static("GET, HEAD");
        answer.headers_mut().insert(header::ALLOW, allowed);
        return answer;
    }
    if shared.is_loopback && !is_loopback(request.headers().get(header::HOST)) {
        // Another site's name that leads here must not be able to read the cameras.
        return refuse(StatusCode::FORBIDDEN, "ask for this page by localhost");
    }
    let query = pairs(request.uri().query().unwrap_or_default());
    match request.uri().path() {
        "/" => text("text/html; charset=utf-8", PAGE.into()),
        "/page.css" => text("text/css; charset=utf-8", STYLE.into()),
        "/page.js" => text("text/javascript; charset=utf-8", SCRIPT.into()),
        "/icon.svg" => text("image/svg+xml", ICON.into()),
        "/status.json" => text("application/json", shared.status().into()),
        "/scales.png" => match &shared.fixed.scales_png {
            Some(png) => text("image/png", png.clone().into()),
            None => refuse(StatusCode::NOT_FOUND, "there is no table, so no scales"),
        },
        "/direction.json" => direction(shared, &query),
        "/stitched.jpg" => picture(shared, &query, |s| s.stitched.as_ref()).await,
        "/left.jpg" => picture(shared, &query, |s| s.left.as_ref()).await,
        "/right.jpg" => picture(shared, &query, |s| s.right.as_ref()).await,
        _ => refuse(StatusCode::NOT_FOUND, "there is no such page"),
    }
}

/// Whether a request was meant for this machine by one of its loopback names.
fn is_loopback(host: Option<&HeaderValue>) -> bool {
    let Some(host) = host.and_then(|host| host.to_str().ok()) else {
        return false;
    };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
        _ => host,
    };
    let literal = name.trim_matches(['[', ']']);
    let is_literal = literal.parse::<std::net::IpAddr>();
    name.eq_ignore_ascii_case("localhost") || is_literal.is_ok_and(|ip| ip.is_loopback())
}

/// `a=1&b=2`; the values that belong here need no escapes.
fn pairs(query: &str) -> Vec<(String, String)> {
    let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).collect()
}

fn direction(shared: &Shared, query: &[(String, String)]) -> Answer {
    let Some(answer) = &shared.fixed.direction else {
        return refuse(StatusCode::NOT_FOUND, "there is no table, so no directions");
    };
    match answer(query) {
        Ok(json) => text("application/json", json.into()),
        Err(reason) => refuse(StatusCode::BAD_REQUEST, &reason),
    }
}

/// The newest picture, once it is another than the one the client has.
async fn picture(
    shared: &Arc<Shared>,
    query: &[(String, String)],
    pick: fn(&Snapshot) -> Option<&Picture>,
) -> Answer {
    shared.asked_ns.store(monotonic_ns(), Ordering::Relaxed);
    let has = query.iter().find(|(key, _)| key == "after");
    let has: Option<u64> = has.and_then(|(_, number)| number.parse().ok());
    let mut newest = shared.newest.subscribe();
    let is_new =
        |snapshot: &Option<Arc<Snapshot>>| snapshot.as_ref().is_some_and(|s| Some(s.number) != has);
    let found = match tokio::time::timeout(WAIT, newest.wait_for(is_new)).await {
        Ok(Ok(snapshot)) => snapshot.clone(),
        _ => None,
    };
    let Some(snapshot) = found else {
        return empty(StatusCode::NO_CONTENT);
    };
    let number = snapshot.number;
    let jpeg = tokio::task::spawn_blocking(move || {
        let jpeg = pick(&snapshot).and_then(Picture::jpeg);
        jpeg.map(<[u8]>::to_vec)
    });
    match jpeg.await {
        Ok(Some(jpeg)) => {
            let mut answer = text("image/jpeg", jpeg.into());
            let number = HeaderValue::from(number);
            answer.headers_mut().insert("x-number", number);
            answer
        }
        _ => refuse(StatusCode::NOT_FOUND, "there is no such picture"),
    }
}

fn text(kind: &'static str, body: Bytes) -> Answer {
    let mut answer = Response::new(Full::new(body));
    let headers = answer.headers_mut();
    for (name, value) in [
        (header::CONTENT_TYPE, kind),
        (header::CACHE_CONTROL, "no-store"),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.insert(
        "cross-origin-resource-policy",
        HeaderValue::from_static("same-origin"),
    );
    answer
}

fn empty(status: StatusCode) -> Answer {
    let mut answer = text("text/plain; charset=utf-8", Bytes::new());
    *answer.status_mut() = status;
    answer
}

fn refuse(status: StatusCode, reason: &str) -> Answer {
    let mut answer = text(
        "text/plain; charset=utf-8",
        format!("{reason}\n").into_bytes().into(),
    );
    *answer.status_mut() = status;
    answer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_loopback_names_are_loopback() {
        let is = |host: &'static str| is_loopback(Some(&HeaderValue::from_static(host)));
        for host in [
            "localhost",
            "LOCALHOST:8080",
            "127.0.0.1:1",
            "[::1]:80",
            "127.9.9.9",
        ] {
            assert!(is(host), "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example:80",
            "192.168.0.2",
            "",
            "127.0.0.1.evil",
        ] {
            assert!(!is(host), "{host}");
        }
        assert!(!is_loopback(None));
    }
}
