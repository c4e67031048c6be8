//! Who controls: one page at a time; the others watch.
//!
//! A page that may control takes the empty seat when it connects. Otherwise control is taken or given by an
//! explicit request. The seat of a page that was lost is kept for [`GRACE`], so that a reload keeps the
//! control. A page that sends nothing for [`MAX_SILENCE`] counts as lost.
//!
//! Programs without a socket are one client together. They join by asking for the control or taking it, and
//! are gone after [`MAX_SILENCE`] without a request.

use std::time::Duration;

use barrelman_vocab::Timestamp;

use super::access::Role;
use super::api::ControlSeat;

/// How long the seat of a lost page is kept.
pub(super) const GRACE: Duration = Duration::from_secs(2);

/// How long the page in control may be silent. A page sends something five times a second.
pub(super) const MAX_SILENCE: Duration = Duration::from_secs(3);

/// How long the page in control may be gone or silent before the boat is stopped. With the turn of the run
/// loop, the boat is neutral after a second.
pub(super) const BOAT_SILENCE: Duration = Duration::from_millis(900);

/// The largest number of pages at a time.
pub(super) const MAX_CLIENTS: usize = 16;

/// Number of a page.
pub(super) type ClientId = u64;

/// The name of the programs without a socket. No page has it: a page's own name has hexadecimal digits alone.
const PROGRAMS: &str = "programs";

#[derive(Debug, Clone)]
struct Client {
    id: ClientId,
    /// The page's own name, which a reload keeps.
    name: String,
    role: Role,
    /// When the page last sent anything.
    heard: Timestamp,
    asks: bool,
}

impl Client {
    fn is_program(&self) -> bool {
        self.name == PROGRAMS
    }
}

/// The page in control.
#[derive(Debug, Clone)]
struct Holder {
    name: String,
    id: ClientId,
    /// When the page was lost; `None` while it is connected.
    lost: Option<Lost>,
}

/// The loss of the page in control.
#[derive(Debug, Clone, Copy)]
struct Lost {
    at: Timestamp,
    /// When the page had last sent anything: a page that hangs may be lost much later.
    heard: Timestamp,
}

/// The connected pages, and the one in control.
#[derive(Debug, Default)]
pub(super) struct Seats {
    clients: Vec<Client>,
    holder: Option<Holder>,
    next_id: ClientId,
}

/// What a change of the seats means for the rest of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Joined {
    /// The page's number.
    pub(super) id: ClientId,
    /// The page that has to go, as there are too many.
    pub(super) dropped: Option<ClientId>,
}

impl Seats {
    /// A page connects. With too many pages, the one goes that was silent longest, one that may only watch
    /// before the others.
    pub(super) fn join(&mut self, name: &str, role: Role, now: Timestamp) -> Joined {
        let id = self.next_id;
        self.next_id += 1;
        let pages = self.clients.iter().filter(|client| !client.is_program()).count();
        let dropped = (pages >= MAX_CLIENTS).then(|| self.idlest()).flatten();
        self.clients.retain(|client| Some(client.id) != dropped);
        // A page without a name of its own is another one each time.
        let name = if name.is_empty() { format!("page {id}") } else { name.to_owned() };
        self.clients.push(Client { id, name: name.clone(), role, heard: now, asks: false });
        match &mut self.holder {
            Some(holder) if holder.name == name && role == Role::Control => {
                (holder.id, holder.lost) = (id, None);
            }
            None if role == Role::Control => self.seat(id),
            _ => {}
        }
        Joined { id, dropped }
    }

    /// The number of the programs without a socket, which join where they have not.
    pub(super) fn join_program(&mut self, now: Timestamp) -> ClientId {
        self.hear_program(now);
        self.program().unwrap_or_else(|| {
            let id = self.next_id;
            self.next_id += 1;
            let (name, role) = (PROGRAMS.to_owned(), Role::Control);
            self.clients.push(Client { id, name, role, heard: now, asks: false });
            id
        })
    }

    /// The number of the programs without a socket; `None`: none has joined.
    pub(super) fn program(&self) -> Option<ClientId> {
        self.clients.iter().find(|client| client.is_program()).map(|client| client.id)
    }

    /// A program without a socket made a request.
    pub(super) fn hear_program(&mut self, now: Timestamp) {
        if let Some(id) = self.program() {
            self.hear(id, now);
        }
    }

    /// Whether programs without a socket are in control.
    pub(super) fn program_controls(&self) -> bool {
        self.program().is_some_and(|id| self.controls(id))
    }

    /// A page is gone.
    pub(super) fn leave(&mut self, id: ClientId, now: Timestamp) {
        let heard = self.client(id).map_or(now, |client| client.heard);
        self.clients.retain(|client| client.id != id);
        if let Some(holder) = self.holder.as_mut().filter(|holder| holder.id == id) {
            holder.lost = Some(Lost { at: now, heard });
        }
    }

    /// A page sent something.
    pub(super) fn hear(&mut self, id: ClientId, now: Timestamp) {
        if let Some(client) = self.client(id) {
            client.heard = now;
        }
    }

    /// Frees the seat of a page that was lost for longer than [`GRACE`], or silent for longer than
    /// [`MAX_SILENCE`]. A page that asks for the control gets it. Returns whether the seat was freed now.
    pub(super) fn expire(&mut self, now: Timestamp) -> bool {
        self.clients.retain(|client| !client.is_program() || now.since(client.heard) <= MAX_SILENCE);
        let Some(holder) = &self.holder else { return false };
        let is_over = match holder.lost {
            Some(lost) => now.since(lost.at) > GRACE,
            None => {
                let client = self.clients.iter().find(|client| client.id == holder.id);
                client.is_none_or(|client| now.since(client.heard) > MAX_SILENCE)
            }
        };
        if is_over {
            self.free();
        }
        is_over
    }

    /// Frees the seat. A client that asks for the control gets it.
    fn free(&mut self) {
        self.holder = None;
        let asking = self.clients.iter().find(|client| client.asks).map(|client| client.id);
        asking.into_iter().for_each(|id| self.seat(id));
    }

    /// Until when the page in control watches over the boat: for [`BOAT_SILENCE`] since it was heard. `None`:
    /// no page is in control.
    pub(super) fn vessel_watched_until(&self) -> Option<Timestamp> {
        let holder = self.holder.as_ref().filter(|_| !self.program_controls())?;
        let heard = match holder.lost {
            Some(lost) => lost.heard,
            None => self.clients.iter().find(|client| client.id == holder.id)?.heard,
        };
        Some(heard.plus(BOAT_SILENCE))
    }

    /// Whether a page is in control.
    pub(super) fn controls(&self, id: ClientId) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.id == id && holder.lost.is_none())
    }

    /// Whether nobody is in control.
    pub(super) const fn is_empty(&self) -> bool {
        self.holder.is_none()
    }

    /// A page takes the control.
    ///
    /// # Errors
    /// The reason, in words, if the page may only watch.
    pub(super) fn take(&mut self, id: ClientId) -> Result<(), &'static str> {
        self.permitted(id)?;
        self.seat(id);
        Ok(())
    }

    /// A page asks for the control. It gets an empty seat at once.
    ///
    /// # Errors
    /// The reason, in words, if the page may only watch.
    pub(super) fn ask(&mut self, id: ClientId) -> Result<(), &'static str> {
        self.permitted(id)?;
        if self.holder.is_none() {
            self.seat(id);
        } else if !self.controls(id)
            && let Some(client) = self.client(id)
        {
            client.asks = true;
        }
        Ok(())
    }

    /// The page in control gives the control to another page.
    ///
    /// # Errors
    /// The reason, in words.
    pub(super) fn give(&mut self, from: ClientId, to: ClientId) -> Result<(), &'static str> {
        if !self.controls(from) {
            return Err("only the page in control can give the control");
        }
        if self.clients.iter().all(|client| client.id != to) {
            return Err("that page is not connected");
        }
        self.permitted(to).map_err(|_| "that page may only watch")?;
        // The page that watched over the boat was heard a moment ago. A program that only looked on may have
        // been silent for longer.
        let heard = self.client(from).map(|client| client.heard);
        self.seat(to);
        if let (Some(client), Some(heard)) = (self.client(to), heard) {
            client.heard = client.heard.max(heard);
        }
        Ok(())
    }

    /// The client in control gives the control up.
    ///
    /// # Errors
    /// The reason, in words.
    pub(super) fn release(&mut self, id: ClientId) -> Result<(), &'static str> {
        if !self.controls(id) {
            return Err("only who is in control can give the control up");
        }
        self.free();
        Ok(())
    }

    /// The state for the pages.
    pub(super) fn state(&self) -> ControlSeat {
        ControlSeat {
            holder: self.holder.as_ref().map(|holder| holder.id),
            holder_connected: self.holder.as_ref().is_some_and(|holder| holder.lost.is_none()),
            clients: self.clients.iter().map(|client| client.id).collect(),
            asking: self.clients.iter().filter(|client| client.asks).map(|client| client.id).collect(),
            program: self.program(),
        }
    }

    fn permitted(&self, id: ClientId) -> Result<(), &'static str> {
        match self.clients.iter().find(|client| client.id == id) {
            Some(client) if client.role == Role::Control => Ok(()),
            _ => Err("this page may only watch: open the control link"),
        }
    }

    fn seat(&mut self, id: ClientId) {
        if let Some(client) = self.client(id) {
            client.asks = false;
            let name = client.name.clone();
            self.holder = Some(Holder { name, id, lost: None });
        }
    }

    fn client(&mut self, id: ClientId) -> Option<&mut Client> {
        self.clients.iter_mut().find(|client| client.id == id)
    }

    /// The page that was silent longest: of those that may only watch, then of the others, the page in
    /// control last.
    fn idlest(&self) -> Option<ClientId> {
        let pages = self.clients.iter().filter(|client| !client.is_program());
        let idlest = pages.min_by_key(|client| (self.controls(client.id), client.role, client.heard));
        idlest.map(|client| client.id)
    }
}

#[cfg(test)]
mod tests;
