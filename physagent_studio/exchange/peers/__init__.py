"""Files of the peers' releases, read as cases and schedules; what they say is never run."""
