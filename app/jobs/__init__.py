"""Work beside the window: one thread for each job, and jobs of which only the newest counts."""
