pytest_plugins = ["tests.promises"]
