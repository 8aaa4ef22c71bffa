//! What is served: the page, pictures, status and directions to everyone; changes to who has the
//! token.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::{Method, Request as HttpRequest, Response, StatusCode};

use super::picture::Quality;
use super::requests::{Outcome, Request, clean_name};
use super::{Picture, Shared, Snapshot};
use crate::monotonic_ns;

/// Two overlapping eyes.
const ICON: &str = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 16 16'>\
                    <circle cx='6' cy='8' r='5' fill='#56b4e9'/>\
                    <circle cx='10' cy='8' r='5' fill='#e69f00' fill-opacity='.8'/></svg>";
/// The page's own files: path, type, text.
const FILES: [(&str, &str, &str); 6] = [
    ("/", "text/html; charset=utf-8", include_str!("page.html")),
    (
        "/page.css",
        "text/css; charset=utf-8",
        include_str!("page.css"),
    ),
    ("/page.js", SCRIPT, include_str!("page.js")),
    ("/targets.js", SCRIPT, include_str!("targets.js")),
    ("/operator.js", SCRIPT, include_str!("operator.js")),
    ("/icon.svg", "image/svg+xml", ICON),
];
const SCRIPT: &str = "text/javascript; charset=utf-8";
/// Paths that change something.
const CHANGES: [&str; 5] = ["/snapshot", "/record", "/mark", "/exposure", "/lock"];
/// A picture that does not come within this is not sent; the client asks again.
const WAIT: Duration = Duration::from_secs(2);
/// Widths that scales are drawn for, px.
const SCALES_WIDTH_PX: std::ops::RangeInclusive<u16> = 160..=4096;
/// Nothing but the page's own files runs, and nothing else may show it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
                      img-src 'self' blob:; connect-src 'self'; frame-ancestors 'none'; \
                      base-uri 'none'; form-action 'none'";

type Answer = Response<Full<Bytes>>;
type Query = [(String, String)];

/// Answers one request.
pub(super) async fn respond(request: &HttpRequest<Incoming>, shared: &Arc<Shared>) -> Answer {
    let headers = request.headers();
    if let Err(status) = shared.access.check_name(request.uri(), headers) {
        let reason = "ask for this page by the address that was printed when it was started";
        return refuse(status, reason);
    }
    let path = request.uri().path();
    let query = pairs(request.uri().query().unwrap_or_default());
    let changes = CHANGES.contains(&path);
    let allowed: &[Method] = if changes {
        &[Method::POST]
    } else {
        &[Method::GET, Method::HEAD]
    };
    if !allowed.contains(request.method()) {
        let reason = "this address is asked for in another way";
        let mut answer = refuse(StatusCode::METHOD_NOT_ALLOWED, reason);
        let allowed = HeaderValue::from_static(if changes { "POST" } else { "GET, HEAD" });
        answer.headers_mut().insert(header::ALLOW, allowed);
        return answer;
    }
    let may_change = shared.access.may_change(headers);
    if changes && !may_change {
        let reason = "this page can only be read: open the address with its token, as printed when \
                      it was started";
        return refuse(StatusCode::FORBIDDEN, reason);
    }
    if let Some((_, kind, content)) = FILES.iter().find(|(name, ..)| *name == path) {
        return text(kind, (*content).into());
    }
    match path {
        "/status.json" => text("application/json", shared.status(may_change).into()),
        "/scales.svg" => scales(shared, &query).await,
        "/direction.json" => direction(shared, &query),
        "/stitched.jpg" => picture(shared, &query, |s| s.stitched.as_ref()).await,
        "/left.jpg" => picture(shared, &query, |s| s.left.as_ref()).await,
        "/right.jpg" => picture(shared, &query, |s| s.right.as_ref()).await,
        "/snapshot" => ask(shared, Request::Snapshot).await,
        "/record" => ask(shared, Request::Record(value(&query, "on") == Some("1"))).await,
        "/mark" => {
            let name = clean_name(value(&query, "name").unwrap_or_default());
            ask(shared, Request::Mark(name)).await
        }
        "/exposure" => match value(&query, "value").and_then(|text| text.parse().ok()) {
            Some(exposure) => control(shared, move |c| c.set_exposure(exposure)).await,
            None => refuse(
                StatusCode::BAD_REQUEST,
                "needed is an exposure time, in 0.1 ms",
            ),
        },
        "/lock" => control(shared, |controls| controls.lock()).await,
        _ => refuse(StatusCode::NOT_FOUND, "there is no such page"),
    }
}

async fn ask(shared: &Shared, request: Request) -> Answer {
    if !shared.fixed.takes_requests {
        return refuse(
            StatusCode::NOT_FOUND,
            "this program records nothing by request",
        );
    }
    told(shared.requests.ask(request).await)
}

/// Cameras may take their time: not on the thread that serves.
async fn control(
    shared: &Arc<Shared>,
    change: impl FnOnce(&dyn super::Controls) -> Outcome + Send + 'static,
) -> Answer {
    let of_thread = shared.clone();
    let done = tokio::task::spawn_blocking(move || {
        let controls = of_thread.fixed.controls.as_deref();
        controls.map_or_else(|| Err("these sources have no controls".to_owned()), change)
    });
    let outcome = done.await.unwrap_or_else(|error| Err(error.to_string()));
    let Ok(words) = &outcome else {
        return told(outcome);
    };
    if !shared.fixed.takes_requests {
        return told(outcome);
    }
    let note = Request::NoteControls(words.clone());
    let noted = shared.requests.ask(note).await;
    told(noted.map_err(|reason| format!("{words}, but this is not noted: {reason}")))
}

fn told(outcome: Outcome) -> Answer {
    match outcome {
        Ok(done) => text("text/plain; charset=utf-8", done.into()),
        Err(reason) => refuse(StatusCode::CONFLICT, &reason),
    }
}

/// `a=1&b=two%20words`.
fn pairs(query: &str) -> Vec<(String, String)> {
    let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    pairs.map(|(k, v)| (decoded(k), decoded(v))).collect()
}

/// Text in which `%41` stands for a byte.
fn decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        let hex = after.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) if *first == b'%' => {
                bytes.push(byte);
                rest = &after[2..];
            }
            _ => {
                bytes.push(*first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn value<'a>(query: &'a Query, name: &str) -> Option<&'a str> {
    let pair = query.iter().find(|(key, _)| key == name);
    pair.map(|(_, value)| &**value)
}

fn direction(shared: &Shared, query: &Query) -> Answer {
    let Some(answer) = &shared.fixed.direction else {
        return refuse(StatusCode::NOT_FOUND, "there is no table, so no directions");
    };
    match answer(query) {
        Ok(json) => text("application/json", json.into()),
        Err(reason) => refuse(StatusCode::BAD_REQUEST, &reason),
    }
}

/// Scales for a picture that is shown `width` px wide, every `step` degrees.
async fn scales(shared: &Arc<Shared>, query: &Query) -> Answer {
    let width_px = value(query, "width").and_then(|text| text.parse::<u16>().ok());
    let step_deg = value(query, "step").and_then(|text| text.parse::<f64>().ok());
    let (Some(width_px), Some(step_deg)) = (width_px, step_deg) else {
        return refuse(StatusCode::BAD_REQUEST, "needed are width=PX and step=DEG");
    };
    let width_px = width_px.clamp(*SCALES_WIDTH_PX.start(), *SCALES_WIDTH_PX.end());
    let shared = shared.clone();
    let drawn = tokio::task::spawn_blocking(move || {
        let draw = shared.fixed.scales.as_ref();
        draw.map(|draw| draw(width_px, step_deg))
    });
    match drawn.await {
        Ok(Some(Ok(svg))) => text("image/svg+xml", svg.into()),
        Ok(Some(Err(reason))) => refuse(StatusCode::BAD_REQUEST, &reason),
        _ => refuse(StatusCode::NOT_FOUND, "there is no table, so no scales"),
    }
}

/// The newest picture, once it is another than the one the client has.
async fn picture(
    shared: &Arc<Shared>,
    query: &Query,
    pick: fn(&Snapshot) -> Option<&Picture>,
) -> Answer {
    shared.asked_ns.store(monotonic_ns(), Ordering::Relaxed);
    let has: Option<u64> = value(query, "after").and_then(|number| number.parse().ok());
    let quality = Quality::named(value(query, "quality").unwrap_or_default());
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
        let picture = pick(&snapshot)?;
        Some((picture.jpeg(quality)?, picture.size_px()))
    });
    match jpeg.await {
        Ok(Some((jpeg, [width, height]))) => {
            let mut answer = text("image/jpeg", jpeg);
            let headers = answer.headers_mut();
            headers.insert("x-number", HeaderValue::from(number));
            headers.insert("x-width", HeaderValue::from(width));
            headers.insert("x-height", HeaderValue::from(height));
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
    fn escapes_are_read_and_broken_ones_left_as_they_are() {
        assert_eq!(decoded("two%20words%2F%C3%A9"), "two words/é");
        assert_eq!(decoded("100%"), "100%");
        assert_eq!(decoded("%4"), "%4");
        assert_eq!(decoded("%zz+%"), "%zz+%");
        assert_eq!(decoded("%ff"), "\u{fffd}");
        let query = pairs("a=1&b=x%26y=z&c");
        assert_eq!(value(&query, "b"), Some("x&y=z"));
        assert_eq!(value(&query, "c"), None);
    }
}
