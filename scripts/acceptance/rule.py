"""Tests the whole loop: a clip as input, the paper's rule as output, as an emulated Fotokite Pro received it.

A predictor computes the rates at every video frame from the clip's truth and the paper's rule; it uses nothing of the
program. The emulator's log has the rates that were in force. Both must agree, except in at most two frames where the
boat crosses a border: the tracker's centre differs from the hull's by pixels, and the boat moves about 5 px a frame.
The tracker is the paper's CamShift, whose centre on the clip's uniform red is known, because the rule is tested here.
"""
import re
import subprocess
import sys

import common
from common import HEIGHT, LISTENING_JITTER, WIDTH, Emulator, Recording, Standstills, Table

# The paper's rule, written down here once more on purpose.
HALF_WIDTH, HALF_HEIGHT = 0.6 * WIDTH / 2, 0.5 * HEIGHT / 2
RATE = 0.3
FRAMES_PER_CROSSING = 2

# What is sent, the wait after it in seconds. Lines are read in bursts at the far end, which may shorten a wait.
START_UP = [
    ("stop", 0.5), ("prompt", 0.0), ("stop", 0.5), ("RemoteControl start", 0.5), ("Checksum 0", 0.5),
    ("Pset 117,10.0", 0.05), ("Pcommit", 0.05), ("Pset 119,0", 0.05), ("Pcommit", 0.05), ("Get_GroundStatus 0", 0.05),
    ("Get_Att 0", 0.05), ("Get_Pos 0", 0.05), ("Get_FlightStatus 0", 0.05), ("Get_Gimbal 0", 0.05),
]


def rule(x, y):
    """(yaw rate, pitch rate) for a target at x to the right and y upwards of the picture's centre, in pixels."""
    if (x / HALF_WIDTH) ** 2 + (y / HALF_HEIGHT) ** 2 <= 1:
        return (0.0, 0.0)
    if abs(x) > abs(y):
        return (-RATE, 0.0) if x > 0 else (RATE, 0.0)
    return (0.0, -RATE) if y > 0 else (0.0, RATE)


def sector(rates):
    return {(0, 0): "inside", (-RATE, 0): "right", (RATE, 0): "left", (0, -RATE): "top", (0, RATE): "bottom"}[rates]


def in_force(rows, at):
    rates = (0.0, 0.0)
    for row in rows:
        if row.at > at:
            break
        rates = row.rates
    return rates


def check_rule(table, standstills, truth, recording, rows):
    frames = recording.frames
    table.require_in_time(standstills, "every video frame of the clip reached the pilot", len(frames) >= len(truth) - 2, f"{len(frames)} of {len(truth)}")
    predicted = [rule(row["cx"] - WIDTH / 2, HEIGHT / 2 - row["cy"]) for row in truth]
    crossings = [frame for frame in range(1, len(truth)) if predicted[frame] != predicted[frame - 1]]
    astray = {crossing: [] for crossing in crossings}
    alone = []
    compared = 0
    # What a frame asks for is in force until the next one is looked at.
    for this, following in zip(frames, frames[1:]):
        compared += 1
        frame = this.sequence
        if in_force(rows, recording.at(following.now_ns)) == predicted[frame]:
            continue
        nearest = min(crossings, key=lambda crossing: abs(crossing - frame), default=None)
        if nearest is not None and abs(nearest - frame) <= 2 * FRAMES_PER_CROSSING:
            astray[nearest].append(frame)
        else:
            alone.append(frame)
    for crossing, wrong in astray.items():
        name = f"frame {crossing}: {sector(predicted[crossing - 1])} -> {sector(predicted[crossing])}"
        table.require_in_time(standstills, name, len(wrong) <= FRAMES_PER_CROSSING, f"{len(wrong)} frames differ {wrong or ''}", f"at most {FRAMES_PER_CROSSING}")
    table.require_in_time(standstills, "nowhere else do they differ", not alone, f"{len(alone)} of {compared} frames {alone[:8] or ''}")
    seen = {sector(rates) for rates in predicted}
    table.require("the clip crosses all four sectors", len(seen) == 5, " ".join(sorted(seen)))
    offsets = []
    for outcome in recording.outcomes:
        if outcome.HasField("track") and outcome.track.HasField("localisation"):
            captured = outcome.track.localisation.captured_ns
            frame = next((frame for frame in frames if frame.captured_ns == captured), None)
            if frame:
                offsets.append((outcome.track.localisation.u - truth[frame.sequence]["cx"], outcome.track.localisation.v - truth[frame.sequence]["cy"]))
    distance = [(u * u + v * v) ** 0.5 for u, v in offsets]
    table.show("tracker's centre from the hull's: median, p95, largest", f"{common.median(distance):.1f}, {common.percentile(distance, 0.95):.1f}, {max(distance, default=0):.1f} px")
    return {"crossings": {str(crossing): wrong for crossing, wrong in astray.items()}, "elsewhere": alone, "compared": compared}


def check_start_up(table, standstills, rows):
    # The five carriage returns are no lines: their prompts show that they came.
    prompts = [row.at for row in rows if row.direction == "out" and row.raw.startswith("nsh>")]
    heard = [row for row in rows if row.direction == "in"]
    begun = next((index for index, row in enumerate(heard) if row.raw == "stop"), 0)
    table.require("the first bytes are zeros on both axes, three times, before `stop`", [row.is_zero for row in heard[:begun]] == [True] * 6, f"{begun} lines")
    # The zeros that are repeated until the prompt comes are no step of the start-up.
    heard = [(row.raw, row.at) for row in heard if not row.is_zero]
    first_stop = heard[0][1] if heard else 0.0
    prompted = next((at for at in prompts if at > first_stop + 0.3), None)
    events = heard[:1] + ([("prompt", prompted)] if prompted else []) + heard[1:]
    names = [name for name, _ in events[: len(START_UP)]]
    table.require("start-up: the lines in their order", names == [name for name, _ in START_UP], f"{len(names)} steps", "" if names == [name for name, _ in START_UP] else str(names))
    short = []
    for (name, wait), this, following in zip(START_UP, events, events[1:]):
        if following[1] - this[1] < wait - LISTENING_JITTER:
            short.append(f"{name}: {following[1] - this[1]:.3f} s")
    table.require_in_time(standstills, "start-up: the waits are kept", not short, f"{events[len(names) - 1][1] - events[0][1]:.2f} s in all", " ".join(short))
    up = events[len(START_UP) - 1][1] if len(events) >= len(START_UP) else float("inf")
    streams = {name: sum(row.raw.startswith(f"!{name} ") for row in rows if row.direction == "out") for name in ("GSStatus", "Attitude", "Pos", "FlightStatus", "Gimbal")}
    lasted = rows[-1].at - up
    table.require("telemetry streams on", all(count > 8 * lasted for count in streams.values()), " ".join(f"{name} {count / lasted:.1f}/s" for name, count in streams.items()), "10/s each")
    motions = [row for row in rows if row.is_motion]
    early = [row.raw for row in motions if row.at < up and not row.is_zero]
    table.require("no motion line before the link is up but zeros", not early, "; ".join(early[:3]))
    table.require("the first rates are zeros", motions and motions[0].is_zero, motions[0].raw if motions else "none")
    return up


def check_zeros(table, standstills, recording, rows):
    motions = [row for row in rows if row.is_motion]
    delays = []
    before = None
    for outcome in recording.outcomes:
        if before is not None:
            for name, was, now in (("Yaw", before.yaw_rate, outcome.yaw_rate), ("GimbalPitch", before.pitch_rate, outcome.pitch_rate)):
                if was and not now:
                    asked = recording.at(outcome.now_ns)
                    heard = next((row.at for row in motions if row.name == name and row.is_zero and row.at >= asked), None)
                    delays.append(heard - asked if heard else float("inf"))
        before = outcome
    table.require_in_time(standstills, "zeros after the localisation that re-entered or left an axis", delays and max(delays) <= 0.05, f"{len(delays)} times, largest {max(delays, default=0) * 1e3:.1f} ms", "at most 50 ms")
    sloppy = []
    threes = 0
    for name in ("Yaw", "GimbalPitch"):
        axis = [row for row in motions if row.name == name]
        for index in range(1, len(axis)):
            if axis[index].is_zero and axis[index - 1].moves:
                repeats = [row.at - axis[index].at for row in axis[index + 1 : index + 3] if row.is_zero]
                threes += 1
                if len(repeats) < 2 or abs(repeats[0] - 0.05) > LISTENING_JITTER or abs(repeats[1] - 0.1) > LISTENING_JITTER:
                    sloppy.append([round(repeat, 3) for repeat in repeats])
    table.require_in_time(standstills, "each such zero comes twice more, 50 ms apart", threes and not sloppy, f"{threes} times", str(sloppy) if sloppy else "")
    busiest = common.busiest_second(rows)
    table.require("lines with a rate in the busiest second", busiest <= 20, busiest, "at most 20")


def check_end(table, recording, rows):
    heard = [row for row in rows if row.direction == "in"]
    ended = recording.stopped_at()
    table.require("the end is put to the pilot as a stop", ended is not None)
    last = [row for row in heard if row.is_motion and ended and row.at >= ended]
    table.require("zeros after the end of the video", bool(last) and all(row.is_zero for row in last), f"{(last[0].at - ended) * 1e3:.1f} ms after it, {len(last)} lines" if last else "none")
    table.require("both axes rest", heard[-1].rates == (0.0, 0.0), str(heard[-1].rates))
    wait = heard[-1].at - last[-1].at if last else 0.0
    table.require("`stop` is the last line, half a second after the zeros", heard[-1].raw == "stop" and wait >= 0.5 - LISTENING_JITTER, f"{heard[-1].raw}, {wait:.3f} s", "at least 0.5 s")


def check_files(table, args, record, folder, frames):
    done = common.run([args.barrelman, "replay", record, "--compare"])
    table.require("replay --compare: the same commands", done.returncode == 0 and "same" in done.stdout, done.stdout.strip().splitlines()[-1] if done.stdout else done.stderr)
    done = common.run([args.barrelman, "metrics", record])
    table.require("metrics reads the recording", done.returncode == 0 and "record" in done.stdout, "", done.stderr)
    out = folder / "exported"
    done = common.run([args.barrelman, "export", record, "--output", out])
    rows = len((out / "input_frame.csv").read_text().splitlines()) - 1 if done.returncode == 0 else 0
    table.require("export writes every frame and the video", done.returncode == 0 and rows == frames and (out / "video.mp4").stat().st_size > 0, f"{rows} rows", done.stderr)


def main():
    args = common.arguments(__doc__, clip=common.CLIP)
    folder = common.temporary_folder()
    clip, truth = common.practice_clip(args, folder)
    table = Table("The practice clip through `run`, against the rule that predicts it")
    record = folder / "record.mcap"
    with Emulator(args.barrelman, folder) as emulator, Standstills() as standstills:
        command = [args.barrelman, "run", "--headless", "--engage", "--tracker", "camshift", "--law", "schema", "--video", f"file:{clip}", "--select", common.selection(truth), "--link", emulator.url, "--record", record]
        child = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        out, err = child.communicate(timeout=len(truth) / 30 + 20)
        table.require("run ends with exit 0 when the video does", child.returncode == 0, f"exit {child.returncode}", "" if child.returncode == 0 else err)
    recording = Recording(record)
    # `stop` is not the last thing to happen: telemetry goes on.
    rows = emulator.rows()
    figures = check_rule(table, standstills, truth, recording, rows)
    check_start_up(table, standstills, rows)
    check_zeros(table, standstills, recording, rows)
    check_end(table, recording, rows)
    check_files(table, args, record, folder, len(recording.frames))
    # Whether the machine can be kept awake is a property of the machine.
    lines = [line for line in err.splitlines() if re.search(r"WARN|ERROR|panicked", line) and "systemd-inhibit" not in line]
    table.require("no warning and no error on stderr", not lines, "", "; ".join(lines))
    return table.finish(args, **figures)


if __name__ == "__main__":
    sys.exit(main())
