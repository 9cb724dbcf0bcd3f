# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid bodies of fragments, and a breakable constraint for each bond."""
import bpy

from .frame import Frame


def prepare(scene):
    """The scene's rigid body world with both of its collections."""
    if scene.rigidbody_world is None:
        bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    if world.collection is None:
        world.collection = bpy.data.collections.new("RigidBodyWorld")
    if world.constraints is None:
        world.constraints = bpy.data.collections.new("RigidBodyConstraints")
    return world


def add_bodies(scene, answer, objects, shape):
    """Linking an object into the world's collection makes it a rigid body: the operator does the same, slower."""
    world = prepare(scene)
    friction, restitution = (float(answer.parameters.get(name, 0.0)) for name in ("friction", "restitution"))
    for fragment in answer.fragments:
        item = objects[fragment.id]
        world.collection.objects.link(item)
        body = item.rigid_body
        body.type = "PASSIVE" if fragment.anchored else "ACTIVE"
        body.collision_shape = shape
        body.mesh_source = "BASE"
        body.mass = fragment.mass
        body.friction = friction
        body.restitution = restitution
        # Blender takes the margin off the hull then, where there is room for it. A margin around the hull, however thin, pushes
        # pieces that touch apart: of a box of bricks that nothing moves, by a metre in a second.
        body.use_margin = False


def threshold(bond, scene, factor=1.0):
    """The impulse at which Blender breaks a constraint.

    A bond withstands a force, its strength (N): that of the material (Pa) times its area. Bullet adds up what a constraint
    carries within one of its steps and compares that impulse; a step is 1 / (frames a second * substeps a frame). Lengths
    are in Blender units there, so a newton is 1 / scale of them.
    """
    world = scene.rigidbody_world
    rate = scene.render.fps / scene.render.fps_base / max(world.time_scale, 1e-6) * world.substeps_per_frame
    return min(factor * bond.strength / Frame.of(scene).scale / rate, 3.4e38)


def add_constraints(scene, answer, objects, collection, factor=1.0):
    """An empty for each bond, in a collection of their own; returns them. What a bond is between does not collide, also when
    it is broken: hulls of ragged chunks overlap, and would shoot one another away."""
    world = prepare(scene)
    frame = Frame.of(scene)
    inside = bpy.data.collections.new(f"{collection.name} bonds")
    collection.children.link(inside)
    made = []
    for bond in answer.bonds:
        a, b = objects[bond.a], objects[bond.b]
        item = bpy.data.objects.new(f"Bond {a.name} {b.name}"[:63], None)
        item.location = frame.point_back(bond.centroid)
        item.empty_display_type, item.empty_display_size = "PLAIN_AXES", 0.1 * frame.length_back(bond.area ** 0.5)
        inside.objects.link(item)
        world.constraints.objects.link(item)
        joint = item.rigid_body_constraint
        joint.type = "FIXED"
        joint.object1, joint.object2 = a, b
        joint.use_breaking = True
        joint.breaking_threshold = threshold(bond, scene, factor)
        joint.disable_collisions = True
        item["fracture_area"], item["fracture_strength"] = bond.area, bond.strength
        made.append(item)
    return made


def remove_from_simulation(scene, item):
    """A hidden original would be hit by its own fragments. Undo gives its body back."""
    world = scene.rigidbody_world
    if item.rigid_body is not None and world is not None and world.collection is not None and item.name in world.collection.objects:
        world.collection.objects.unlink(item)
