"""The 3D view: what the snapshot's scene and rollouts look like in viser."""
