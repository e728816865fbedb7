"""What any package needs: checks of the input, units, files, progress, tables, citations."""
