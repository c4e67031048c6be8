"""A recording, read with the Python package up to its end or to the place where the recording is cut off."""

import json
import pathlib
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import CompressionType, Writer
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


def prolonged(source: pathlib.Path, to: pathlib.Path, length_s: float) -> None:
    """Writes a recording in which the sortie of another one is repeated until it is this long."""
    with source.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = list(reader.iter_decoded_messages(log_time_order=False))
        header, metadata = reader.get_header(), next(iter(reader.iter_metadata()))
    sortie = json.loads(metadata.metadata["summary"])
    period_ns = int(sortie["length_s"] * 1e9)
    repeats = round(length_s * 1e9 / period_ns)
    steps = 1 + max(
        found.decoded_message.step for found in messages if hasattr(found.decoded_message, "step")
    )
    units = sum(found.channel.topic == "/video/unit" for found in messages)
    with to.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(header.profile, header.library)
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for schema, channel, _, _ in messages:
            if schema and channel.topic not in channels:
                if schema.name not in schemas:
                    schemas[schema.name] = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.name]
                )
        for repeat in range(repeats):
            for _, channel, message, decoded in messages:
                if repeat and channel.topic == "/recording/start":
                    continue
                for name, period in (
                    ("captured_ns", period_ns),
                    ("now_ns", period_ns),
                    ("at_ns", period_ns),
                    ("step", steps),
                    ("index", units),
                    ("sequence", units),
                ):
                    if repeat and hasattr(decoded, name):
                        setattr(decoded, name, getattr(decoded, name) + period)
                at = message.log_time + repeat * period_ns
                writer.add_message(channels[channel.topic], at, decoded.SerializeToString(), at)
        sortie["length_s"] *= repeats
        writer.add_metadata(metadata.name, {"summary": json.dumps(sortie)})
        writer.finish()  # type: ignore[no-untyped-call]
