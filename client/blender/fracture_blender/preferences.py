# SPDX-License-Identifier: GPL-3.0-or-later
"""Whom to ask, and where the description of the parameters is kept."""
import os
import pathlib
import urllib.parse

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from . import description
from .asking import Target
from .package import Client, FractureError

NAME = __package__  # of the add-on: of an extension it has more than one part


class FracturePreferences(bpy.types.AddonPreferences):
    bl_idname = NAME

    # As a dictionary: with colons, checkers take their words for types.
    __annotations__ = {
        "ask": EnumProperty(name="Ask", default="SERVER", items=[
            ("SERVER", "A server", "A fracture server, on this machine or another one"),
            ("PROGRAM", "A program", "fracture-server on this machine, started for each fracture")]),
        "url": StringProperty(name="Server", default="http://127.0.0.1:8080", description="http://host:port or https://host:port"),
        "token": StringProperty(name="Token", subtype="PASSWORD", options={"SKIP_SAVE"},
                                description="For a server that asks for one. It is not saved; the variable FRACTURE_TOKEN holds as well"),
        "program": StringProperty(name="Program", subtype="FILE_PATH", default="fracture-server",
                                  description="fracture-server: a path, or a name that is found on the PATH"),
        "timeout": FloatProperty(name="Patience", default=300.0, min=1.0, soft_max=3600.0, precision=0,
                                 description="Seconds that a server may be absent or busy before an error says so"),
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
    """Raises FractureError where Blender is told to stay offline."""
    own = of(context)
    if own.ask == "PROGRAM":
        return Target(program=bpy.path.abspath(own.program) if own.program.startswith("//") else own.program)
    host = urllib.parse.urlsplit(own.url).hostname
    if not getattr(bpy.app, "online_access", True) and host not in ("localhost", "127.0.0.1", "::1"):
        raise FractureError("connection", "Blender's preferences do not allow online access, and the server is on another machine.")
    return Target(url=own.url, token=own.token or os.environ.get("FRACTURE_TOKEN", ""), timeout=own.timeout)


def ask_description(context):
    """Of the server or the program in use; kept for the next start. Raises FractureError."""
    where = target(context)
    if where.program:
        found = description.of_program(where.program)
    else:
        with Client(where.url, where.token or None, description.ASK_SECONDS) as client:
            found = description.of_server(client)
    try:
        description.store(found, _folder(create=True))
    except OSError:
        pass  # then it is asked for again at the next start
    return found


def kept_description():
    """The last one, else the one of the day on which the add-on was packed, else None."""
    return description.load((_folder(create=False), pathlib.Path(__file__).parent))


def _folder(create):
    return bpy.utils.user_resource("CONFIG", path="fracture_blender", create=create)
