"""A process that plays the synthetic room as a ROS 2 robot: argv = endpoint, dialect, views.

With rmw_zenoh's dialect images, camera_info, tf and latched tf_static carry attachments, and the
static transform is said once, before anybody listens, as a robot's is. Nothing is dropped when the
machine is busy: whoever reads counts the frames.
"""

import json
import sys
import time

import numpy as np
import zenoh
from scipy.spatial.transform import Rotation

from support.room import Room
from support.ros_robot import TF, Robot, stamps_ns

COLOUR, DEPTH = "/cam/color/image_raw", "/cam/aligned_depth_to_color/image_raw"
MOUNT = np.array([0.1, 0.0, 0.3])
PERIOD_S = 0.15
APART_NS = 3_000_000


def main(endpoint: str, dialect: str, views: str) -> None:
    """Publish every view once, then wait to be told to end."""
    config = {"mode": "client", "connect": {"endpoints": [endpoint]}}
    config["timestamping"] = {"enabled": True}
    robot, room = Robot("jazzy", dialect), Room()
    with zenoh.open(zenoh.Config.from_json5(json.dumps(config))) as session:
        cache = zenoh.ext.CacheConfig(max_samples=1)
        latched = zenoh.ext.declare_advanced_publisher(
            session, robot.key("/tf_static", TF), cache=cache, publisher_detection=True
        )
        static = robot.tf((0, "base", "camera", MOUNT, (0, 0, 0, 1)))
        latched.put(robot.data(static), attachment=robot.attachment(0) or None)
        print("ready", flush=True)
        sys.stdin.readline()
        count = int(views)
        for k, stamp_ns in enumerate(stamps_ns(count)):
            for topic, message in messages(robot, room, k, count, stamp_ns):
                key = robot.key(topic, message.__msgtype__)
                attachment = robot.attachment(stamp_ns) or None
                data, block = robot.data(message), zenoh.CongestionControl.BLOCK
                session.put(key, data, attachment=attachment, congestion_control=block)
            time.sleep(PERIOD_S)
        sys.stdin.readline()


def messages(robot: Robot, room: Room, k: int, count: int, stamp_ns: int):
    """Yield topic and message of one view; the pose is that of the base, said by tf."""
    rgb, depth_mm, _, T_world_camera = room.frame(k, count)
    T_camera_base = np.eye(4)
    T_camera_base[:3, 3] = -MOUNT
    T_world_base = T_world_camera @ T_camera_base
    turn = Rotation.from_matrix(T_world_base[:3, :3]).as_quat()
    yield "/cam/color/camera_info", robot.info(room.K, room.size, stamp_ns=stamp_ns)
    yield "/tf", robot.tf((stamp_ns, "map", "base", T_world_base[:3, 3], turn))
    yield COLOUR, robot.image(rgb[..., ::-1], "bgr8", stamp_ns - APART_NS)
    yield DEPTH, robot.image(depth_mm, "16UC1", stamp_ns)


if __name__ == "__main__":
    main(*sys.argv[1:])
