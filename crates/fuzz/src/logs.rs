//! Texts: logs of trials, lines of telemetry, plans of faults.

use barrelman_host::fault_lines::parse_fault_lines;
use barrelman_wire::fotokite_pro::telemetry;

/// Any text is read or refused.
pub fn parse(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let _ = barrelman_trial::logs::read_text(&text);
    for line in text.lines() {
        let _ = telemetry::parse(line);
    }
    if let Ok(places) = parse_fault_lines(&text) {
        for placed in places {
            let again = barrelman_host::fault::FaultPlan::parse(&placed.plan.to_string());
            assert_eq!(again, Ok(placed.plan), "a plan prints as it is read");
        }
    }
}
