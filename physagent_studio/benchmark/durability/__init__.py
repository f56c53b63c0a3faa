"""What sessions survive: kills, a failing disk, several clients, ten thousand rounds."""
