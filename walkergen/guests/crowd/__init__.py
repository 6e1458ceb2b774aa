"""Crowds: many walkers in a dish, in space or by cards in a plane, and what they do together.

Who is in a crowd (`members`) makes a job (`runs`), which `make` simulates: walkers `in_space` (`space`), or cards
`in_plane` (`flat`, by LAMMPS). Films of it, or of printed walkers (`filmed`), are measured by `statistics`; `tables`,
`figures` and `report` say what came out, `files` and `movie` show every run. `cards` measures the walker alone of
which a flat crowd is made; `points` is a crowd as a point of a sweep.
"""
