# SPDX-License-Identifier: GPL-3.0-or-later
"""Imports the Python package fracture_client: from the packed add-on (pack.py includes the package), or from Python's path.

All modules of the add-on import it from here, so that there is only one copy and one FractureError.
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
    """Returns a FractureError about the scene or its settings, so Blender shows it like an error from the server."""
    return FractureError("bad-parameter", detail, title="", parameter=parameter)
