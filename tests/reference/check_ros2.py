"""Reads ROS 2 bags with readers that others wrote: rosbags and mcap_ros2.

    pip install rosbags==0.11.9 mcap-ros2-support==0.6.0
    python check_ros2.py BAG...

A bag is an MCAP file of profile ros2, or a folder with metadata.yaml. Every message of every channel is decoded by
both readers, which have to agree on their number; coordinates have to be numbers. Exit code 1 with the reason
otherwise.
"""

import collections
import math
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

LENGTH_FIELDS = ("x", "y", "z", "w")
FINGERS = ["thumb", "index", "middle", "ring", "little"]


def numbers(message):
    """All x, y, z, w of a message, however deep."""
    if isinstance(message, (list, tuple)):
        for part in message:
            yield from numbers(part)
    fields = getattr(message, "__slots__", None) or getattr(message, "__dict__", {})
    for name in fields:
        value = getattr(message, name)
        if name in LENGTH_FIELDS and isinstance(value, float):
            yield value
        elif not isinstance(value, (str, bytes, int, float)):
            yield from numbers(value)


def check_trajectory(message):
    """Five joints whose velocities are the central differences of their positions."""
    assert message.joint_names == FINGERS, message.joint_names

    def seconds(point):
        return point.time_from_start.sec + point.time_from_start.nanosec * 1e-9

    points = message.points
    for point in points:
        assert len(point.transforms) == len(point.velocities) == len(FINGERS)
    for before, at, after in zip(points, points[1:], points[2:]):
        for joint in range(len(FINGERS)):
            for axis in ("x", "y", "z"):
                moved = getattr(after.transforms[joint].translation, axis) - getattr(
                    before.transforms[joint].translation, axis
                )
                velocity = getattr(at.velocities[joint].linear, axis)
                assert abs(moved / (seconds(after) - seconds(before)) - velocity) < 1e-5


def with_mcap_ros2(files):
    counts = collections.Counter()
    for file in files:
        with open(file, "rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            assert reader.get_header().profile == "ros2", f"{file}: profile"
            for channel in reader.get_summary().channels.values():
                assert channel.message_encoding == "cdr", f"{file}: {channel.topic}: encoding"
            for schema, channel, _, message in reader.iter_decoded_messages():
                if schema.name == "trajectory_msgs/msg/MultiDOFJointTrajectory":
                    check_trajectory(message)
                assert all(map(math.isfinite, numbers(message))), f"{channel.topic}: a number"
                counts[channel.topic] += 1
    return counts


def with_rosbags(bag):
    counts = collections.Counter()
    # With the definitions in the bag: no type has to be installed.
    with AnyReader([bag], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
            counts[connection.topic] += 1
    # Definitions of ROS itself have the same layout: one message of each topic shows that.
    seen = set()
    installed = get_typestore(Stores.ROS2_HUMBLE)
    with Reader(bag) as reader:
        for connection, _, data in reader.messages():
            if connection.topic not in seen and connection.msgtype in installed.fielddefs:
                installed.deserialize_cdr(data, connection.msgtype)
                seen.add(connection.topic)
    return counts


def main(bags):
    for bag in map(Path, bags):
        files = sorted(bag.glob("*.mcap")) if bag.is_dir() else [bag]
        counts = with_mcap_ros2(files)
        assert counts, f"{bag}: no message"
        by_rosbags = with_rosbags(bag)
        assert counts == by_rosbags, f"{bag}: {counts} and {by_rosbags}"
        print(f"{bag}: RESULT {sum(counts.values())} messages on {len(counts)} topics")


if __name__ == "__main__":
    main(sys.argv[1:])
