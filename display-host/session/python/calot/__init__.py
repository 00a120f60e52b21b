"""Reads the sessions of Calot, on top of the official MCAP reader.

    import calot
    session = calot.Session("out/session.mcap")
    session.frame("/tool").plot("time_s", "force_n")

A session holds poses, force and events. The table of every tick comes from
`calot export`; `tables` reads it.
"""

from pathlib import Path

import pandas
from google.protobuf.message import Message
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

__all__ = ["Session", "tables"]


class Session:
    """A recorded session: a file, or the folder of `calot run --out DIR`."""

    def __init__(self, path):
        path = Path(path)
        self.path = path / "session.mcap" if path.is_dir() else path
        self.info = {}
        """The session's description: scene, program, task, end."""
        with open(self.path, "rb") as file:
            reader = make_reader(file)
            for record in reader.iter_metadata():
                self.info[record.name] = dict(record.metadata)
            summary = reader.get_summary()
        self.topics = {}
        """Number of messages of each topic."""
        if summary is not None and summary.statistics is not None:
            counts = summary.statistics.channel_message_counts
            for number, channel in summary.channels.items():
                self.topics[channel.topic] = counts.get(number, 0)
        self._begin_ns = next((at for at, _ in self.messages("/setup")), None)

    def messages(self, topic):
        """Yields (time since 1970 in ns, message) for each message of a topic.

        Topics that only Calot reads (/setup, /inputs, /course) give bytes.
        """
        with open(self.path, "rb") as file:
            factory = DecoderFactory()
            decoders = {}
            for schema, channel, message in make_reader(file).iter_messages(topics=[topic]):
                if channel.id not in decoders:
                    encoding = channel.message_encoding
                    decoders[channel.id] = factory.decoder_for(encoding, schema)
                decode = decoders[channel.id]
                yield message.log_time, decode(message.data) if decode else message.data

    def frame(self, topic):
        """A table of a topic's messages: one row a message, one column a field.

        A field in a message becomes a column such as `force_xyz_n.x`, and
        `time_s` counts from the session's first tick, as in the tables of
        `calot export`.
        """
        rows = []
        for time_ns, message in self.messages(topic):
            if isinstance(message, bytes):
                raise ValueError(f"{topic} is packed for Calot alone; `calot export` writes its tables")
            row = {"time_unix_ns": time_ns}
            _flatten(message, "", row)
            rows.append(row)
        table = pandas.DataFrame(rows)
        if not table.empty:
            begin_ns = self._begin_ns or table.time_unix_ns.iloc[0]
            seconds = (table.time_unix_ns - begin_ns) / 1e9
            table.insert(0, "time_s", seconds)
        return table

    def stages(self):
        """A table of the ticks' times: one row a tick, times in ns.

        `motion_to_force_ns` is missing in ticks without a new sample of the device.
        """
        parts = []
        for _, message in self.messages("/stages"):
            columns = {}
            for field in message.DESCRIPTOR.fields:
                if field.name != "first_tick":
                    columns[field.name] = list(getattr(message, field.name))
            part = pandas.DataFrame(columns)
            part.insert(0, "tick", range(message.first_tick, message.first_tick + len(part)))
            parts.append(part)
        if not parts:
            return pandas.DataFrame()
        table = pandas.concat(parts, ignore_index=True)
        felt = table["motion_to_force_ns"]
        table["motion_to_force_ns"] = felt.where(felt > 0)
        return table


def _flatten(message, before, row):
    """Puts the fields of a message into `row`. Lists are left as they are."""
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        name = before + field.name
        if isinstance(value, Message):
            _flatten(value, name + ".", row)
        elif field.enum_type is not None and isinstance(value, int):
            known = field.enum_type.values_by_number.get(value)
            row[name] = known.name.lower() if known else value
        else:
            row[name] = value


def tables(folder):
    """The tables of `calot export`, CSV or Parquet, by name."""
    found = {}
    for path in sorted(Path(folder).iterdir()):
        if path.suffix == ".parquet":
            found[path.stem] = pandas.read_parquet(path)
        elif path.suffix == ".csv" and path.stem not in found:
            found[path.stem] = pandas.read_csv(path)
    if "ticks" not in found:
        raise FileNotFoundError(f"{folder}: no ticks.csv or ticks.parquet; run `calot export` first")
    return found
