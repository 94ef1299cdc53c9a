# Meshes a CAD model as the program gmsh does with the same arguments, and puts its
# faces into groups by the names and colours that the model gives them.
import sys

import gmsh

arguments = sys.argv[1:]
out = arguments[arguments.index("-o") + 1]
gmsh.initialize(["gmsh", *arguments[1:]])
gmsh.open(arguments[0])
groups = {}
for dimension in (2, 3):
    for _, tag in gmsh.model.getEntities(dimension):
        name = gmsh.model.getEntityName(dimension, tag).rsplit("/", 1)[-1]
        red, green, blue, opaque = gmsh.model.getColor(dimension, tag)
        names = {name} - {""}
        # What has no colour is transparent to Gmsh.
        if dimension == 2 and opaque:
            names.add(f"colour #{red:02x}{green:02x}{blue:02x}")
        for name in names:
            groups.setdefault((dimension, name), []).append(tag)
for (dimension, name), tags in sorted(groups.items()):
    gmsh.model.addPhysicalGroup(dimension, tags, name=name)
gmsh.model.mesh.generate(2)
gmsh.write(out)
gmsh.finalize()
