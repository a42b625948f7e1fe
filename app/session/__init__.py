"""Data of one run and of one user: the working folder, settings and the machine profile."""
