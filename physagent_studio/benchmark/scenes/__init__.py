"""Random pictures of many-coloured things of many parts, with exact masks.

In: a seed. Out: a picture like a photograph, with a name, a mask, a click and a box for each thing.
`scene` is the door. `things.yaml` lists the things; `forms` makes their meshes, `catalogue` builds
and places them, `paints` colours them, `rooms` draws what is around, `lights` shades, `pictures`
puts it together. Seeds 0 to 999 are there to build with, 1000 to 1999 for the ledger; those from
2000 on are for measuring alone.
"""

from physagent_studio.benchmark.scenes.pictures import Pictured, scene
