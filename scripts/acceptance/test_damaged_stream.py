"""A stream of H.265 that is damaged for a long time: the run goes on, within its memory, and sees it mended.

Packets of a camera are damaged on their way: bits, lengths, order, headers, whole packets.
"""

import pathlib
import random
import socket
import threading
import time

import pytest

from camera import Camera
from client import Program
from conftest import Check
from machine import poll
from process import end, free_port
from test_media_faults import media_processes

pytestmark = [pytest.mark.alone, pytest.mark.clocked]

MOST_MB = 300.0
RETURNS_WITHIN = 20.0
# Bytes of an RTP header (RFC 3550) and of what says how the payload is cut (RFC 7798).
HEADER_BYTES = 15


class DamagingRelay:
    """Passes datagrams from one port to another, and damages them while `is_damaging`."""

    def __init__(self, near: int, far: int, seed: int) -> None:
        self.is_damaging = False
        self.damaged = 0
        self.near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.near.bind(("127.0.0.1", near))
        self.far = ("127.0.0.1", far)
        self.chance = random.Random(seed)
        threading.Thread(target=self._pass, daemon=True).start()

    def _pass(self) -> None:
        out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        while True:
            packet = self.near.recv(65536)
            for sent in self.damage(packet) if self.is_damaging else [packet]:
                out.sendto(sent, self.far)

    def damage(self, packet: bytes) -> list[bytes]:
        chance = self.chance
        if chance.random() > 0.2:
            return [packet]
        self.damaged += 1
        changed = bytearray(packet)
        match chance.randrange(6):
            case 0:
                return []
            case 1:
                return [packet, packet]
            case 2:
                return [packet[: chance.randrange(len(packet))]]
            case 3:
                return [chance.randbytes(chance.randrange(1, 1400))]
            case 4:
                changed[chance.randrange(min(HEADER_BYTES, len(changed)))] = chance.randrange(256)
            case _:
                for _ in range(chance.randrange(1, 20)):
                    changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
        return [bytes(changed)]


def memory_mb(process: int) -> float:
    """Proportional memory of a process and of its processes of GStreamer."""
    total = 0.0
    for each in [process, *media_processes(process)]:
        try:
            rows = pathlib.Path(f"/proc/{each}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += next(float(row.split()[1]) for row in rows if row.startswith("Pss:")) / 1024
    return total


@pytest.mark.parametrize("seconds", [20, pytest.param(600, marks=pytest.mark.long)])
def test_damaged_stream_ends_neither_the_run_nor_its_memory(
    barrelman: pathlib.Path, check: Check, seconds: int
) -> None:
    far = free_port()
    with Camera("rtp", "h265") as camera:
        relay = DamagingRelay(camera.port, far, seed=seconds)
        program = Program(barrelman, "run", "--no-record", "--video", f"udp://127.0.0.1:{far}?codec=h265")
        program.wait(lambda status: status["video"]["state"] == "up", "the video")
        relay.is_damaging = True
        until, most, processes = time.monotonic() + seconds, 0.0, set[int]()
        while time.monotonic() < until and program.child.poll() is None:
            most = max(most, memory_mb(program.child.pid))
            processes |= set(media_processes(program.child.pid))
            time.sleep(0.5)
        check("the run goes on", program.child.poll() is None, program.errors.text()[-500:])
        relay.is_damaging = False
        is_back = poll(
            lambda: (video := program.status()["video"])["state"] == "up" and video["fps"] > 15,
            RETURNS_WITHIN,
            0.5,
        )
        check("the mended stream is seen", is_back, program.status()["video"])
        code = end(program.child)
    check("the run ends with exit 0", code == 0, program.errors.text()[-300:])
    measured = f"{most:.0f} MB, {relay.damaged} damaged packets, {len(processes)} processes"
    check("memory is bounded", most <= MOST_MB, measured)
    check("packets were damaged", relay.damaged > 2 * seconds, relay.damaged)
