"""walkergen: from a leg tilt to 3D-printed walkers that run on a vibrating plate as predicted.

Units inside are mm, g, s and radians. Start at `walkergen.design.Design`, `walkergen.solids.build`,
`walkergen.solids.weigh` and `walkergen.prediction.predict`.
"""

__version__ = "0.1.0"
