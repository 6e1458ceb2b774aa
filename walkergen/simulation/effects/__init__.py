"""Effects: what a scene may call for; one file each, with its verdict, its kernels and its source.

An effect that is off is None in what kernels read, which leaves nothing of it in the compiled code.
"""
