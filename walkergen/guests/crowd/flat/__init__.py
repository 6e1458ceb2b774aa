"""Crowds of thousands in a plane: walkers known by their cards, moved by LAMMPS.

`doors.crowd` checks what is asked, `crowd.files` writes its input, `crowd.simulate` runs it and reads back
where everybody was.
"""
