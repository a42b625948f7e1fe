"""The docks beside every workspace: accuracy, effects, health, jobs and the log."""
