"""A material as one file that other programs can show."""
