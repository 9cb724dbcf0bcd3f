"""The version of the package. Client.openapi() reports the interface version, and Client.version() the algorithm version."""

VERSION = "0.1.0"
