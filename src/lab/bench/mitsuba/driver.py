"""Renders one scene with Mitsuba 3 whenever it is asked to.

    driver.py VARIANT SCENE.xml THREADS

One line of JSON is answered by one line of JSON. The first answer comes unasked, when the scene is loaded: the version,
or what is missing. Then each {"spp": N, "seed": N, "picture": FILE} is rendered, timed and written as OpenEXR.
"""

import json
import os
import sys
import time


def main(variant, scene_file, threads):
    # nothing but answers may reach standard output, whatever libraries print
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def answer(**what):
        print(json.dumps(what), file=answers, flush=True)

    try:
        import drjit as dr
        import mitsuba as mi

        mi.set_variant(variant)
        # the compiler is looked for at the first operation
        dr.eval(mi.Float(1) + 1)
    except Exception as error:
        answer(missing=f"{type(error).__name__}: {error}")
        return
    scene = mi.load_file(scene_file)
    answer(version=mi.__version__)
    for line in sys.stdin:
        order = json.loads(line)
        dr.set_thread_count(threads)
        wall, cpu = time.perf_counter(), time.process_time()
        dr.eval(mi.render(scene, spp=order["spp"], seed=order["seed"]))
        dr.sync_thread()
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        # with a single thread, Mitsuba 3.9 does not come back from writing OpenEXR
        dr.set_thread_count(max(threads, 2))
        scene.sensors()[0].film().bitmap().write(order["picture"])
        answer(seconds=wall, cpu_seconds=cpu)


main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
