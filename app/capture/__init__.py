"""The Capture workspace: photographs, lights, control points, import."""
