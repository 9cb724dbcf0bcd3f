# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid bodies for fragments, and a breakable constraint for each bond."""
import bpy

from .frame import Frame


def prepare(scene):
    """Returns the scene's rigid body world with its two collections. Creates the world or collections that are missing."""
    if scene.rigidbody_world is None:
        bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    if world.collection is None:
        world.collection = bpy.data.collections.new("RigidBodyWorld")
    if world.constraints is None:
        world.constraints = bpy.data.collections.new("RigidBodyConstraints")
    return world


def add_bodies(scene, answer, objects, shape):
    """Turns each fragment into a rigid body by linking it to the world's collection. Blender's own operator is slower."""
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
        # Without this setting, a margin around each hull pushes touching pieces apart, so bricks in an undisturbed box move a metre in
        # one second. With this setting, Blender shrinks the hull by the margin if the hull is large enough.
        body.use_margin = False


def threshold(bond, scene, factor=1.0):
    """Returns the impulse at which Blender breaks a constraint.

    A bond withstands forces up to its strength (N), which is the material's strength (Pa) times the bond's area. Bullet checks a constraint's
    impulse within one step, which takes 1 / (frames per second * substeps per frame) seconds. Bullet's lengths are in
    Blender units, so 1 N has the value 1 / scale in Bullet.
    """
    world = scene.rigidbody_world
    rate = scene.render.fps / scene.render.fps_base / max(world.time_scale, 1e-6) * world.substeps_per_frame
    return min(factor * bond.strength / Frame.of(scene).scale / rate, 3.4e38)


def add_constraints(scene, answer, objects, collection, factor=1.0):
    """Creates an empty with a constraint for each bond, in a separate collection, and returns the empties. The two fragments of a bond
    never collide, even after the bond breaks, because hulls of ragged chunks overlap and would push each other away."""
    world = prepare(scene)
    frame = Frame.of(scene)
    inside = bpy.data.collections.new(f"{collection.name} bonds")
    collection.children.link(inside)
    made = []
    for bond in answer.bonds:
        a, b = objects[bond.a], objects[bond.b]
        item = bpy.data.objects.new(f"Bond {a.name} {b.name}"[:63], None)
        item.location = frame.point_back([own + root for own, root in zip(bond.centroid, answer.offset)])
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
    """Removes the original from the simulation, because its fragments would collide with it. Undo restores the original's body."""
    world = scene.rigidbody_world
    if item.rigid_body is not None and world is not None and world.collection is not None and item.name in world.collection.objects:
        world.collection.objects.unlink(item)
