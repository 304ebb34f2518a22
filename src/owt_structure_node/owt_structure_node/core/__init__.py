"""Pure structural dynamics: beam elements, reduction, time integration, stress; no ROS, no files, no prints."""
