# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python package fracture_client: a part of the packed add-on (pack.py puts it in), or installed beside Blender's modules.

All of the add-on takes it from here, so that there is one copy of it, and one FractureError to catch.
"""
try:
    from .fracture_client import glb
    from . import fracture_client as client
except ModuleNotFoundError as error:
    if error.name != f"{__package__}.fracture_client":
        raise
    # From a checkout, where client/python is on the path.
    import fracture_client as client
    from fracture_client import glb

Answer, Cancel, Client, FractureError = client.Answer, client.Cancel, client.Client, client.FractureError

__all__ = ["Answer", "Cancel", "Client", "FractureError", "client", "glb", "wrong"]


def wrong(detail, parameter=""):
    """The error of something that is not right in the scene: in the same words and the same way as one of the server."""
    return FractureError("bad-parameter", detail, title="", parameter=parameter)
