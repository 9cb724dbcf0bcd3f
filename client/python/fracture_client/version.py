"""The version of the package. The interface has one of its own (Client.openapi()), and so has the algorithm (Client.version())."""

VERSION = "0.1.0"
