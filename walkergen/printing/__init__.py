"""From meshes to what a printer takes: printers, files, plates."""
