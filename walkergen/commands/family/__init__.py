"""The job `family`: solids, STL, plates, predicted speeds and pictures of one design."""
