"""`physagent bench physics`: the engine against closed forms; `bench` is the door."""
