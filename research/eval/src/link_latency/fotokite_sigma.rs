//! The emulated Fotokite Sigma, over HTTP: a thread for each connection, as a link has one for each lane.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_wire::fotokite_sigma::Sigma;
use barrelman_wire::fotokite_sigma::sigma::{Incoming, SigmaSettings, View};

use super::heard::Heard;

/// The token that the vehicle accepts.
pub(super) const TOKEN: &str = "token";
/// Largest body of a request, bytes.
const MAX_BODY: usize = 4096;

/// Starts the vehicle: its address, and what it hears.
pub(super) fn start(clock: Clock) -> Result<(String, Receiver<Heard>)> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let address = format!("http://{}", listener.local_addr()?);
    let (heard, yaw_rates) = channel();
    let sigma = Arc::new(Mutex::new(Sigma::new(SigmaSettings::example())));
    std::thread::Builder::new().name("sigma".to_owned()).spawn(move || {
        for client in listener.incoming().flatten() {
            let (sigma, heard) = (Arc::clone(&sigma), heard.clone());
            // A connection ends with its client.
            let serve = move || drop(serve(client, clock, &sigma, &heard));
            if std::thread::Builder::new().name("connection".to_owned()).spawn(serve).is_err() {
                return;
            }
        }
    })?;
    Ok((address, yaw_rates))
}

/// A request, and when its last byte arrived.
struct Request {
    method: String,
    path: String,
    body: Vec<u8>,
    arrived: Instant,
}

/// Answers requests, and tells each yaw rate with the time of its bytes.
fn serve(
    client: TcpStream,
    clock: Clock,
    sigma: &Mutex<Sigma>,
    heard: &Sender<Heard>,
) -> std::io::Result<()> {
    client.set_nodelay(true)?;
    let mut answers = client.try_clone()?;
    let mut requests = BufReader::new(client);
    while let Some(request) = read_request(&mut requests)? {
        let mut vehicle = sigma.lock().unwrap_or_else(PoisonError::into_inner);
        let asked = Incoming {
            method: &request.method,
            path: &request.path,
            token: Some(TOKEN),
            body: &request.body,
        };
        let answer = vehicle.answer(asked, View::default(), clock.now());
        let yaw = vehicle.rates(clock.now()).yaw.radians_per_second();
        drop(vehicle);
        if request.path.ends_with("rotate_with_speed") && heard.send((yaw, request.arrived)).is_err() {
            return Ok(());
        }
        let (status, body) = (answer.status, answer.body);
        let length = body.len();
        let head = format!(
            "HTTP/1.1 {status} x\r\ncontent-type: application/json\r\ncontent-length: {length}\r\n\r\n"
        );
        answers.write_all((head + &body).as_bytes())?;
    }
    Ok(())
}

/// The next request; `None`: the client has closed the connection.
fn read_request(requests: &mut BufReader<TcpStream>) -> std::io::Result<Option<Request>> {
    let mut line = String::new();
    if requests.read_line(&mut line)? == 0 {
        return Ok(None);
    }
    let mut words = line.split_whitespace();
    let (method, path) =
        (words.next().unwrap_or_default().to_owned(), words.next().unwrap_or_default().to_owned());
    let mut length = 0;
    loop {
        let mut header = String::new();
        requests.read_line(&mut header)?;
        let Some((name, value)) = header.trim().split_once(':') else { break };
        if name.eq_ignore_ascii_case("content-length") {
            length = value.trim().parse().unwrap_or(0).min(MAX_BODY);
        }
    }
    let mut body = vec![0; length];
    requests.read_exact(&mut body)?;
    Ok(Some(Request { method, path, body, arrived: Instant::now() }))
}
