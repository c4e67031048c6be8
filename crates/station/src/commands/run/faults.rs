//! The deliberate faults of a run.

use anyhow::{Context, Result, bail};
use barrelman_host::fault::FaultKind;
use barrelman_host::fault_lines::parse_fault_lines;
use barrelman_host::input;

use crate::cli::RunArgs;
use crate::link::LinkUrl;
use crate::live::faults::{FAULT_THREADS, FaultInjector};
use crate::source_url::SourceUrl;

/// The kinds of faults that have an effect on a link.
const LINK_FAULTS: [FaultKind; 4] =
    [FaultKind::Stall, FaultKind::Drop, FaultKind::Disconnect, FaultKind::Panic];
/// The kinds of faults that have an effect on a source of video.
const VIDEO_FAULTS: [FaultKind; 7] = [
    FaultKind::Stall,
    FaultKind::Drop,
    FaultKind::Delay,
    FaultKind::Duplicate,
    FaultKind::Corrupt,
    FaultKind::Disconnect,
    FaultKind::Panic,
];

/// The faults of the command line and of the file of faults, each at its place.
pub(super) fn injected_faults(
    args: &RunArgs,
    mut link: Option<&mut LinkUrl>,
    source: &mut SourceUrl,
) -> Result<FaultInjector> {
    let mut injector = FaultInjector::parse(&args.fault)?;
    if let Some(path) = &args.faults {
        let context = || format!("the file of faults {} is not usable", path.display());
        let text =
            String::from_utf8(input::read(path)?).context("it is not UTF-8 text").with_context(context)?;
        for placed in parse_fault_lines(&text).with_context(context)? {
            let Some(placed) = injector.add(placed).with_context(context)? else { continue };
            match (placed.place.as_str(), &mut link) {
                ("link", Some(link)) => link.faults.extend(placed.plan),
                ("link", None) => bail!("{}: there is no link: give --link", context()),
                ("video", _) => source.faults_mut().extend(placed.plan),
                (place, _) => bail!(
                    "{}: {place:?} is no place: use link, video, program, or one of the threads {FAULT_THREADS:?}",
                    context()
                ),
            }
        }
    }
    if let Some(link) = link {
        link.faults.require_effect("the link", &LINK_FAULTS)?;
    }
    source.faults_mut().require_effect("the video", &VIDEO_FAULTS)?;
    Ok(injector)
}
