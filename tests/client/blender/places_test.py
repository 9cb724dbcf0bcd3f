# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that hits, regions to keep, regions to hold, and paint are requested correctly and take effect where the empties are."""
import json
import math
import pathlib
import sys

import bpy
from mathutils import Vector

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, add_cube, add_empty, fragments_of, select, settings  # noqa: E402


def asked(collection):
    return json.loads(collection["fracture_parameters"])


def near(collection, place, radius):
    """Counts the fragments whose centre is within the radius of the place."""
    return sum((item.location - Vector(place)).length < radius for item in fragments_of(collection))


class Hits(InBlender):
    def test_a_hit_at_the_cursor_is_turned_to_y_up(self):
        add_cube()
        bpy.context.scene.cursor.location = (1, -1, 0.5)
        settings().hits, settings().hit_radius = "CURSOR", 0.5
        made, = self.fracture(pattern="impact", sites=60)
        self.assertEqual(asked(made)["impacts"], [[1, 0.5, 1]])
        self.assertEqual(asked(made)["radius"], 0.5)
        self.assertGreater(near(made, (1, -1, 0.5), 0.7), 5 * near(made, (-1, 1, -0.5), 0.7))

    def test_hits_at_selected_empties_have_their_display_size_as_radius(self):
        item = add_cube()
        places = (1, -0.5, 1), (-1, 1, -1)
        empties = [add_empty(place, 0.3 + 0.1 * number, name=f"Hit {number}") for number, place in enumerate(places)]
        empties[1].scale = (2, 1, 1)
        select(item, *empties)
        settings().hits, settings().hit_kind = "EMPTIES", "LOCAL"
        made, = self.fracture(sites=5, local_sites="20")
        self.assertEqual(asked(made)["local_point"], [[1, 1, 0.5], [-1, -1, -1]])
        for radius, expected in zip(asked(made)["local_radius"], (0.3, 0.8)):
            self.assertAlmostEqual(radius, expected, places=6)
        for place in places:
            self.assertGreater(near(made, place, 0.9), 3)

    def test_lengths_follow_the_unit_scale(self):
        bpy.context.scene.unit_settings.scale_length = 0.1
        item, empty = add_cube(size=20), add_empty((10, 0, 0), 5)
        select(item, empty)
        settings().hits = "EMPTIES"
        made, = self.fracture(pattern="impact", sites=30)
        self.assertAlmostEqual(asked(made)["impacts"][0][0], 1, places=6)
        self.assertAlmostEqual(asked(made)["radius"], 0.5, places=6)
        self.assertGreater(near(made, (10, 0, 0), 6), 2 * near(made, (-10, 0, 0), 6))

    def test_radius_is_left_out_where_the_pattern_has_none(self):
        add_cube()
        settings().hits = "CURSOR"
        made, = self.fracture(material="glass", fragments=20)
        self.assertNotIn("radius", asked(made))
        made, = self.refracture(material="stone", fragments=20)
        self.assertEqual(asked(made)["pattern"], "impact")
        self.assertIn("radius", asked(made))

    def refracture(self, **parameters):
        item = bpy.context.scene.objects["Box"]
        item.hide_set(False)
        select(item)
        return self.fracture(**parameters)

    def test_no_empty_is_selected(self):
        add_cube()
        settings().hits = "EMPTIES"
        self.assertIn("no empty is selected", self.refused())


class Regions(InBlender):
    def test_nothing_is_cut_in_a_cube_empty(self):
        item = add_cube()
        keep = add_empty((0.6, -0.7, 0.8), 0.5, "CUBE")
        settings().keep = keep
        select(item)
        made, = self.fracture(pattern="uniform", sites=150)
        low, high = asked(made)["keep_box"]
        for a, b in zip(low + high, (0.1, 0.3, 0.2, 1.1, 1.3, 1.2)):
            self.assertAlmostEqual(a, b, places=6)
        inside = [piece for piece in fragments_of(made)
                  if any(all(abs(v - c) < 0.49 for v, c in zip(piece.matrix_world @ vertex.co, keep.location))
                         for vertex in piece.data.vertices)]
        self.assertEqual(len(inside), 1)

    def test_a_turned_cube_keeps_the_box_around_it_and_a_sphere_a_sphere(self):
        item, keep = add_cube(), add_empty((0, 0, 0), 0.5, "CUBE")
        keep.rotation_euler = (0, 0, math.pi / 4)
        bpy.context.view_layer.update()
        settings().keep = keep
        select(item)
        made, = self.fracture(sites=20)
        for a, b in zip(asked(made)["keep_box"][1], (0.5 ** 0.5, 0.5, 0.5 ** 0.5)):
            self.assertAlmostEqual(a, b, places=6)
        keep.empty_display_type = "SPHERE"
        item.hide_set(False)
        select(item)
        made, = self.fracture(sites=20)
        self.assertEqual((asked(made)["keep_center"], asked(made)["keep_radius"]), ([0, 0, 0], 0.5))

    def test_held_fragments_are_passive(self):
        item, arrow = add_cube(), add_empty((0, 0, -1), 1, "SINGLE_ARROW")
        settings().hold = arrow
        select(item)
        made, = self.fracture(sites=60)
        for piece in fragments_of(made):
            low = min((piece.matrix_world @ vertex.co).z for vertex in piece.data.vertices)
            self.assertEqual(piece.rigid_body.type, "PASSIVE" if low < -1 + 1e-4 else "ACTIVE")
        self.assertGreater(sum(piece["fracture_anchored"] for piece in fragments_of(made)), 3)


class Paint(InBlender):
    def sphere(self):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=24)
        item = bpy.context.object
        return item, [vertex.index for vertex in item.data.vertices if vertex.co.z > 0]

    def check(self):
        made, = self.fracture(pattern="uniform", sites=150)
        self.assertEqual(asked(made)["density_from"], "COLOR_0")
        heights = [piece.location.z for piece in fragments_of(made)]
        self.assertGreater(sum(z > 0 for z in heights), 3 * sum(z < 0 for z in heights))
        return made

    def test_a_vertex_group_draws_fragments_to_it(self):
        item, upper = self.sphere()
        item.vertex_groups.new(name="Other")
        item.vertex_groups.new(name="Weak").add(upper, 1.0, "REPLACE")
        settings().paint, settings().paint_name = "GROUP", "Weak"
        made = self.check()
        self.assertEqual([len(piece.data.color_attributes) for piece in fragments_of(made)], [0] * len(fragments_of(made)))

    def test_a_color_attribute_draws_fragments_to_it(self):
        item, upper = self.sphere()
        item.data.color_attributes.new("First", "FLOAT_COLOR", "POINT")
        layer = item.data.color_attributes.new("Weak", "BYTE_COLOR", "CORNER")
        upper = set(upper)
        for loop in item.data.loops:
            layer.data[loop.index].color = (1, 1, 1, 1) if loop.vertex_index in upper else (0, 0, 0, 1)
        settings().paint, settings().paint_name = "COLOR", "Weak"
        made = self.check()
        self.assertEqual({name for piece in fragments_of(made) for name in piece.data.color_attributes.keys()}, {"First", "Weak"})

    def test_paint_that_is_not_there_is_named(self):
        add_cube()
        settings().paint, settings().paint_name = "GROUP", "Nowhere"
        self.assertIn("uses the vertex group 'Nowhere'", self.refused())


class Parameters(InBlender):
    """Values of the panel, converted to the frame of the interface."""

    def test_vectors_boxes_sizes_and_matrices_are_turned(self):
        group = bpy.context.scene.fracture_parameters
        support.give(grain=(1, 2, 3), cell=(1, 2, 3), anchor_box=(-1, -2, -3, 1, 2, 3), stretch_matrix=(1, 0, 0, 0, 2, 0, 0, 0, 3),
                     points="1,2,3;4,5,6", interior_color=(1, 0.5, 0), local_sites="3,4", seed=7, broken="8887551199781086",
                     min_volume=0.3, fragment="8887551199781086")
        self.assertEqual(support.part("properties").given(bpy.context.scene), {
            "grain": [1, 3, -2], "cell": [1, 3, 2], "anchor_box": [[-1, -3, -2], [1, 3, 2]],
            "stretch_matrix": [[1, 0, 0], [0, 3, 0], [0, 0, 2]], "points": [[1, 3, -2], [4, 6, -5]], "interior_color": "#ff8000",
            "local_sites": [3, 4], "seed": 7, "broken": [8887551199781086], "min_volume": 0.3, "fragment": 8887551199781086})
        group.use_seed = False
        self.assertNotIn("seed", support.part("properties").given(bpy.context.scene))

    def test_every_parameter_of_the_server_has_a_property(self):
        description, own = support.part("properties").Known.description, support.part("parameters").OWN
        group = bpy.context.scene.fracture_parameters
        self.assertGreater(len(description.parameters), 80)
        for name, entry in description.parameters.items():
            self.assertEqual(hasattr(group, name), name not in own, name)
            if name not in own:
                self.assertIn(entry["description"][:20].replace("`", "'").rstrip("."), group.bl_rna.properties[name].description)

    def test_every_default_and_every_preset_is_turned_back_to_itself(self):
        properties, frame = support.part("properties"), support.part("frame").Frame(0.01)
        known = properties.Known
        pairs = [(name, entry["default"]) for name, entry in known.description.parameters.items() if "default" in entry]
        for material in known.description.materials.values():
            pairs += material["parameters"].items()
        for name, value in pairs:
            if name in known.parameters:
                parameter = known.parameters[name]
                self.assertEqual(parameter.to_request(parameter.to_blender(value, frame), frame), value, name)

    def test_values_stay_when_another_server_describes_other_ones(self):
        known, properties = support.part("properties").Known, support.part("properties")
        document = json.loads(json.dumps(known.description.document))
        self.addCleanup(properties.use, known.description)
        support.give(material="wood", fragments=33, grain=(0, 1, 0))
        for entry in document["parameters"]:
            if entry["name"] == "material":
                entry["enum"].insert(0, "butter")
        document["parameters"].append({"name": "softness", "type": "number", "default": 0.5, "description": "How soft it is."})
        properties.use(support.part("description").Description(document))
        self.assertEqual(properties.given(bpy.context.scene), {"material": "wood", "fragments": 33, "grain": [0, 0, -1]})
        bpy.context.scene.fracture_parameters.softness = 0.7
        self.assertEqual(properties.given(bpy.context.scene)["softness"], 0.7)

    def test_what_is_switched_on_begins_with_what_the_material_has(self):
        group = bpy.context.scene.fracture_parameters
        support.give(material="sandstone")
        group.use_stretch = group.use_grain = group.use_interior_color = True
        self.assertAlmostEqual(group.stretch, 0.5)
        self.assertEqual(tuple(group.grain), (0, 0, 1))
        self.assertEqual(support.part("properties").given(bpy.context.scene)["interior_color"], "#c8a878")


if __name__ == "__main__":
    support.main()
