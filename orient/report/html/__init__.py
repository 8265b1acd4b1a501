"""The report as one page: plain sections built from rows, laid out by one template."""
