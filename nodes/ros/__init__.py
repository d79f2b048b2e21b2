"""ROS 2 without ROS: its messages over Zenoh, in the wire form of rmw_zenoh and of the bridge."""
