"""What each intent does: a change of the view or a command; `actions` is the door."""
