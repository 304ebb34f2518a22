"""Case runs and load-case campaigns, without ROS."""
