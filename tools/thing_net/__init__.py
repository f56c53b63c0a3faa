"""The network of `reconstruction.masks.thing_map`: what it learns from, and its fitting."""
