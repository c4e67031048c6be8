"""The whole loop: a clip as input, the paper's rule as output, as an emulated Fotokite Pro received it.

A predictor computes the rates at every video frame from the clip's truth and the paper's rule; it uses
nothing of the program. The emulator's log has the rates that were in force. Both must agree, except in at
most two frames where the boat crosses a border: the tracker's centre differs from the hull's by pixels, and
the boat moves about 5 px a frame. The tracker is the paper's CamShift, whose centre on the clip's uniform red
is known, because the rule is tested here.
"""

import dataclasses
import itertools
import pathlib
import re

import pytest

from camera import FPS, HEIGHT, WIDTH
from conftest import Check, Clip
from emulator import LISTENING_JITTER, Emulator, Row, busiest_second
from machine import Delay, lost, took
from process import ENDS_WITHIN, Lines, run, spawn
from recording import Recording

pytestmark = [pytest.mark.realtime, pytest.mark.clocked("module")]

# The paper's rule, written down here once more on purpose.
HALF_WIDTH, HALF_HEIGHT = 0.6 * WIDTH / 2, 0.5 * HEIGHT / 2
RATE = 0.3
FRAMES_PER_CROSSING = 2

# What is sent, the wait after it in seconds. Lines are read in bursts at the far end, which may shorten a
# wait.
START_UP = [
    ("stop", 0.5),
    ("prompt", 0.0),
    ("stop", 0.5),
    ("RemoteControl start", 0.5),
    ("Checksum 0", 0.5),
    ("Pset 117,10.0", 0.05),
    ("Pcommit", 0.05),
    ("Pset 119,0", 0.05),
    ("Pcommit", 0.05),
    ("Get_GroundStatus 0", 0.05),
    ("Get_Att 0", 0.05),
    ("Get_Pos 0", 0.05),
    ("Get_FlightStatus 0", 0.05),
    ("Get_Gimbal 0", 0.05),
]

Rates = tuple[float, float]


def rule(x: float, y: float) -> Rates:
    """(yaw rate, pitch rate) for a target at x to the right and y upwards of the picture's centre, in
    pixels."""
    if (x / HALF_WIDTH) ** 2 + (y / HALF_HEIGHT) ** 2 <= 1:
        return (0.0, 0.0)
    if abs(x) > abs(y):
        return (-RATE, 0.0) if x > 0 else (RATE, 0.0)
    return (0.0, -RATE) if y > 0 else (0.0, RATE)


@dataclasses.dataclass
class Run:
    """A run that has ended, and what the ground station and the recording have of it."""

    clip: Clip
    code: int
    errors: list[tuple[float, str]]
    path: pathlib.Path
    recording: Recording
    rows: list[Row]

    def __post_init__(self) -> None:
        self.heard = [row for row in self.rows if row.is_heard]
        self.motions = [row for row in self.rows if row.is_motion]


@pytest.fixture(scope="module")
def ended(barrelman: pathlib.Path, clip: Clip, tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("rule")
    record = folder / "record.mcap"
    with Emulator(barrelman, folder) as emulator:
        what = [
            "--tracker",
            "camshift",
            "--law",
            "schema",
            "--video",
            f"file:{clip.video}",
            "--select",
            clip.selection,
        ]
        child = spawn(
            [barrelman, "run", "--headless", "--engage", *what, "--link", emulator.url, "--record", record]
        )
        errors = Lines(child.stderr)
        code = child.wait(timeout=len(clip.truth) / FPS + ENDS_WITHIN)
        errors.join()
    return Run(clip, code, errors.lines, record, Recording(record), emulator.rows())


def test_run_ends_with_exit_0_when_the_video_does(ended: Run) -> None:
    assert ended.code == 0, ended.errors


def test_stderr_has_no_warning_and_no_error(ended: Run) -> None:
    # Whether the machine can be kept awake is a property of the machine, and so is a guard that gets no time.
    complaints = [
        (at, line)
        for at, line in ended.errors
        if re.search(r"WARN|ERROR|panicked", line) and "systemd-inhibit" not in line
    ]
    assert not [line for at, line in complaints if not ("the guard is gone" in line and lost(at - 0.5, at))]


@pytest.fixture(scope="module")
def predicted(clip: Clip) -> list[Rates]:
    return [rule(row["cx"] - WIDTH / 2, HEIGHT / 2 - row["cy"]) for row in clip.truth]


class TestRule:
    def test_clip_crosses_all_four_sectors(self, predicted: list[Rates]) -> None:
        assert set(predicted) == {(0, 0), (-RATE, 0), (RATE, 0), (0, -RATE), (0, RATE)}

    def test_every_frame_of_the_clip_reaches_the_pilot(self, ended: Run) -> None:
        frames = ended.recording.frames
        skipped = FPS * lost(ended.recording.at(frames[0].now_ns), ended.recording.at(frames[-1].now_ns))
        assert len(frames) >= len(ended.clip.truth) - 2 - skipped

    def test_rates_in_force_are_the_predicted_ones_except_at_crossings(
        self, ended: Run, predicted: list[Rates], check: Check
    ) -> None:
        crossings = [frame for frame in range(1, len(predicted)) if predicted[frame] != predicted[frame - 1]]
        astray: dict[int, list[int]] = {crossing: [] for crossing in crossings}
        alone: list[int] = []
        rows, row = ended.rows, 0
        rates = (0.0, 0.0)
        # What a frame asks for is in force until the next one is looked at.
        for this, following in itertools.pairwise(ended.recording.frames):
            at, frame = ended.recording.at(following.now_ns), this.sequence
            while row < len(rows) and rows[row].at <= at:
                rates = rows[row].rates
                row += 1
            if rates == predicted[frame] or lost(at - 0.3, at):
                continue
            nearest = min(crossings, key=lambda crossing: abs(crossing - frame))
            (astray[nearest] if abs(nearest - frame) <= 2 * FRAMES_PER_CROSSING else alone).append(frame)
        for crossing, wrong in astray.items():
            check(
                f"at most {FRAMES_PER_CROSSING} frames differ around frame {crossing}",
                len(wrong) <= FRAMES_PER_CROSSING,
                wrong,
            )
        check("no frame differs elsewhere", not alone, alone)


@pytest.fixture(scope="module")
def events(ended: Run) -> list[tuple[str, float]]:
    """The lines of the start-up, and the prompt, with their times."""
    # The five carriage returns are no lines: their prompts show that they came. The zeros are no step of the
    # start-up.
    heard = [(row.raw, row.at) for row in ended.heard if not row.is_zero]
    prompts = [
        row.at
        for row in ended.rows
        if not row.is_heard and row.raw.startswith("nsh>") and row.at > heard[0][1] + 0.3
    ]
    return heard[:1] + [("prompt", at) for at in prompts[:1]] + heard[1:]


class TestStartUp:
    def test_first_bytes_are_zeros_on_both_axes_three_times_before_stop(self, ended: Run) -> None:
        assert [row.is_zero for row in itertools.takewhile(lambda row: row.raw != "stop", ended.heard)] == [
            True
        ] * 6

    def test_lines_come_in_their_order(self, events: list[tuple[str, float]]) -> None:
        assert [name for name, _ in events[: len(START_UP)]] == [name for name, _ in START_UP]

    def test_waits_are_kept(self, events: list[tuple[str, float]]) -> None:
        for (name, wait), (_, this), (_, following) in zip(START_UP, events, events[1:], strict=False):
            assert following - this >= wait - LISTENING_JITTER - lost(this - 0.5, following), name

    def test_no_motion_but_zeros_before_the_link_is_up(
        self, ended: Run, events: list[tuple[str, float]]
    ) -> None:
        assert ended.motions[0].is_zero
        assert not [
            row.raw for row in ended.motions if row.at < events[len(START_UP) - 1][1] and not row.is_zero
        ]

    @pytest.mark.parametrize("stream", ["GSStatus", "Attitude", "Pos", "FlightStatus", "Gimbal"])
    def test_telemetry_streams_at_10_hz(
        self, ended: Run, events: list[tuple[str, float]], stream: str
    ) -> None:
        count = sum(row.raw.startswith(f"!{stream} ") for row in ended.rows if not row.is_heard)
        assert count > 8 * took(events[len(START_UP) - 1][1], ended.rows[-1].at)


class TestZeros:
    def test_zero_follows_within_50_ms_of_the_localisation_that_asks_for_it(self, ended: Run) -> None:
        delays = []
        for before, outcome in itertools.pairwise(ended.recording.outcomes):
            for name, was, now in (
                ("Yaw", before.yaw_rate, outcome.yaw_rate),
                ("GimbalPitch", before.pitch_rate, outcome.pitch_rate),
            ):
                if was and not now:
                    asked = ended.recording.at(outcome.now_ns)
                    heard = (
                        row.at
                        for row in ended.motions
                        if row.name == name and row.is_zero and row.at >= asked
                    )
                    delays.append(Delay.between(asked, next(heard, float("inf")), processes=3))
        assert delays
        max(delays, key=lambda delay: delay.seconds).judge(0.05)

    @pytest.mark.parametrize("name", ["Yaw", "GimbalPitch"])
    def test_zero_comes_twice_more_50_ms_apart(self, ended: Run, name: str) -> None:
        axis = [row for row in ended.motions if row.name == name]
        firsts = [index for index in range(1, len(axis)) if axis[index].is_zero and axis[index - 1].moves]
        assert firsts
        for index in firsts:
            at = axis[index].at
            repeats = [row.at - at for row in axis[index + 1 : index + 3] if row.is_zero]
            tolerance = LISTENING_JITTER + lost(at - 0.05, at + 0.15)
            assert repeats == [pytest.approx(0.05, abs=tolerance), pytest.approx(0.1, abs=tolerance)]

    def test_busiest_second_has_at_most_20_lines_with_a_rate(self, ended: Run) -> None:
        assert busiest_second(ended.rows) <= 20


@pytest.fixture(scope="module")
def last(ended: Run) -> list[Row]:
    """The lines with rates after the end of the video was put to the pilot."""
    at = ended.recording.stopped_at()
    assert at is not None
    return [row for row in ended.motions if row.at >= at]


class TestEnd:
    def test_zeros_alone_follow_the_end_of_the_video(self, last: list[Row]) -> None:
        assert last
        assert all(row.is_zero for row in last)

    def test_both_axes_rest(self, ended: Run) -> None:
        assert ended.heard[-1].rates == (0.0, 0.0)

    def test_stop_is_the_last_line_half_a_second_after_the_zeros(self, ended: Run, last: list[Row]) -> None:
        assert ended.heard[-1].raw == "stop"
        assert ended.heard[-1].at - last[-1].at >= 0.5 - LISTENING_JITTER - lost(
            last[-1].at - 0.1, last[-1].at
        )


class TestRecording:
    def test_replay_gives_the_same_commands(self, barrelman: pathlib.Path, ended: Run) -> None:
        done = run([barrelman, "replay", ended.path, "--compare"])
        assert done.returncode == 0, done.stderr
        assert "same" in done.stdout

    def test_metrics_reads_it(self, barrelman: pathlib.Path, ended: Run) -> None:
        done = run([barrelman, "metrics", ended.path])
        assert done.returncode == 0, done.stderr
        assert "record" in done.stdout

    def test_export_writes_every_frame_and_the_video(
        self, barrelman: pathlib.Path, ended: Run, tmp_path: pathlib.Path
    ) -> None:
        done = run([barrelman, "export", ended.path, "--output", tmp_path / "exported"])
        assert done.returncode == 0, done.stderr
        assert len((tmp_path / "exported/input_frame.csv").read_text().splitlines()) - 1 == len(
            ended.recording.frames
        )
        assert (tmp_path / "exported/video.mp4").stat().st_size > 0
