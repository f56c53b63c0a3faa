"""Parts of a thing that have another colour: stems, necks, poles, handles, cuffs.

In: a draft mask and its surroundings. Out: the mask with the parts whose edges, contact and colours
speak for them. `attached` is the door.
"""
