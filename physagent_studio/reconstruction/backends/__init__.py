"""What comes from outside: mesh files and their textures, and the files of learned models."""
