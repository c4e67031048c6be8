"""The states of a console: what the program tells the page, and what the page then shows."""

from typing import Any, NamedTuple


def mode(name: str, cause: str | None = None) -> dict[str, Any]:
    return {"name": name, "cause": cause, "engaged": name in ("servoing", "holding")}


BOX = {
    "state": "tracking",
    "confirming": False,
    "doubted": False,
    "box": [400.0, 200.0, 60.0, 40.0],
    "centre": [430.0, 220.0],
    "lost_s": None,
}
PERSON_AT = [300.0, 300.0]
PERSON = {
    "id": 7,
    "kind": "person",
    "destination": True,
    "at": PERSON_AT,
    "ring": [],
    "water_m": [0.0, 40.0],
    "on_earth": None,
    "std_dev_m": 3.5,
    "radius_m": 2.0,
}
ALARMS = ["camera-turns", "boat-moves", "no-video", "stale-video", "link-down", "end-stop", "battery-low"]


class State(NamedTuple):
    """What the program tells, and what the page's data then say. `press`: a button that is pressed first."""

    snapshot: dict[str, Any]
    shown: str
    more: dict[str, Any] = {}  # noqa: RUF012
    press: str | None = None


# The number of the other page.
OTHER = 4711
STATES = {
    "disengaged": State({"mode": mode("idle"), "track": BOX}, "d.mode === 'idle' && d.next === 'engage'"),
    "engaged": State({"mode": mode("servoing"), "track": BOX}, "d.mode === 'servoing'"),
    "nudging": State({"mode": mode("nudging"), "track": BOX}, "d.next === 'nudge'"),
    "holding": State(
        {"mode": mode("holding", "no-control"), "track": {**BOX, "state": "coasting"}}, "d.mode === 'holding'"
    ),
    "doubted": State(
        {"mode": mode("holding", "doubted"), "track": {**BOX, "doubted": True}}, "d.next === 'doubted'"
    ),
    "searching": State({"mode": mode("searching"), "track": {"state": "lost"}}, "d.next === 'searching'"),
    "stopped": State({"mode": mode("stopped", "suspended"), "track": BOX}, "d.mode === 'stopped'"),
    "lost": State(
        {
            "mode": mode("holding", "track-lost"),
            "track": {"state": "lost", "box": None, "centre": None, "lost_s": 12.0},
            "alarms": ["track-lost"],
        },
        "d.track === 'lost'",
    ),
    "alarms present": State(
        {
            "mode": mode("servoing"),
            "track": BOX,
            "alarms": ALARMS,
            "video": {"reason": "0.9 s late for 12 s"},
        },
        "d.next === 'camera-turns'",
    ),
    "tether wound": State(
        {"net_yaw_deg": 400.0, "alarms": ["net-yaw"]}, "document.querySelector('#alarms li')"
    ),
    "a person to be renewed": State(
        {"mode": mode("servoing"), "track": BOX, "vessel": {"marks": [PERSON], "mode": "guided"}},
        "d.next === 'person'",
    ),
    "a boat that says much": State(
        {"vessel": {"mode": "holding", "says": "x y " * 29, "go_again": True, "guidance": "blocked"}},
        "d.boat === 'holding'",
    ),
    "another page asks": State({}, "document.querySelector('[data-give]')", {"control": {"asking": [OTHER]}}),
    "another page controls": State({}, "d.next === 'watch'", {"control": {"holder": OTHER}}),
    "a watch link": State(
        {}, "d.next === 'watchLink'", {"hello": {"may_control": False}, "control": {"holder": OTHER}}
    ),
    "marking": State({"track": BOX}, "d.marking === 'yes'", press="mark"),
    "paused": State({"drive": {"paused": True, "waits": False}}, "d.next === 'paused'"),
    "stale video": State({"mode": mode("servoing"), "track": BOX}, "d.stale === 'yes'", {"drops": "video"}),
    "connection lost": State({"mode": mode("servoing")}, "d.old === 'yes'", {"drops": "all"}),
}
