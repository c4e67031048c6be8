"""Another participant of a DDS domain: Cyclone DDS, which shares no code with the program. And a network of
loopback alone, with multicast, in which no message leaves the machine."""

import contextlib
import ctypes
import os
import socket
import struct
import time
from collections.abc import Iterator
from typing import Any, Self

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

import ros2_types as ros
from conftest import skip
from machine import PATIENCE_S, wait_until
from process import run

# Longer than the node waits for the console.
CALL_AGAIN_S = 10.0
CLONE_NEWNET, ETH_P_ALL = 0x40000000, 3
# PID_RELATED_SAMPLE_IDENTITY of DDS-RPC, and its length.
RELATED_SAMPLE = struct.pack("<HH", 0x0083, 24)
LOOPBACK = """<CycloneDDS><Domain Id="any"><General>
<Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces><AllowMulticast>true</AllowMulticast>
</General></Domain></CycloneDDS>"""
# ROS 2 writes the first form of CDR.
CDR = Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False)
SENSOR_DATA = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(200), CDR)
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(200), CDR)
TOPICS: dict[str, tuple[str, Any, Qos]] = {
    "detections": ("rt/barrelman/detections", ros.Detection2DArray, SENSOR_DATA),
    "camera_rate": ("rt/barrelman/camera_rate", ros.TwistStamped, SENSOR_DATA),
    "picture": ("rt/barrelman/image/compressed", ros.CompressedImage, SENSOR_DATA),
    "boat": ("rt/barrelman/boat/fix", ros.NavSatFix, SENSOR_DATA),
    "marks": ("rt/barrelman/marks", ros.NavSatFix, RELIABLE),
    "diagnostics": ("rt/diagnostics", ros.DiagnosticArray, RELIABLE),
}


@contextlib.contextmanager
def network_of_loopback() -> Iterator[None]:
    """Moves this thread, and whatever it starts, into a network of its own, with the domain of the peers."""
    libc = ctypes.CDLL(None, use_errno=True)
    before = os.open("/proc/thread-self/ns/net", os.O_RDONLY)
    if libc.unshare(CLONE_NEWNET):
        skip(f"no network of its own: {os.strerror(ctypes.get_errno())}")
    try:
        for words in ("link set lo up multicast on", "route add 224.0.0.0/4 dev lo"):
            done = run(["ip", *words.split()])
            assert done.returncode == 0, done.stderr
        # Once: a peer that a failed test keeps would hold the domain, and the next peer could not make it.
        domain = Domain(0, LOOPBACK)
        yield
        del domain
    finally:
        libc.setns(before, CLONE_NEWNET)
        os.close(before)


class Listener:
    """All packets of loopback, from the beginning of the block on."""

    def __enter__(self) -> Self:
        self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
        self.socket.bind(("lo", 0))
        self.socket.setblocking(False)
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def packets(self) -> list[bytes]:
        """The packets since the last call."""
        found = []
        with contextlib.suppress(BlockingIOError):
            while True:
                found.append(self.socket.recv(1 << 16))
        return found


def names_call(packet: bytes, writer: bytes, number: int) -> bool:
    """Whether the head of a packet says that its content answers this call, as Fast DDS reads it: writer and
    number (high half first) after the name and the length of the parameter."""
    return RELATED_SAMPLE + writer + struct.pack("<iI", 0, number) in packet


class Peer:
    """Subscribers to all topics, or to some, and callers of the services."""

    def __init__(self, *topics: str, is_cyclone: bool = False) -> None:
        self.participant = DomainParticipant(0)
        self.readers = {name: self._reader(*TOPICS[name]) for name in topics or TOPICS}
        self.is_cyclone = is_cyclone
        # At once: the node is to know the readers of its answers before the first call.
        self.calls = {service: self._service(service) for service in ("engage", "stop")}
        self.number = 0

    def _reader(self, name: str, message: Any, qos: Qos) -> Any:
        return DataReader(self.participant, Topic(self.participant, name, message), qos)

    def close(self) -> None:
        self.readers.clear()
        self.calls.clear()
        del self.participant

    def take(self, name: str) -> list[tuple[int, Any]]:
        """New messages of a topic, with the time of reading, nanoseconds since 1970."""
        found = self.readers[name].take(N=200)
        now = time.time_ns()
        return [(now, message) for message in found]

    def collect(self, name: str, count: int, seconds: float = PATIENCE_S) -> list[tuple[int, Any]]:
        """So many messages of a topic from now on."""
        self.take(name)
        found: list[tuple[int, Any]] = []

        def enough() -> bool:
            found.extend(self.take(name))
            return len(found) >= count

        wait_until(enough, lambda: f"{count} messages of {name}, {len(found)} came", seconds, 0.002)
        return found

    def call(self, service: str) -> tuple[bool, str]:
        """Calls a service in the form of the chosen middleware. Returns success and message.

        A node that does not know writer or reader yet drops request or answer: the call is made again.
        """
        writer, reader = self.calls[service]
        reader.take(N=200)
        self.number += 1
        # The upper half of the caller's name is that of the writer; the lower half is the caller's choice.
        caller, number = 0x1122334455667788, self.number
        request = ros.CycloneTriggerRequest(caller, number, 0) if self.is_cyclone else ros.TriggerRequest(0)
        written = 0.0

        def answers() -> list[Any]:
            nonlocal written
            if time.monotonic() > written + CALL_AGAIN_S:
                writer.write(request)
                written = time.monotonic()
            return list(reader.take(N=1))

        answer = wait_until(answers, f"the answer of {service}", pause=0.001)[0]
        if self.is_cyclone:
            assert (answer.caller, answer.number) == (caller, number), answer
        return answer.success, answer.message

    def _service(self, service: str) -> tuple[Any, Any]:
        request = ros.CycloneTriggerRequest if self.is_cyclone else ros.TriggerRequest
        response = ros.CycloneTriggerResponse if self.is_cyclone else ros.TriggerResponse
        path = f"barrelman/{service}"
        topic = Topic(self.participant, f"rq/{path}Request", request)
        writer = DataWriter(self.participant, topic, RELIABLE)
        reader = self._reader(f"rr/{path}Reply", response, RELIABLE)
        wait_until(
            lambda: writer.get_matched_subscriptions() and reader.get_matched_publications(),
            f"the service {service}",
        )
        return writer, reader
