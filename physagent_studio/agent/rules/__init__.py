"""The embedded agent: rules, mechanics and search; needs nothing but the program's own rooms."""
