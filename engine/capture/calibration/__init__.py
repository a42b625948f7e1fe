"""The rig of a capture from its photographs: distance of lamps, intensities, room light, and motion of the camera."""
