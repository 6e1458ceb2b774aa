"""The job `export`: single walkers as files of any format."""
