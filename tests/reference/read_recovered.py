"""read_recovered.py FOLDER NODE_FOLDER: recovered files as Python's mcap and @mcap/core read them.

FOLDER holds files and what the mcap crate read of each, as `INHAND_KEEP_RECOVERED=FOLDER cargo test --test container
intact_record` leaves them; NODE_FOLDER the node_modules. Each file is read by indexes and as a stream, with checksums."""

import io
import pathlib
import subprocess
import sys
import zlib

from mcap.reader import NonSeekingReader, SeekingReader


def read(reader):
    count = total = 0
    for _, channel, message in reader.iter_messages():
        start = message.sequence.to_bytes(4, "little") + message.log_time.to_bytes(8, "little")
        count += 1
        total += zlib.crc32(channel.topic.encode() + b"\0" + start + message.data)
    return f"{count} {total % 2**32}"


folder = pathlib.Path(sys.argv[1])
files = sorted(folder.glob("*.mcap"))
script = pathlib.Path(__file__).with_suffix(".mjs").resolve()
lines = subprocess.run(["node", script, *(file.resolve() for file in files)], cwd=sys.argv[2], text=True, check=True,
                       stdout=subprocess.PIPE).stdout.splitlines()
wrong = 0
for file, by_node in zip(files, lines, strict=True):
    expected = file.with_suffix(".sum").read_text().strip()
    found = {"@mcap/core": by_node}
    for kind in (SeekingReader, NonSeekingReader):
        try:
            found[kind.__name__] = read(kind(io.BytesIO(file.read_bytes()), validate_crcs=True))
        except Exception as error:  # Whatever a reader dislikes.
            found[kind.__name__] = f"{type(error).__name__}: {error}"
    differ = {reader: said for reader, said in found.items() if said != expected}
    if differ:
        wrong += 1
        print(f"{file}: the mcap crate reads {expected}, others {differ}")
print(f"{len(files)} recovered files, {len(files) - wrong} read alike by the mcap crate, Python and @mcap/core")
sys.exit(bool(wrong or not files))
