"""From displacements, stress and wave components to lines, triangles and colours. No ROS in here."""
