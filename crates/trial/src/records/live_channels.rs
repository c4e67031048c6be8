//! The messages of a recording, passed on while they are written, for Foxglove and Lichtblick.

use std::collections::BTreeMap;
use std::sync::Arc;

use foxglove::{ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema};

use super::topics::Topic;

/// The channels of a recording in a context of Foxglove's, where a server finds them.
pub struct LiveChannels {
    context: Arc<Context>,
    channels: BTreeMap<Topic, Arc<RawChannel>>,
}

impl LiveChannels {
    /// The channels of a recording: all but its start, which holds the whole configuration.
    ///
    /// # Errors
    /// Foxglove's library refuses a channel.
    pub fn new() -> Result<Self, FoxgloveError> {
        let context = Context::new();
        let mut channels = BTreeMap::new();
        for topic in Topic::ALL.into_iter().filter(|topic| *topic != Topic::Start) {
            let (name, descriptors) = topic.schema();
            let channel = ChannelBuilder::new(topic.name())
                .context(&context)
                .message_encoding("protobuf")
                .schema(Schema::new(name, "protobuf", descriptors))
                .build_raw()?;
            channels.insert(topic, channel);
        }
        Ok(Self { context, channels })
    }

    /// The context, for a server.
    pub const fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Passes a message on. Never waits: a slow reader loses messages.
    pub(super) fn log(&self, topic: Topic, message: &[u8], unix_ns: u64) {
        if let Some(channel) = self.channels.get(&topic) {
            channel.log_with_meta(message, PartialMetadata { log_time: Some(unix_ns) });
        }
    }
}
