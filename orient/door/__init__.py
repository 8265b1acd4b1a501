"""The door from Python: what `import orient` gives. Imported name by name, so that each costs only what it uses."""
