"""Access to image stacks: which photographs there are, decoding, calibration, alignment and the report."""
