"""A cluster of HyperQueue of which each part is a process of its own, so that one can be killed.

server FOLDER            runs a server until its standard input ends; says "ready" when it is there
worker FOLDER OWN        runs a worker of the server in FOLDER; OWN is an empty folder
"""

import os
import sys
import time
from pathlib import Path

from hyperqueue.ffi.cluster import Cluster

# where a server writes how it is reached
ACCESS = "hq-current"


def server(folder):
    cluster = Cluster(folder)
    print("ready", flush=True)
    sys.stdin.read()
    cluster.stop()


def worker(folder, own):
    # The package starts workers for servers of the same process alone. So there is one, which nobody uses: its access is replaced by
    # that of the real one, which the worker then finds.
    cluster = Cluster(own)
    access = Path(own) / ACCESS
    os.remove(access)
    os.symlink((Path(folder) / ACCESS).resolve(), access)
    cluster.add_worker(1)
    print("ready", flush=True)
    while True:
        time.sleep(60)


if __name__ == "__main__":
    {"server": server, "worker": worker}[sys.argv[1]](*map(os.path.abspath, sys.argv[2:]))
