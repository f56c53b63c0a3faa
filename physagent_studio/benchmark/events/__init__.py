"""Events run end to end: `bench`, as references and a viewer see them; `words` to a planner."""
