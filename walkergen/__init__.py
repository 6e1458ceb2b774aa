"""walkergen: from a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted.

Units inside are mm, g, s and radians. Start at `walkergen.walker.design.Design`,
`walkergen.walker.solids.build` and `weigh`, and `walkergen.prediction.predict`.
"""

__version__ = "0.1.0"
