"""Plays a file live to a client of its own and counts what arrives against the file.

    python3 -m venv .live && .live/bin/pip install websockets mcap
    .live/bin/python measure.py INHAND FILE.mcap [SECONDS [SPEED]]

Subscribes to every channel of `inhand play FILE --speed SPEED` for SECONDS of it (60), compares the number
of messages of each topic, their log times and their bytes with those of the file, and prints the CPU time
that the server took in that stretch. Linux only; exit code 0 when nothing is missing and the server took
less than a tenth of one core.
"""

import asyncio
import hashlib
import json
import os
import signal
import struct
import subprocess
import sys
import time
from collections import defaultdict

import websockets
from mcap.reader import make_reader


def cpu_s(pid):
    """User and system time of a process, seconds."""
    with open(f"/proc/{pid}/stat") as stat:
        fields = stat.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid):
    with open(f"/proc/{pid}/status") as status:
        peak = next(line for line in status if line.startswith("VmHWM"))
    return int(peak.split()[1]) / 1000


async def watch(address, pid, seconds, speed):
    """What arrives of `seconds`: topic -> [(log time, digest)], and the CPU time that it took."""
    seen = defaultdict(list)
    async with websockets.connect(
        address, subprotocols=["foxglove.sdk.v1"], max_size=None, compression=None
    ) as socket:
        topics = {}
        first = None
        while True:
            message = await socket.recv()
            if isinstance(message, str):
                said = json.loads(message)
                if said["op"] == "serverInfo":
                    start = said["dataStartTime"]
                    first = start["sec"] * 10**9 + start["nsec"]
                elif said["op"] == "advertise":
                    topics = {c["id"]: c["topic"] for c in said["channels"]}
                    wanted = [{"id": id, "channelId": id} for id in topics]
                    before, then = cpu_s(pid), time.monotonic()
                    await socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
                else:
                    sys.exit(f"the server says {said}")
            elif message[0] == 1:
                id, log_time = struct.unpack_from("<IQ", message, 1)
                if log_time >= first + seconds * speed * 10**9:
                    break
                seen[topics[id]].append((log_time, hashlib.sha256(message[13:]).digest()))
        took = (cpu_s(pid) - before, time.monotonic() - then)
    return first, seen, took


def main():
    inhand, file = sys.argv[1:3]
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 60.0
    speed = float(sys.argv[4]) if len(sys.argv) > 4 else 1.0
    command = [inhand, "play", file, "--port", "0", "--speed", str(speed)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        address = server.stdout.readline().strip()
        first, seen, (cpu, wall) = asyncio.run(watch(address, server.pid, seconds, speed))
        peak = memory_mb(server.pid)
    finally:
        server.send_signal(signal.SIGINT)
        code = server.wait()
    expected = defaultdict(list)
    with open(file, "rb") as stream:
        end = int(first + seconds * speed * 10**9)
        for _, channel, message in make_reader(stream).iter_messages(ending_before=end):
            digest = hashlib.sha256(message.data).digest()
            expected[channel.topic].append((message.log_time, digest))
    missing = 0
    for topic, sent in sorted(expected.items()):
        got = sorted(seen[topic])
        same = got == sorted(sent)
        missing += not same
        print(f"{topic:<32} {len(got):>8} of {len(sent):>8} {'' if same else 'DIFFERENT'}")
    messages = sum(map(len, seen.values()))
    share = 100 * cpu / wall
    print(f"{messages} messages, {messages / wall:.0f} a second, in {wall:.1f} s")
    print(f"server: {cpu:.2f} s of CPU, {share:.1f} % of one core, {peak:.0f} MB at most, exit code {code}")
    return 1 if missing or share >= 10 or code != 0 else 0


if __name__ == "__main__":
    sys.exit(main())
