"""Data of one run and of one person: the working folder, settings and the machine profile."""
