"""Pure structural dynamics: elements, reduction, time integration, stress; no ROS, no files, no prints."""
