"""Distant and near light: environment maps, cube maps, the sky, the sun, lamps, and light prefiltered for lobes."""
