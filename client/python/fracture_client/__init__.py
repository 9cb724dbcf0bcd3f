"""Breaks meshes into exact, watertight fragments with a fracture server. Needs only the standard library.

    from fracture_client import Client

    with Client("http://127.0.0.1:8080") as client:
        mesh = client.put("barrel.glb")
        answer = mesh.fracture(material="wood", fragments=40)
        answer.save("broken.glb")
        after = answer.hit([0.2, 0.9, 0], 0.3)

client/python/README.md shows the first steps, and `help(Client)` describes the calls. AsyncClient offers the same calls for asyncio.
"""
from .admin import Admin
from .aio import AsyncAnswer, AsyncClient, AsyncJob, AsyncMesh
from .answer import Answer
from .assignments import assignment
from .calls import Cancel
from .choices import Choice
from .client import Client
from .dropped import Dropped
from .errors import FractureError
from .fragments import Bond, Delta, Fragment, Hull, Primitive
from .http1 import Response
from .jobs import Job, JobState
from .mesh import Mesh
from .pool import Settings
from .version import VERSION as __version__

__all__ = ["Admin", "Answer", "AsyncAnswer", "AsyncClient", "AsyncJob", "AsyncMesh", "Bond", "Cancel", "Choice", "Client",
           "Delta", "Dropped", "FractureError", "Fragment", "Hull", "Job", "JobState", "Mesh", "Primitive", "Response", "Settings", "__version__",
           "assignment"]
