"""The radiance of one texel under all lamps: its model of slopes and reflectance, and the fit of it."""
