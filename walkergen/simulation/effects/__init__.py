"""Effects that a scene may call for: a file each, with its verdict, its kernels and its source.

The parameters of an effect that is off are None, which leaves nothing of it in the compiled code.
"""
