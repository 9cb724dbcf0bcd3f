"""The version of the package. Client.openapi() has the version of the interface, Client.version() that of the algorithm."""

VERSION = "0.1.0"
