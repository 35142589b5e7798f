"""Values of the two ROS 2 recordings of the corpus by the readers of others.

    python ros2.py CORPUS > ros2.json

with mcap 1.6 and mcap-ros2-support 0.6, which decode by the schemas in the files.
"""

import json
import sys

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


def xyz(v):
    return [v.x, v.y, v.z]


def nanos(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def pose(p):
    o = p.orientation
    return xyz(p.position) + [o.x, o.y, o.z, o.w]


def summary(things, stamps):
    """First and last value of each thing, and the samples at which it is not there."""
    return {
        name: {
            "missing": [k for k, t in enumerate(stamps) if t not in at],
            "first": at[min(at)],
            "last": at[max(at)],
        }
        for name, at in sorted(things.items())
    }


def read(path):
    markers, bodies, stamps, delays = {}, {}, set(), []
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, record, message in reader.iter_decoded_messages():
            time = nanos(message)
            stamps.add(time)
            delays.append(record.log_time - time)
            if schema.name == "mocap4r2_msgs/msg/Markers":
                for marker in message.markers:
                    markers.setdefault(marker.marker_name, {})[time] = xyz(marker.translation)
            elif schema.name == "mocap4r2_msgs/msg/RigidBodies":
                for body in message.rigidbodies:
                    bodies.setdefault(body.rigid_body_name, {})[time] = pose(body.pose)
            else:
                name = channel.topic.split("/")[2]
                # In this recording fingertips are poses without a rotation.
                if name in ("Hand", "Object"):
                    bodies.setdefault(name, {})[time] = pose(message.pose)
                else:
                    markers.setdefault(name, {})[time] = xyz(message.pose.position)
    stamps = sorted(stamps)
    steps = {b - a for a, b in zip(stamps, stamps[1:])}
    return {
        "start_unix_nanos": stamps[0],
        "samples": len(stamps),
        "step_nanos": sorted(steps),
        "delay_nanos": [min(delays), max(delays)],
        "markers": summary(markers, stamps),
        "bodies": summary(bodies, stamps),
    }


if __name__ == "__main__":
    folder = sys.argv[1] + "/mcap/ros2_mocap/"
    files = ["mocap4r2.mcap", "pose_stamped.mcap"]
    print(json.dumps({name: read(folder + name) for name in files}, indent=1))
