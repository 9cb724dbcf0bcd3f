"""python -m fracture_client SERVER MESH OUT name=value …"""
import sys

from .command import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
