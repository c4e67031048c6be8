//! The calls of the services: what they ask of the console, and what they answer.

use std::time::Duration;

use barrelman_vocab::CameraRequest;
use tokio::time::timeout;

use crate::console::api::{Answer, AnswerKind};
use crate::console::line::Line;
use crate::console::request::post;
use crate::messages::TriggerResponse;
use crate::stops::Stops;

/// How long a caller waits for an answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// A stop that was pressed: waits for its confirmation.
pub async fn stop(line: &Line, stops: &Stops, number: u64) -> TriggerResponse {
    match timeout(PATIENCE, stops.confirmed(number)).await {
        Ok(()) => succeeded("stopped"),
        Err(_) => failed(format!(
            "the console at {} has not confirmed the stop within {} s; the stop is repeated until it does: \
             use the ground station's own stop",
            line.url(),
            PATIENCE.as_secs()
        )),
    }
}

/// Asks the console to engage. A stop that is pressed meanwhile takes the request back.
pub async fn engage(line: &Line, stops: &Stops) -> TriggerResponse {
    if stops.is_pending() {
        return failed("a stop is not confirmed by the console yet: engage once it is");
    }
    let newest = *stops.presses().borrow();
    let request = CameraRequest::Engage.into();
    tokio::select! {
        biased;
        () = stops.pressed_after(newest) => failed("a stop was called meanwhile"),
        answer = timeout(PATIENCE, post(line, &request)) => match answer {
            Ok(Ok(answer)) => response(answer),
            Ok(Err(reason)) => failed(reason),
            Err(_) => {
                failed(format!("no answer of the console at {} in {} s", line.url(), PATIENCE.as_secs()))
            }
        },
    }
}

/// The answer of the console as that of the service.
fn response(Answer { answer, reason, .. }: Answer) -> TriggerResponse {
    let or = |text: &str| reason.unwrap_or_else(|| text.to_owned());
    match answer {
        AnswerKind::Accepted => succeeded(or("engaged")),
        AnswerKind::Refused => failed(or("refused")),
        AnswerKind::Superseded => failed(or("superseded")),
    }
}

fn succeeded(message: impl Into<String>) -> TriggerResponse {
    TriggerResponse { success: true, message: message.into() }
}

/// A call without success.
pub fn failed(message: impl Into<String>) -> TriggerResponse {
    TriggerResponse { success: false, message: message.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(answer: AnswerKind, reason: Option<&str>, success: bool, message: &str) {
        let found = response(Answer { id: 0, answer, reason: reason.map(str::to_owned) });
        assert_eq!(found, TriggerResponse { success, message: message.to_owned() });
    }

    #[test]
    fn an_answer_carries_the_reason() {
        check(AnswerKind::Accepted, None, true, "engaged");
        check(AnswerKind::Accepted, Some("dry run"), true, "dry run");
        check(AnswerKind::Refused, Some("a page is in control"), false, "a page is in control");
        check(AnswerKind::Superseded, None, false, "superseded");
    }
}
