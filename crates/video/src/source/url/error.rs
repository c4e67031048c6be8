//! The errors of addresses.

use barrelman_host::fault::FaultPlanError;

/// An address that cannot be used. The messages say what to do instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VideoUrlError {
    /// The address is empty.
    #[error("no video source given: write a file name, rtsp://HOST/PATH, udp://0.0.0.0:PORT or /dev/video0")]
    Empty,
    /// The scheme is unknown.
    #[error(
        "`{url}` begins with an unknown scheme: use a file name, file:PATH, rtsp://HOST/PATH, udp://0.0.0.0:PORT, \
         /dev/video0, srt://, rtmp://, http://, https:// or gst:PIPELINE"
    )]
    UnknownScheme {
        /// The text of the user, without a password.
        url: String,
    },
    /// A host and a port without a scheme.
    #[error("`{url}` has no scheme: write rtsp://{url}")]
    NoScheme {
        /// The text of the user, without a password.
        url: String,
    },
    /// The address cannot be parsed.
    #[error("`{url}` is not an address ({reason}): write {form}")]
    Malformed {
        /// The text of the user, without a password.
        url: String,
        /// What is wrong.
        reason: String,
        /// What an address of this kind looks like.
        form: &'static str,
    },
    /// An option has a value that it cannot have.
    #[error("{name}={value} is not possible: write e.g. {example}")]
    InvalidOption {
        /// The option.
        name: &'static str,
        /// Its value.
        value: String,
        /// A value that is possible, with the option's name.
        example: &'static str,
    },
    /// A part of a password would be read as the host or the port.
    #[error(
        "the address of the video has an @ that is not the one before its host, and is not used: in a user's name, a password and \
         a path, write @ as %40, / as %2F, ? as %3F, # as %23, : as %3A and % as %25; or leave the login out of the address and give \
         --video-login-file FILE (video.login_file), a file with user:password as it is"
    )]
    StrayAt,
    /// A login was given for a source without one.
    #[error("{url} takes no login: only rtsp://, rtsps://, http:// and https:// do")]
    LoginNotSupported {
        /// The source.
        url: String,
    },
    /// A login was given in the address and beside it.
    #[error("the login of {url} is given twice: leave it out of the address")]
    LoginGivenTwice {
        /// The source, without the login.
        url: String,
    },
    /// A simulated world, where only a recording or a stream can be used.
    #[error(
        "{url} is a simulated world, which goes by the clock, and no recording: use `barrelman run --video {url}`"
    )]
    Simulated {
        /// The address as written.
        url: String,
    },
    /// A device that is neither a camera nor a pipe.
    #[error(
        "`{path}` is a device and neither a camera nor a pipe: write v4l2:{path} for a camera, - for standard input"
    )]
    OtherDevice {
        /// The path.
        path: String,
    },
    /// The plan of faults cannot be parsed.
    #[error(transparent)]
    Fault(#[from] FaultPlanError),
}
