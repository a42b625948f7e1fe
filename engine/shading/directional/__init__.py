"""Light from every side: photographs of lamps at any azimuth as a few planes, with the error of each representation."""
