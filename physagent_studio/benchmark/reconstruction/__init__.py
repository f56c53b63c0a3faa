"""`physagent bench reconstruction`: synthetic truth and photographs; `bench` is the door."""
