"""The edge to ROS 2: the only place where messages meet arrays."""
