"""Side-by-side timings; equality with the alternative is checked before anything is timed."""
