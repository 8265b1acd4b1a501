"""Starts commands by forking a process that has everything imported: a kill then hits the work, not the imports.

Reads lines of JSON arguments from standard input, answers with the process number of the command, and with the
exit code when it has ended. `python -m tests.faults.kill_server`.
"""

import json
import os
import sys


def serve() -> None:
    import orient.intake.project_folder
    import orient.pipeline.bl
    import orient.pipeline.covariance
    import orient.pipeline.digitize
    import orient.pipeline.refine
    import orient.pipeline.resection
    import orient.pipeline.topocentric
    import orient.report.runs  # noqa: F401
    from orient.cli.main import run

    print("ready", flush=True)
    for line in sys.stdin:
        if child := os.fork():
            print(child, flush=True)
            _, status = os.waitpid(child, 0)
            print(os.waitstatus_to_exitcode(status), flush=True)
        else:
            sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115
            sys.argv = ["orient", *json.loads(line)]
            run()


if __name__ == "__main__":
    serve()
