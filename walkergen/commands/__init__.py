"""Commands: a folder for each, with its request, what it makes and its report."""
