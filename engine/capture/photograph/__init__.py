"""One photograph as linear radiance: decoding, demosaicing, exposure and calibration."""
