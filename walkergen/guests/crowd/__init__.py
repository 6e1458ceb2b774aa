"""Crowds: the collective motion of many walkers in a dish, in space or from cards in a plane.

A request reads a `population` and `make` simulates it: walkers `in_space` (`space`), or cards `in_plane` (`flat`, with
LAMMPS). `statistics` measures these films and films of printed walkers (`film_analysis`). `tables`, `figures` and
`report` show the results; `files` and `movie` show every run. `cards` measures the single walker for a flat crowd.
`points` is a crowd as a point of a sweep.
"""
