"""Widgets that know nothing of a material: fields, panels, plots, tables, tiles, the theme."""
