"""Effects that a scene may call for: a file each, with its rule, its kernels and its source.

The parameters of an effect that is off are neutral: data that skip its branch, so that switching an
effect compiles nothing.
"""
