"""Reads out.mcap by rosbags and by mcap, and compares it with map0.npy and so on: run by cli/tests/command/sources/record.rs in its folder."""

from pathlib import Path

import numpy as np
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader

FOCAL, BASELINE, LEAST = 50.0, 0.2, 0.0
maps = [np.load(f"map{number}.npy") for number in range(3)]


def check(number, disparity, depth, points):
    """The messages of a pair, whichever package has read them."""
    for header in (disparity.header, disparity.image.header, depth.header, points.header):
        assert (header.stamp.sec, header.frame_id) == (1_700_000_000, "camera"), header
        assert header.stamp.nanosec == number * 100_000_000, header
    assert (disparity.image.encoding, disparity.image.width, disparity.image.height) == ("32FC1", 48, 30)
    assert (disparity.f, disparity.min_disparity, disparity.max_disparity, disparity.delta_d) == (FOCAL, 0.0, 15.0, 0.0625)
    assert abs(disparity.t - BASELINE) < 1e-7
    assert (disparity.valid_window.width, disparity.valid_window.height) == (48, 30)
    found = np.frombuffer(bytes(disparity.image.data), "<f4").reshape(30, 48)
    expected = maps[number]
    assert np.array_equal(np.where(found < LEAST, np.nan, found), expected, equal_nan=True)
    metres = np.frombuffer(bytes(depth.data), "<f4").reshape(30, 48)
    with np.errstate(divide="ignore"):
        wanted = np.where(expected > 0, FOCAL * BASELINE / expected, np.nan)
    assert np.allclose(metres, wanted, rtol=1e-6, atol=1e-6, equal_nan=True)
    assert [field.name for field in points.fields] == ["x", "y", "z", "rgb"]
    assert [field.offset for field in points.fields] == [0, 4, 8, 12] and points.point_step == 16
    cloud = np.frombuffer(bytes(points.data), "<f4").reshape(-1, 4)
    assert points.height == 1 and points.width == len(cloud) == np.isfinite(wanted).sum()
    assert np.allclose(cloud[:, 2], metres[np.isfinite(metres)])


def by_mcap():
    topics = {}
    for message in read_ros2_messages("out.mcap"):
        topics.setdefault(message.channel.topic, []).append(message.ros_msg)
    return topics


def by_rosbags():
    topics = {}
    with AnyReader([Path("out.mcap")]) as reader:
        for connection, _, data in reader.messages():
            topics.setdefault(connection.topic, []).append(reader.deserialize(data, connection.msgtype))
    return topics


for topics in (by_mcap(), by_rosbags()):
    assert sorted(topics) == ["/stereo/depth", "/stereo/disparity", "/stereo/points2"], sorted(topics)
    for number in range(3):
        check(number, topics["/stereo/disparity"][number], topics["/stereo/depth"][number], topics["/stereo/points2"][number])
