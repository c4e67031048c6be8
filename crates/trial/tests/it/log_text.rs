//! Reading logs as text, and the errors of logs that cannot be read.

use barrelman_trial::logs::{LogError, ParsedLog, exported, laboratory, read_text};
use barrelman_vocab::{ImagePoint, PictureSize};
use proptest::prelude::*;

use crate::trial_logs::command;

/// Reads a laboratory log, whose first row follows the header without a line end.
fn laboratory_log(rows: &str) -> Result<ParsedLog, LogError> {
    read_text(&format!("{}{rows}", laboratory::HEADER))
}

fn exported_log(rows: &str) -> Result<ParsedLog, LogError> {
    read_text(&format!("{}\n{rows}", exported::HEADER))
}

#[test]
fn laboratory_rows_have_seven_fields_or_six() {
    let check = |rows: &str| {
        let read = laboratory_log(rows).unwrap();
        assert_eq!((read.log.rows.len(), read.truncated_at_line), (2, None), "{rows}");
        let [first, second] = read.log.rows[..] else { panic!("two rows") };
        assert_eq!(first.position, Some(ImagePoint { x: -78.0, y: 17.5 }));
        // The Fotokite Pro's signs are the other way round.
        assert_eq!(first.command, Some(command(-0.3, 0.25)));
        assert_eq!((first.time_s, second.time_s), (0.0, 1.0 / 37.23));
        assert_eq!(read.log.last_row_duration_s, 1.0 / 37.23);
        assert_eq!(read.log.frame, PictureSize::new(640, 480));
        assert_eq!(read.log.picture, PictureSize::new(640, 360));
        assert!(!read.log.records_track_loss);
    };
    check("-78,17.5,-0.25,0.3,0.18,0.000000,1493598415\n-77,14,0,0,0.17,0,1493598415\n");
    check("-78,17.5,-0.25,0.3,0.18,1493598415\n-77,14,0,0,0.17,1493598415\n");
    check("-78,17.5,-0.25,0.3,0.18,1493598415\r\n-77,14,0,0,0.17,1493598415\r\n");
    check(" -78 , 17.5, -0.25, 0.3, 0.18, 1493598415\n-77,14,0,0,0.17,1493598415\n");
    check("-78,17.5,-0.25,0.3,0.18,1493598415\n-77,14,,,,1493598415\n");
}

#[test]
fn a_mode_with_a_comma_is_one_quoted_field() {
    let read = exported_log("0,1,2,0.5,0.25,0,\"holding: dry run, nothing is sent\",640,480\n").unwrap();
    assert_eq!(read.log.rows[0].command, Some(command(0.25, 0.0)));
    assert_eq!(read.log.frame, PictureSize::new(640, 480));
}

#[test]
fn blank_commands_are_commands_that_the_log_does_not_tell() {
    let read = laboratory_log("1,2,,,,0,9\n3,4,0.3,,,0,9\n5,6,,0.3,,0,9\n7,8,0.3,0,,0,9\n").unwrap();
    let commands: Vec<_> = read.log.rows.iter().map(|row| row.command).collect();
    assert_eq!(commands, [None, None, None, Some(command(0.0, -0.3))]);
    assert!(read.log.rows.iter().all(|row| row.position.is_some()));
}

#[test]
fn a_last_line_without_its_end_is_a_cut_that_is_named() {
    let check = |rows: &str, whole: usize, line: usize| {
        let read = laboratory_log(rows).unwrap();
        assert_eq!((read.log.rows.len(), read.truncated_at_line), (whole, Some(line)), "{rows}");
    };
    check("1,2,0,0,0,0,9\n3,4,0,0,0,0,9", 1, 2);
    check("1,2,0,0,0,0,9\n3,", 1, 2);
    check("1,2,0,0,0,0,9\n3,4,0,0,0,0,9\n5", 2, 3);
    assert_eq!(laboratory_log("1,2,0,0,0,0,9"), Err(LogError::Empty));
    assert_eq!(laboratory_log(""), Err(LogError::Empty));
}

#[test]
fn a_row_that_cannot_be_understood_is_named_by_its_line() {
    let check = |rows: &str, expected: &str| {
        assert_eq!(laboratory_log(rows).unwrap_err().to_string(), expected, "{rows}");
    };
    check("1,2,0,0,0,0,9\n3,4,0,0,0,9\n", "line 2: 6 fields where the first row has 7");
    check("1,2,0,0,0,9\n3,4,0,0,0,9\n5,6,0,0,0,0,9\n", "line 3: 7 fields where the first row has 6");
    check("1,2,0,0,0\n", "line 1: 5 fields where the first row has 7");
    check("1,2,0,0,0,0,0,9\n", "line 1: 8 fields where the first row has 7");
    check("1,2,0,0,0,9\none,2,0,0,0,9\n", "line 2: x is \"one\", which is not a number");
    check("1,,0,0,0,9\n", "line 1: y is \"\", which is not a number");
    check("1,nan,0,0,0,9\n", "line 1: y is \"nan\", which is not a number");
    check("inf,1,0,0,0,9\n", "line 1: x is \"inf\", which is not a number");
    check("1,2,fast,0,0,9\n", "line 1: pitch is \"fast\", which is not a number");
    check("1,2,0,0.3x,0,9\n", "line 1: yaw is \"0.3x\", which is not a number");
}

#[test]
fn a_log_that_was_repaired_by_hand_is_read() {
    let rows = |text: &str| laboratory_log(text).unwrap().log.rows.len();
    assert_eq!(rows("\n1,2,0,0,0,9\n3,4,0,0,0,9\n"), 2);
    assert_eq!(rows("1,2,0,0,0,9\n3,4,0,0,0,9\n\n"), 2);
}

#[test]
fn what_is_no_log_is_said_to_be_none() {
    let check = |text: &str, expected: LogError| assert_eq!(read_text(text), Err(expected), "{text:?}");
    check("", LogError::Empty);
    check(" \r\n \n", LogError::Empty);
    check("hello\nworld\n", LogError::UnknownHeader { found: "hello".to_owned() });
    check("time_s,x,y\n1,2,3\n", LogError::UnknownHeader { found: "time_s,x,y".to_owned() });
    check(&"é".repeat(100), LogError::UnknownHeader { found: "é".repeat(60) });
}

#[test]
fn an_exported_log_goes_by_the_names_of_its_columns() {
    let check = |text: &str| {
        let read = read_text(text).unwrap();
        let [first, second] = read.log.rows[..] else { panic!("two rows") };
        assert_eq!(first.position, Some(ImagePoint { x: 1.0, y: 2.0 }));
        assert_eq!((first.command, second.command), (Some(command(-0.3, -0.1)), Some(command(0.0, 0.0))));
        // Times count from the first row.
        assert_eq!((first.time_s, second.time_s, read.log.last_row_duration_s), (0.0, 0.5, 0.5));
    };
    check("time_s,x,y,pan_rate,tilt_rate\n10,1,2,-0.3,-0.1\n10.5,1,2,0,0\n");
    check("time_s,x,y,pan_rate,tilt_rate,pitch_rate,yaw_rate\n10,1,2,-0.3,-0.1,9,9\n10.5,1,2,0,0,9,9\n");
    // Files of `law`: the Fotokite Pro's own signs.
    check("time_s,x,y,pitch_rate,yaw_rate\n10,1,2,0.1,0.3\n10.5,1,2,0,0\n");
    check("yaw_rate,pitch_rate,note,y,x,time_s\n0.3,0.1,hm,2,1,10\n0,0,,2,1,10.5\n");
    check("row,time_s,x,y,p,pitch_rate,yaw_rate\r\n0,10,1,2,7,0.1,0.3\r\n1,10.5,1,2,7,0,0\r\n");
    check(" time_s , x ,y,pitch_rate,yaw_rate\n10,1,2,0.1,0.3\n10.5, 1 ,2,0,0\n");
}

#[test]
fn an_exported_log_tells_its_picture_and_its_lost_moments() {
    let read = exported_log("0,,,,0,0,idle,,\n1,5,6,0.1,0,0,idle,1280,720\n2,,,,0,0,idle,,\n").unwrap();
    let size = PictureSize::new(1280, 720);
    assert_eq!((read.log.frame, read.log.picture, read.log.records_track_loss), (size, size, true));
    let positions: Vec<_> = read.log.rows.iter().map(|row| row.position).collect();
    assert_eq!(positions, [None, Some(ImagePoint { x: 5.0, y: 6.0 }), None]);
    let plain = read_text("time_s,x,y,pitch_rate,yaw_rate\n0,1,2,0,0\n").unwrap().log;
    assert_eq!((plain.frame, plain.picture), (laboratory::FRAME, laboratory::PICTURE));
    assert!(!plain.records_track_loss);
}

#[test]
fn an_exported_log_that_cannot_be_understood_names_the_line() {
    let check = |rows: &str, expected: &str| {
        assert_eq!(exported_log(rows).unwrap_err().to_string(), expected, "{rows}");
    };
    check("", "the log has no rows");
    check("0,1,2,3,0,0,idle,640,480", "the log has no rows");
    check("0,1,2,3,0,0,idle,640\n", "line 2: 8 fields where the first row has 9");
    check("0,1,2,3,0,0,idle,,\nx,1,2,3,0,0,idle,,\n", "line 3: time_s is \"x\", which is not a number");
    check("0,a,2,3,0,0,idle,,\n", "line 2: x is \"a\", which is not a number");
    check(
        "1,1,2,3,0,0,idle,,\n0.5,1,2,3,0,0,idle,,\n",
        "line 3: the time 0.5 s is earlier than that of the row above",
    );
}

#[test]
fn an_exported_log_may_be_cut() {
    let read = exported_log("0,1,2,3,0,0,idle,,\n1,1,2,3,0").unwrap();
    assert_eq!((read.log.rows.len(), read.truncated_at_line), (1, Some(3)));
    assert_eq!(read_text(exported::HEADER), Err(LogError::Empty));
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in any::<String>()) {
        let _ = read_text(&text);
    }

    #[test]
    fn any_rows_are_read_or_refused(
        exported_header in any::<bool>(),
        rows in "([-0-9.,eE\\r\\n x]|nan|inf|,,|1,2,0,0,0,9\\n|0,1,2,3,0,0,idle,640,480\\n){0,40}",
    ) {
        let read = if exported_header { exported_log(&rows) } else { laboratory_log(&rows) };
        if let Ok(read) = read {
            prop_assert!(!read.log.rows.is_empty());
            prop_assert!(read.log.rows.iter().all(|row| row.time_s >= 0.0));
            let region = read.log.region(barrelman_vocab::VehicleProfile::fotokite_pro().region);
            let _ = barrelman_trial::metrics::measure(&read.log, region, read.log.picture);
        }
    }
}
