"""A recording, read with the Python package up to its end or to the place where the recording is cut off."""

import json
import pathlib
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader
from mcap_protobuf.decoder import DecoderFactory


class Recording:
    """The messages of a recording by their topic. The first one has its start on the machine's clock in
    `monotonic_ns`."""

    def __init__(self, path: pathlib.Path) -> None:
        self.topics: dict[str, list[Any]] = {}
        self.schemas: dict[str, str] = {}
        self.cut: Exception | None = None
        with path.open("rb") as file:
            try:
                reader = NonSeekingReader(file, decoder_factories=[DecoderFactory()])
                for schema, channel, _, decoded in reader.iter_decoded_messages(log_time_order=False):
                    self.topics.setdefault(channel.topic, []).append(decoded)
                    self.schemas[channel.topic] = schema.name if schema else ""
            except (McapError, EOFError, ValueError) as error:
                self.cut = error
        start = self["/recording/start"]
        self.start: float | None = start[0].monotonic_ns / 1e9 if start else None

    def __getitem__(self, topic: str) -> list[Any]:
        return self.topics.get(topic, [])

    def at(self, ns: int) -> float:
        """Converts a time of the recording to the machine's clock, seconds."""
        assert self.start is not None
        return self.start + ns / 1e9

    @property
    def outcomes(self) -> list[Any]:
        return self["/outcome"]

    @property
    def frames(self) -> list[Any]:
        return self["/input/frame"]

    def requests(self) -> list[tuple[int, dict[str, Any]]]:
        """The requests, each with the time of its step in nanoseconds."""
        return [(message.now_ns, json.loads(message.request)) for message in self["/input/request"]]

    def stopped_at(self) -> float | None:
        """The time of the first stop on the machine's clock, seconds; None without one."""
        return next(
            (self.at(now_ns) for now_ns, request in self.requests() if request["kind"] == "stop"), None
        )

    def stream(self, path: pathlib.Path) -> pathlib.Path:
        """Writes the stored video to a file."""
        path.write_bytes(b"".join(message.data for message in self["/video"]))
        return path
