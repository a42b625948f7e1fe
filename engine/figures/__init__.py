"""Plots, contact sheets and figures that are files."""
