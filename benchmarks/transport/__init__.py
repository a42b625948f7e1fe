"""Measurements of transport and of drawing: bakes, relighting, frames, rays and plans."""
