//! The summary of a sortie within its recording: an MCAP metadata record, found by the file's index.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::{Metadata, Record};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, Summary};

use super::record_lengths::MAX_RECORD_BYTES;
use crate::sortie::Sortie;

/// Name of the metadata record, and the key of its text, which is JSON.
const NAME: &str = "barrelman-sortie";
const KEY: &str = "summary";

/// Longest summary, bytes.
const MAX_SUMMARY_BYTES: u64 = 16 << 20;

/// Bytes of a record before its content: operation and length.
const RECORD_HEAD: u64 = 9;

/// The stored form of a summary.
pub(super) fn metadata_of(sortie: &Sortie) -> Metadata {
    let text = serde_json::to_string(sortie).unwrap_or_default();
    Metadata { name: NAME.to_owned(), metadata: BTreeMap::from([(KEY.to_owned(), text)]) }
}

/// Reads the summary of a recording, without its messages. `None`: there is none, for the recording was cut
/// off, is that of a trial, or the file is no recording ([`super::RecordingReader`] tells).
///
/// # Errors
/// If the input cannot be read.
pub fn read_sortie<R: Read + Seek>(mut input: R) -> io::Result<Option<Sortie>> {
    let bytes = input.seek(SeekFrom::End(0))?;
    input.rewind()?;
    match summary_of(&mut input, bytes) {
        Ok(Some(summary)) => sortie_of(&mut input, &summary),
        Err(McapError::Io(error)) => Err(error),
        Ok(None) | Err(_) => Ok(None),
    }
}

/// As [`read_sortie`], of a file whose index is read.
pub(super) fn sortie_of<R: Read + Seek>(input: &mut R, summary: &Summary) -> io::Result<Option<Sortie>> {
    let mut indexes = summary.metadata_indexes.iter();
    let index = indexes
        .find(|index| index.name == NAME)
        .filter(|index| (RECORD_HEAD..=MAX_SUMMARY_BYTES).contains(&index.length));
    let Some(index) = index else { return Ok(None) };
    let mut record = vec![0; index.length as usize];
    input.seek(SeekFrom::Start(index.offset))?;
    match input.read_exact(&mut record) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    let parsed = mcap::read::parse_record(record[0], &record[RECORD_HEAD as usize..]);
    let Ok(Record::Metadata(metadata)) = parsed else { return Ok(None) };
    Ok(metadata.metadata.get(KEY).and_then(|text| serde_json::from_str(text).ok()))
}

/// The index of a file of this length; `None`: it has none.
pub(super) fn summary_of<R: Read + Seek>(input: &mut R, bytes: u64) -> mcap::McapResult<Option<Summary>> {
    let options =
        SummaryReaderOptions::default().with_file_size(bytes).with_record_length_limit(MAX_RECORD_BYTES);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let read = input.read(reader.insert(wanted))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(input.seek(to)?),
        }
    }
    Ok(reader.finish())
}
