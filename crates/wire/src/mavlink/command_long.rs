//! COMMAND_LONG (76): a command with seven parameters.

use core::time::Duration;

use barrelman_vocab::mavlink::Address;
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd};

/// A command to a component.
pub(super) fn command_long(to: Address, command: MavCmd, parameters: [f32; 7]) -> COMMAND_LONG_DATA {
    let [param1, param2, param3, param4, param5, param6, param7] = parameters;
    COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        param4,
        param5,
        param6,
        param7,
        command,
        target_system: to.system.0,
        target_component: to.component.0,
        confirmation: 0,
    }
}

/// MAV_CMD_REQUEST_MESSAGE (512): once.
pub(super) fn request_message(to: Address, message: u32) -> COMMAND_LONG_DATA {
    let parameters = [message as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    command_long(to, MavCmd::MAV_CMD_REQUEST_MESSAGE, parameters)
}

/// MAV_CMD_SET_MESSAGE_INTERVAL (511).
pub(super) fn set_interval(to: Address, message: u32, interval: Duration) -> COMMAND_LONG_DATA {
    let parameters = [message as f32, interval.as_micros() as f32, 0.0, 0.0, 0.0, 0.0, 0.0];
    command_long(to, MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, parameters)
}
