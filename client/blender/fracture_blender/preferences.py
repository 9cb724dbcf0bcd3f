# SPDX-License-Identifier: GPL-3.0-or-later
"""The preferences: server or program, and the stored description of its parameters."""
import os
import pathlib
import urllib.parse

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from . import description
from .asking import Target
from .package import Client, FractureError

NAME = __package__  # the add-on's name, which has several parts if it is an extension


class FracturePreferences(bpy.types.AddonPreferences):
    bl_idname = NAME

    # A dictionary instead of annotations, because checkers would read the texts of annotations as types.
    __annotations__ = {
        "ask": EnumProperty(name="Use", default="SERVER", items=[
            ("SERVER", "A server", "A fracture server on this or another machine"),
            ("PROGRAM", "A program", "The program fracture-server, which is started on this machine for each fracture")]),
        "url": StringProperty(name="Server", default="http://127.0.0.1:8080",
                              description="Server address: http://host:port or https://host:port"),
        "token": StringProperty(name="Token", subtype="PASSWORD", options={"SKIP_SAVE"},
                                description="Token for a server that requires one. The token is not saved. If this field is empty, "
                                "the environment variable FRACTURE_TOKEN is used"),
        "program": StringProperty(name="Program", subtype="FILE_PATH", default="fracture-server",
                                  description="The program fracture-server: its path, or its name if it is on the PATH"),
        "timeout": FloatProperty(name="Timeout", default=300.0, min=1.0, soft_max=3600.0, precision=0,
                                 description="How many seconds a server may be unreachable or busy before the fracture fails"),
    }

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "ask", expand=True)
        for name in ("url", "token", "timeout") if self.ask == "SERVER" else ("program",):
            layout.prop(self, name)


def of(context):
    return context.preferences.addons[NAME].preferences


def target(context):
    """Returns the server or program set in the preferences. Raises FractureError if Blender must stay offline and the server is on
    another machine."""
    own = of(context)
    if own.ask == "PROGRAM":
        return Target(program=bpy.path.abspath(own.program) if own.program.startswith("//") else own.program)
    host = urllib.parse.urlsplit(own.url).hostname
    if not getattr(bpy.app, "online_access", True) and host not in ("localhost", "127.0.0.1", "::1"):
        raise FractureError("connection", f"The server {own.url} is on another machine, and Blender's preferences do not allow online "
                                          "access. Allow it in Preferences > System, or use a server or program on this machine.")
    return Target(url=own.url, token=own.token or os.environ.get("FRACTURE_TOKEN", ""), timeout=own.timeout)


def ask_description(context):
    """Fetches the description from the server or program in use, and stores it for the next start. Raises FractureError."""
    where = target(context)
    if where.program:
        found = description.of_program(where.program)
    else:
        with Client(where.url, where.token or None, description.ASK_SECONDS) as client:
            found = description.of_server(client)
    try:
        description.store(found, _folder(create=True))
    except OSError:
        pass  # the description is fetched again at the next start
    return found


def kept_description():
    """Returns the stored description, or the description in the packed add-on if none is stored. None if both are missing."""
    return description.load((_folder(create=False), pathlib.Path(__file__).parent))


def _folder(create):
    return bpy.utils.user_resource("CONFIG", path="fracture_blender", create=create)
