"""Runs the tasks of `phototaxis farm plan` by the Python package hyperqueue.

Arguments: the program, the folder of the plan, and the number of workers to start. HQ_SERVER_DIR names the folder of a server
that runs already; without it, one is started for as long as this takes.
"""

import contextlib
import json
import os
import sys
from pathlib import Path

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig
from hyperqueue.ffi.protocol import ResourceRequest


def job(program, folder):
    graph = json.loads((folder / "plan.json").read_text())
    whole = Job(folder, max_fails=1, name=folder.name)
    tasks = {}
    for task in graph["tasks"]:
        name = task["name"]
        tasks[name] = whole.program(
            [program, "farm", "task", str(folder), name],
            cwd=folder,
            stdout=None,
            stderr=str(folder / "logs" / f"{name}.log"),
            deps=[tasks[before] for before in task["after"]],
            resources=ResourceRequest(cpus="all"),
        )
    return whole


def main(program, folder, workers):
    with contextlib.ExitStack() as stack:
        server = os.environ.get("HQ_SERVER_DIR")
        if server is None:
            cluster = stack.enter_context(LocalCluster())
            for _ in range(workers):
                cluster.start_worker(WorkerConfig(cores=1))
            client = cluster.client()
        else:
            client = Client(server)
        submitted = client.submit(job(program, folder))
        # what it would show on a bar is shown by the program
        client.connection.wait_for_jobs([submitted.id], lambda _: None)
        failed = client.get_failed_tasks(submitted)
    for task, context in failed.items():
        print(f"{submitted.job.task_by_id(task).label}: {context.error}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])))
    except Exception as error:
        sys.exit(f"HyperQueue: {error}")
