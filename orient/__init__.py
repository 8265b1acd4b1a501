"""orient: the orientation of one frame photograph, with its whole proof in one SQLite file."""

__version__ = "0.1.0"
