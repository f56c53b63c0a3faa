"""Programs as text: strict YAML in, readable YAML out, edits that touch only their own lines.

`document` is the door; `diff` tells two programs apart hunk by hunk.
"""
