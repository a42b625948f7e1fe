"""The fast part of the catalogue of hard cases, run on the user's machine: measured, bound, pass."""
