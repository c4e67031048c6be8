//! A new drive in a run with a simulated world: another world takes the place of the running one.
//!
//! Program, pilot, link and recording go on. All that the pilot forgets, it forgets by requests, so that a
//! replay of the recording forgets the same.

use barrelman_console_server::operator::Answer;
use barrelman_console_server::snapshot::WorldState;
use barrelman_pilot::Input;
use barrelman_vocab::{CameraRequest, NewDrive, OperatorRequest, StopCause, VesselRequest, WorldRequest};

use super::run_loop::{LoopState, RunLoop};

impl RunLoop<'_> {
    /// The answer to a request about the simulated world.
    pub(super) fn world_answer(&mut self, state: &mut LoopState, request: &WorldRequest) -> Answer {
        let reason = match request {
            WorldRequest::NewDrive(wanted) => match self.begin_new_drive(state, wanted) {
                Ok(()) => return Answer::ACCEPTED,
                Err(reason) => reason,
            },
            WorldRequest::Drill(_) => {
                "a run has no drills: begin them with `barrelman demo --drill`, or on the demo's page"
                    .to_owned()
            }
            WorldRequest::Pause | WorldRequest::Resume => {
                "the time of a run cannot be paused: only the world of `barrelman demo` can".to_owned()
            }
        };
        Answer::Refused(reason)
    }

    /// Stops camera and boat, forgets target and marks, and lets another world begin.
    ///
    /// # Errors
    /// Why there is no other world.
    fn begin_new_drive(&mut self, state: &mut LoopState, wanted: &NewDrive) -> Result<(), String> {
        let Some(worlds) = self.worlds.clone() else {
            return Err("the world is not simulated: a new drive begins in `barrelman demo`, or in \
                        `barrelman run --video sim:SCENARIO`"
                .to_owned());
        };
        let world = worlds.load(wanted).map_err(|error| format!("{error:#}"))?;
        let camera = [OperatorRequest::Stop(StopCause::Operator), CameraRequest::Deselect.into()];
        let vessel = [VesselRequest::UnmarkAll.into(), VesselRequest::ReleaseVessel.into()];
        for request in camera {
            self.step(state, Input::Request(request));
        }
        let has_boat = self.boat.is_some();
        for request in vessel.into_iter().filter(|_| has_boat) {
            self.step(state, Input::Request(request));
        }
        worlds.begin(world);
        let NewDrive { scenario, seed } = wanted.clone();
        tracing::info!("new drive: {scenario}, seed {seed}");
        self.publisher.begin_world(WorldState { scenario, seed, boat: None }, self.events.now());
        Ok(())
    }
}
