"""Clicks, boxes and strokes → masks, with other candidates for each thing.

In: the image and the marks of each thing. Out: per thing the ranked candidate masks, of which the
first is used until a person chooses. `segmenter` is the door; `thing_map`
says where the thing is, `box_drafts` makes drafts there, `ranking` scores them and `choice` decides
their order, to which `learned_offers` adds what a fetched network found; `sureness` says how likely
the first is right.
"""
