//! Watches a drill, and says how it was done.

use anyhow::Result;
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::random::{CounterRng, Stream};
use barrelman_sim::snapshot::{ObjectKind, SceneObject};
use barrelman_vocab::{DrillName, OperatorRequest, WaterPoint};

use super::figures::DrillFigures;
use super::plan::DrillPlan;
use super::{DrillResult, DrillState, reference};
use crate::drive::{Drive, DriveSetup};
use crate::law_choice::LawChoice;

/// A track is that of the boat from this overlap of the boxes on.
const MIN_IOU: f64 = 0.3;
/// The boat has reached a person within this distance, metres,
const REACHED_M: f64 = 4.0;
/// and is too close within this one.
const TOO_CLOSE_M: f64 = 2.0;
/// Share of the time in which the boat has to be in the picture.
const MIN_IN_PICTURE: f64 = 0.9;
/// When the alarm is raised, seconds after the begin.
const ALARM_S: (f64, f64) = (10.0, 25.0);
/// The number of the alarm's draw in the operator's stream, behind those of the selections and marks.
const ALARM_DRAW: u64 = 1_000_000;
/// How long a Stop is waited for after the alarm, seconds.
const STOP_AWAITED_S: f64 = 10.0;
/// The boat leaves the picture within this time, seconds.
const LEAVES_WITHIN_S: f64 = 60.0;

/// The judge of one drill.
#[derive(Debug)]
pub struct DrillJudge {
    name: DrillName,
    seed: u64,
    plan: DrillPlan,
    /// When the drill began, seconds of the world's time; `None` before.
    begun_s: Option<f64>,
    /// Time since the begin, seconds.
    now_s: f64,
    /// When the alarm is raised, seconds since the begin.
    alarm_s: f64,
    /// When the task was done, seconds since the begin.
    done_s: Option<f64>,
    was_engaged: bool,
    /// Distance to the nearest person so far, metres.
    closest_m: f64,
    people: Vec<SceneObject>,
    /// The commands of the helm so far, each with its first tick.
    helm: Vec<(u64, Option<HelmCommand>)>,
}

impl DrillJudge {
    /// The judge of a drill that has not begun.
    pub fn new(name: DrillName, seed: u64) -> Self {
        Self {
            name,
            seed,
            plan: DrillPlan::of(name),
            begun_s: None,
            now_s: 0.0,
            alarm_s: CounterRng::new(seed, Stream::Operator).between(ALARM_DRAW, ALARM_S),
            done_s: None,
            was_engaged: false,
            closest_m: f64::INFINITY,
            people: Vec::new(),
            helm: vec![(0, None)],
        }
    }

    /// Whether the drill has begun: where a boat is to be found, it has to be out of the picture first.
    pub const fn has_begun(&self) -> bool {
        self.begun_s.is_some()
    }

    /// The operator made a request.
    pub const fn on_request(&mut self, request: &OperatorRequest) {
        let is_stop = matches!(request, OperatorRequest::Stop(_));
        if is_stop && matches!(self.name, DrillName::StopOnAlarm) && self.done_s.is_none() {
            self.done_s = Some(self.now_s);
        }
    }

    /// The drive made a tick.
    pub fn after_tick(&mut self, drive: &Drive<'_>) {
        let (world, helm) = (drive.world(), drive.helm());
        if self.helm.last().is_none_or(|(_, last)| *last != helm) {
            self.helm.push((world.tick(), helm));
        }
        let world_s = world.now().as_secs_f64();
        let Some(begun_s) = self.begun_s else {
            let waits = self.name == DrillName::FindTheBoat
                && world_s < LEAVES_WITHIN_S
                && drive.log().truth.iter().flatten().next_back().is_none_or(|row| !row.out_of_picture);
            self.begun_s = (!waits).then_some(world_s);
            return;
        };
        self.now_s = world_s - begun_s;
        self.was_engaged |= drive.outcome().is_some_and(|outcome| outcome.mode.is_engaged());
        match self.name {
            DrillName::KeepInView | DrillName::StopOnAlarm => {}
            DrillName::SelectInGlare | DrillName::FindTheBoat => {
                if self.done_s.is_none() && is_followed(drive) {
                    self.done_s = Some(self.now_s);
                }
            }
            DrillName::ReachAPerson => self.measure_distance(drive),
        }
    }

    fn measure_distance(&mut self, drive: &Drive<'_>) {
        let boat = drive.world().target_pose().position;
        drive.world().write_objects(&mut self.people);
        let on_water = |x, y| WaterPoint { x, y };
        for person in self.people.iter().filter(|object| object.kind == ObjectKind::Swimmer) {
            let at = person.pose.position;
            self.closest_m = self.closest_m.min(on_water(boat.x, boat.y).distance_to(on_water(at.x, at.y)));
        }
        if self.done_s.is_none() && self.closest_m <= REACHED_M {
            self.done_s = Some(self.now_s);
        }
    }

    /// When the drill ends, seconds since the begin.
    fn ends_s(&self) -> f64 {
        match (self.done_s, self.name) {
            (Some(done_s), _) => done_s + self.plan.after_s,
            (None, DrillName::StopOnAlarm) => self.alarm_s + STOP_AWAITED_S,
            (None, _) => self.plan.limit_s,
        }
    }

    /// Whether the drill is over.
    pub fn is_over(&self) -> bool {
        self.has_begun() && self.now_s >= self.ends_s()
    }

    /// The state of the drill.
    pub fn state(&self, result: Option<DrillResult>) -> DrillState {
        let is_alarm = self.name == DrillName::StopOnAlarm;
        // The time of the alarm is not given away.
        let ends_s = if is_alarm { ALARM_S.1 + STOP_AWAITED_S } else { self.ends_s() };
        DrillState {
            name: self.name,
            seed: self.seed,
            left_s: if result.is_some() { 0.0 } else { (ends_s - self.now_s).max(0.0) },
            alarm: is_alarm && result.is_none() && self.done_s.is_none() && self.now_s >= self.alarm_s,
            result,
        }
    }

    /// The result of a drill that is over.
    ///
    /// # Errors
    /// As of a world that cannot be made anew.
    pub fn result(&self, drive: &Drive<'_>, setup: &DriveSetup) -> Result<DrillResult> {
        let person = DrillFigures::of(drive.log(), &setup.profile);
        let reference = |law| reference::figures(setup, law, &self.helm, drive.world().tick());
        let (passed, sentence) = self.verdict(&person);
        Ok(DrillResult {
            passed,
            sentence,
            person,
            schema: reference(LawChoice::MOTOR_SCHEMA)?,
            default_law: reference(LawChoice::OPTIMAL)?,
        })
    }

    fn verdict(&self, figures: &DrillFigures) -> (bool, String) {
        let limit_s = self.plan.limit_s;
        match (self.name, self.done_s) {
            (DrillName::KeepInView, _) if self.was_engaged => {
                (false, "The camera was engaged: this drill is by hand.".to_owned())
            }
            (DrillName::KeepInView, _) => (
                figures.in_picture >= MIN_IN_PICTURE,
                format!(
                    "The boat was in the picture for {:.0} % of the time; wanted: {:.0} %.",
                    100.0 * figures.in_picture,
                    100.0 * MIN_IN_PICTURE
                ),
            ),
            (DrillName::SelectInGlare | DrillName::FindTheBoat, Some(done_s)) => {
                let sentence = format!("The boat was followed after {done_s:.1} s; wanted: {limit_s:.0} s.");
                (done_s <= limit_s, sentence)
            }
            (DrillName::SelectInGlare | DrillName::FindTheBoat, None) => {
                (false, format!("The boat was not followed within {limit_s:.0} s."))
            }
            (DrillName::ReachAPerson, done) if self.closest_m < TOO_CLOSE_M => {
                let after = done.map_or_else(String::new, |done_s| format!(" after {done_s:.0} s"));
                let closest = self.closest_m;
                let sentence = format!(
                    "The boat reached a person{after}, and came as close as {closest:.1} m: stay {TOO_CLOSE_M} m away."
                );
                (false, sentence)
            }
            (DrillName::ReachAPerson, Some(done_s)) => (
                true,
                format!(
                    "The boat reached a person after {done_s:.0} s, and came no closer than {:.1} m.",
                    self.closest_m
                ),
            ),
            (DrillName::ReachAPerson, None) => (
                false,
                format!(
                    "The boat did not reach a person within {limit_s:.0} s: the closest was {:.1} m.",
                    self.closest_m
                ),
            ),
            (DrillName::StopOnAlarm, Some(done_s)) if done_s < self.alarm_s => {
                (false, "STOP was pressed before the alarm.".to_owned())
            }
            (DrillName::StopOnAlarm, Some(done_s)) => {
                let delay_s = done_s - self.alarm_s;
                let sentence =
                    format!("STOP was pressed {delay_s:.1} s after the alarm; wanted: {limit_s:.0} s.");
                (delay_s <= limit_s, sentence)
            }
            (DrillName::StopOnAlarm, None) => {
                (false, format!("STOP was not pressed within {STOP_AWAITED_S:.0} s of the alarm."))
            }
        }
    }
}

/// Whether the pilot follows the boat, and not another object.
fn is_followed(drive: &Drive<'_>) -> bool {
    let is_confirmed = drive.outcome().is_some_and(|outcome| !outcome.is_confirming);
    let track = drive.log().truth.iter().flatten().next_back().and_then(|row| row.track);
    is_confirmed
        && track.is_some_and(|track| track.is_tracking && track.iou.is_some_and(|iou| iou >= MIN_IOU))
}
