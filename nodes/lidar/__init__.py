"""A LiDAR with a colour camera beside it."""
