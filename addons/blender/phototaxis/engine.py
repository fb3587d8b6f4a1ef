"""The render engine: a scene is written to a temporary folder, rendered by the program, and its picture read."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy

from . import exr, passes, preferences
from .export import NoCamera, export
from .export.camera import border, size
from .program import Run

_LISTENING = 0.1
_DONE, _STOPPED, _NOT_FINITE = 0, 130, 3


class Failed(Exception):
    """Nothing was rendered, for the reason that is said."""


class PhototaxisEngine(bpy.types.RenderEngine):
    bl_idname = "PHOTOTAXIS"
    bl_label = "Phototaxis"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    bl_use_postprocess = True

    #: Where the scene is written instead of being rendered, while the exporter runs.
    export_only: Exporting | None = None

    def update_render_passes(self, scene=None, renderlayer=None) -> None:
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for each in passes.wanted(renderlayer, scene.phototaxis.denoise):
            self.register_pass(scene, renderlayer, each.name, len(each.ids), each.ids, each.kind)

    def render(self, depsgraph) -> None:
        try:
            if PhototaxisEngine.export_only is not None:
                PhototaxisEngine.export_only.write(depsgraph)
                return
            with tempfile.TemporaryDirectory(prefix="phototaxis-") as folder:
                _Render(self, depsgraph, Path(folder)).run()
        except (Failed, NoCamera, preferences.ProgramMissing, OSError, ValueError) as error:
            self.report({"ERROR"}, f"Phototaxis: {error}")
            self.error_set(f"Phototaxis: {error}")


class Exporting:
    """What the exporter wants written, and what came of it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.warnings: list[str] = []
        self.error: Exception | None = None

    def write(self, depsgraph) -> None:
        try:
            self.warnings += export(depsgraph, self.path).warnings
        except (NoCamera, OSError, ValueError) as error:
            self.error = error


class _Render:
    """One view layer of one frame."""

    def __init__(self, engine: PhototaxisEngine, depsgraph, folder: Path) -> None:
        self.engine = engine
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene
        self.layer = depsgraph.view_layer
        self.settings = depsgraph.scene.phototaxis
        self.passes = passes.wanted(self.layer, self.settings.denoise)
        self.picture = folder / "picture.exr"
        self.preview = folder / "preview.exr"
        self.path = folder / "scene.toml"
        self.shown = 0

    def run(self) -> None:
        program = preferences.program()
        self.engine.update_stats("", "Writing the scene")
        layers = sorted({p.layer for p in self.passes if p.layer})
        exported = export(self.depsgraph, self.path, layers)
        for line in exported.warnings:
            self.engine.report({"WARNING"}, line)
        if left_out := passes.not_made(self.layer):
            self.engine.report({"WARNING"}, f"passes that Phototaxis does not make: {', '.join(left_out)}")
        result = self.begin()
        run = Run(self.arguments(program))
        try:
            self.listen(run, result)
        finally:
            run.kill()
        self.finish(run, result)

    def arguments(self, program: Path) -> list[str]:
        arguments = [str(program), "render", str(self.path), "-o", str(self.picture), "--progress", "json"]
        arguments += ["--threads", str(self.settings.threads)]
        arguments += ["--preview", str(self.preview), "--every", f"{self.settings.every}s"]

        return arguments + (["--denoise"] if self.settings.denoise else [])

    def begin(self):
        width, height = border(self.scene.render)[2:] if self.scene.render.use_border else size(self.scene.render)
        for each in self.passes:
            self.engine.add_pass(each.name, len(each.ids), each.ids, layer=self.layer.name)
        return self.engine.begin_result(0, 0, width, height, layer=self.layer.name)

    def listen(self, run: Run, result) -> None:
        """Until the program ends, shows how far it is and the picture as it grows; a cancel ends it after its pass."""
        while (said := run.heard(_LISTENING)) is not None:
            if self.is_cancelled():
                run.stop()
            if said is True:
                continue
            self.engine.update_stats("", said.text() if not run.stopping else "Finishing this pass")
            if said.share is not None:
                self.engine.update_progress(min(max(said.share, 0.0), 1.0))
            self.show_preview(result)

    def is_cancelled(self) -> bool:
        return self.engine.test_break()

    def show_preview(self, result) -> None:
        try:
            written = self.preview.stat().st_mtime_ns
        except OSError:
            return
        if written != self.shown:
            self.shown = written
            passes.fill(result.layers[0], exr.read(self.preview), self.passes)
            self.engine.update_result(result)

    def finish(self, run: Run, result) -> None:
        if run.code not in (_DONE, _STOPPED, _NOT_FINITE) or not self.picture.exists():
            self.engine.end_result(result, cancel=True)
            if run.stopping:
                return
            raise Failed(" ".join(run.messages[-3:]) or f"the program ended with code {run.code}")
        for line in run.messages:
            if line.startswith("warning"):
                self.engine.report({"WARNING"}, line.removeprefix("warning: "))
        picture = exr.read(self.picture)
        passes.fill(result.layers[0], picture, self.passes)
        self.engine.end_result(result)
        for name, text in passes.metadata(picture, self.layer.name).items():
            self.engine.get_result().stamp_data_add_field(name, text)
        if run.code == _NOT_FINITE:
            self.engine.report({"WARNING"}, "pixels of the picture are infinite or undefined")


def register() -> None:
    bpy.utils.register_class(PhototaxisEngine)


def unregister() -> None:
    bpy.utils.unregister_class(PhototaxisEngine)
