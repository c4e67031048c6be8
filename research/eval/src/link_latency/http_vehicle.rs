//! An emulated vehicle over HTTP: a thread for each connection, as a link has one for each lane.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anyhow::Result;

use super::heard::Heard;

/// Largest body of a request, bytes.
const MAX_BODY: usize = 8192;

/// A request, and when its last byte arrived.
pub(super) struct Request {
    pub(super) method: String,
    pub(super) path: String,
    pub(super) body: Vec<u8>,
    arrived: Instant,
}

/// An answer, and the yaw rate in force where the request was a command to turn.
pub(super) struct Answered {
    pub(super) status: u16,
    pub(super) body: String,
    pub(super) yaw: Option<f64>,
}

/// What answers requests.
pub(super) trait Answers: Send + 'static {
    fn answer(&mut self, request: &Request) -> Answered;
}

/// Starts the vehicle: `host:port`, and the yaw rates of the commands that it hears.
pub(super) fn start(vehicle: impl Answers) -> Result<(String, Receiver<Heard>)> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let address = listener.local_addr()?.to_string();
    let (heard, yaw_rates) = channel();
    let vehicle = Arc::new(Mutex::new(vehicle));
    std::thread::Builder::new().name("vehicle".to_owned()).spawn(move || {
        for client in listener.incoming().flatten() {
            let (vehicle, heard) = (Arc::clone(&vehicle), heard.clone());
            // A connection ends with its client.
            let serve = move || drop(serve(client, &*vehicle, &heard));
            if std::thread::Builder::new().name("connection".to_owned()).spawn(serve).is_err() {
                return;
            }
        }
    })?;
    Ok((address, yaw_rates))
}

/// Answers requests, and tells each yaw rate with the time of its bytes.
fn serve(client: TcpStream, vehicle: &Mutex<impl Answers>, heard: &Sender<Heard>) -> std::io::Result<()> {
    client.set_nodelay(true)?;
    let mut answers = client.try_clone()?;
    let mut requests = BufReader::new(client);
    while let Some(request) = read_request(&mut requests)? {
        let Answered { status, body, yaw } =
            vehicle.lock().unwrap_or_else(PoisonError::into_inner).answer(&request);
        if let Some(yaw) = yaw
            && heard.send((yaw, request.arrived)).is_err()
        {
            return Ok(());
        }
        let head = format!("HTTP/1.1 {status} x\r\ncontent-length: {}\r\n\r\n", body.len());
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
