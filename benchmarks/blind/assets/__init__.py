"""Assets of the sealed cases: wings of other meshes and another code, and what may be wrong with them."""
