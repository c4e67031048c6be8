//! What the loop makes of the states of the videos.

use barrelman_console_server::snapshot::VideoSourceState;
use barrelman_video::VideoState;
use barrelman_vocab::{StopCause, VideoNumber};

use super::run_loop::{Ending, LoopState, RunEnd, RunLoop, failed};

impl RunLoop<'_> {
    /// Logs a change of a video. Of the failed connections, the first of each reason is logged; all are
    /// counted. The end of the tracked video ends the run; that of the other one does not.
    pub(super) fn on_video_state(
        &mut self,
        state: &mut LoopState,
        number: VideoNumber,
        video: VideoState,
    ) -> Option<Ending> {
        let is_tracked = number == self.tracked.number();
        let name = match number {
            VideoNumber::First => "video",
            VideoNumber::Second => "video 2",
        };
        let connections = match number {
            VideoNumber::First => &mut state.connections.first,
            VideoNumber::Second => state.connections.second.get_or_insert_default(),
        };
        let (state, ending) = match video {
            VideoState::Connecting => return None,
            VideoState::Up => {
                match connections.on_up() {
                    0 | 1 => tracing::info!("{name}: up"),
                    attempts => tracing::info!("{name}: up, after {attempts} attempts"),
                }
                (VideoSourceState::Up, None)
            }
            VideoState::Lost { reason } => {
                if connections.on_lost(&reason) {
                    match (connections.failed, connections.has_been_up) {
                        (1, true) => tracing::warn!("the {name} was lost ({reason}); reconnecting"),
                        (1, false) => {
                            tracing::warn!("no {name} yet ({reason}); retrying until the source answers");
                        }
                        (attempts, _) => {
                            tracing::warn!("still no {name} after {attempts} attempts ({reason}); retrying");
                        }
                    }
                }
                (VideoSourceState::Lost(reason), None)
            }
            VideoState::Ended => (VideoSourceState::Ended, Some((StopCause::VideoEnded, RunEnd::VideoEnded))),
            VideoState::Failed(error) => {
                let reason = format!("{:#}", anyhow::Error::from(error));
                if is_tracked {
                    return Some(failed(reason));
                }
                tracing::error!("{name}: {reason}; the run goes on without it");
                (VideoSourceState::Lost(reason), None)
            }
        };
        self.publisher.set_video(number, state, self.events.now());
        ending.filter(|_| is_tracked)
    }
}
