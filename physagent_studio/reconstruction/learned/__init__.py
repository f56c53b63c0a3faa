"""Networks of OpenCV's model zoo, run by OpenCV itself, where a person has fetched their files.

`zoo` knows the files and their hashes, `network` runs one, `efficient_sam` makes masks of clicks
and boxes, `lama` fills holes, `at_hand` is the door: what is there, what was used, what failed.
Nothing here opens a connection. Without the files nothing here acts.
"""
