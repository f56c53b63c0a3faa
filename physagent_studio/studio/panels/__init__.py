"""What each panel shows, as plain JSON values made from a snapshot and a view. No panel acts."""
