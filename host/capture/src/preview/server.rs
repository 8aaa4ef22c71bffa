//! Connections: how many, how long, how slow.

use std::convert::Infallible;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio_io_timeout::TimeoutStream;

use super::Shared;
use super::pages::respond;
use super::places::{Place, Places};

/// A request's head must be there within this, also the next one of a kept connection.
const HEAD_TIME: Duration = Duration::from_secs(10);
/// A client that takes nothing for this long is cut off.
const STALL_TIME: Duration = Duration::from_secs(5);
/// Every connection ends after this; browsers open another.
const LIFE_TIME: Duration = Duration::from_secs(120);
/// Longest head of a request, bytes: hyper's least.
const HEAD_BYTES: usize = 8192;

/// Begins to serve on a thread of its own; the address in use.
pub(super) fn start(address: SocketAddr, shared: Arc<Shared>) -> io::Result<SocketAddr> {
    let listener = TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        // Encoding must leave processors to capture and stitching.
        .max_blocking_threads(1)
        .enable_all()
        .build()?;
    std::thread::Builder::new()
        .name("preview".to_owned())
        .spawn(move || runtime.block_on(accept(listener, shared)))?;
    Ok(address)
}

async fn accept(listener: TcpListener, shared: Arc<Shared>) {
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else {
        return;
    };
    let places = Arc::new(Places::default());
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => {
                let place = Places::take(&places, peer.ip());
                let key = place.key();
                let task = tokio::spawn(serve(stream, shared.clone(), place));
                places.set_task(key, task.abort_handle());
            }
            // Out of file descriptors, or a client that went away: others may go on.
            Err(_) => tokio::time::sleep(Duration::from_millis(50)).await,
        }
    }
}

async fn serve(stream: TcpStream, shared: Arc<Shared>, place: Place) {
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(STALL_TIME));
    let answer = service_fn(|request| {
        place.asked();
        let shared = shared.clone();
        async move { Ok::<_, Infallible>(respond(&request, &shared).await) }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIME)
        .max_buf_size(HEAD_BYTES)
        .serve_connection(TokioIo::new(Box::pin(stream)), answer);
    // Whatever ends it, nobody is left to be told.
    let _ = tokio::time::timeout(LIFE_TIME, connection).await;
}
