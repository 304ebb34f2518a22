"""Pure functions: no ROS, no prints; the only file read is the package's own S-N table."""
