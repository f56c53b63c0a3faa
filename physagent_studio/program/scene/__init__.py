"""S, the scene state: objects, supports, landmarks, materials, camera; and the geometry of shapes.

`state` holds the models of the document; `shapes` and `volumes` answer questions about their forms.
"""
