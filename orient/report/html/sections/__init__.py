"""One section of the report per file: rows in, blocks out; None where the project has nothing to show."""
