"""Panels show settings that there are."""

import unittest
from unittest.mock import MagicMock

import bpy
from support import empty_scene, light

from phototaxis import panels, preferences, properties


class Layout(MagicMock):
    """A layout that takes any call, and knows what was to be shown."""

    shown: set = set()

    def prop(self, data, name, **more):
        if name not in data.bl_rna.properties:
            raise AssertionError(f"{data.bl_rna.identifier} has no '{name}'")
        Layout.shown.add(name)

    def row(self, **more):
        return self

    column = row


class Panel:
    """What a panel is when it draws."""

    layout = Layout()
    columns = panels._Panel.columns


class Panels(unittest.TestCase):
    def test_all_of_them(self):
        scene = empty_scene()
        lamps = [light(kind, 1.0).data for kind in ("POINT", "SPOT", "SUN", "AREA")]
        lamps[3].shape = "RECTANGLE"
        for each in panels._CLASSES:
            for method in ("auto", "sdtree", "none"):
                scene.phototaxis.method = method
                for lamp in lamps:
                    context = MagicMock(scene=scene, view_layer=bpy.context.view_layer, light=lamp, engine="PHOTOTAXIS")
                    self.assertTrue(each.poll(context))
                    each.draw(Panel(), context)
        # Every setting of ours is somewhere.
        own = set(properties.PhototaxisSettings.__annotations__) | set(properties.PhototaxisLayerSettings.__annotations__)
        self.assertEqual(own - Layout.shown, set())

    def test_of_other_engines(self):
        for each in panels._CLASSES:
            self.assertFalse(each.poll(MagicMock(engine="CYCLES", light=None)))
        self.assertTrue(all("PHOTOTAXIS" in panel.COMPAT_ENGINES for panel in panels._blenders_own()))
        self.assertGreater(len(panels._blenders_own()), 20)

    def test_preferences(self):
        drawn = MagicMock(layout=Layout())
        drawn.bl_rna = preferences.PhototaxisPreferences.bl_rna
        drawn.layout.prop = MagicMock()
        preferences.PhototaxisPreferences.draw(drawn, None)
        drawn.layout.prop.assert_called_once_with(drawn, "program")
