"""Exit codes, and words of the command line that do not fit together."""

from __future__ import annotations

from app.process import ending

DONE, WRONG_USAGE, BAD_FILE, CANCELLED, MISSING, OUT_OF_MEMORY = 0, 2, 3, ending.CANCELLED, 5, 6

#: Ends of a batch of which some captures failed, and of which all did.
SOME_FAILED, ALL_FAILED = 7, 8
