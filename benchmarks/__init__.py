"""Speed of orient as ratios to what a user could pick instead: `make bench`."""
