"""Crowds of thousands in a plane: walkers from their cards, moved by LAMMPS.

`crowd_checks.make_crowd` checks the request and `crowd.input_files` writes the input. `crowd.simulate` runs it and
reads the positions.
"""
