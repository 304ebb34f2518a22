"""The command line, launch files and parameter files."""
