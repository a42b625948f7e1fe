"""Work beside the window: a thread for each job, lanes that decide when it runs, and jobs of which the last counts."""
