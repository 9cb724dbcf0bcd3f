"""secrets_test.py FRACTURE_SERVER: tests whether strangers are shut out of a farm with secrets from
docker/make-secrets.

Exits with 0 if all is well, with 1 and a list of the faults, or with 77 (skipped) if Redis is missing.
"""
import os
import subprocess
import tempfile
import threading
import time

import yaml

from farm_files import DOCKER, PATIENCE, SERVER, ask_program, expect, fracture_a_cube, get, read, run, samples, serving


def main():
    """Proves that Redis admits only the servers of a farm with these secrets, and that no server starts without them.
    """
    nobodys = os.path.join(DOCKER, "kubernetes", "overlays", "large", "secrets")
    for flags in (["--farm-key-file", os.path.join(nobodys, "farm-key")],
                  ["--redis-user", "fracture", "--redis-password-file", os.path.join(nobodys, "redis-password")]):
        done = subprocess.run([SERVER, "serve", "--port", "0", "--admin-port", "0", "--redis", "127.0.0.1:1", *flags],
                              capture_output=True, text=True, timeout=PATIENCE)
        expect(done.returncode != 0, f"a server starts with {flags[-1]}, which everybody knows")
    program = ask_program("redis-server")
    with tempfile.TemporaryDirectory() as folder:
        made = [os.path.join(folder, "secrets", name) for name in ("farm-key", "redis-password", "redis-users")]
        for _ in range(2):  # the second run keeps the existing files
            before = [open(f, encoding="ascii").read() for f in made if os.path.exists(f)]
            run("sh", os.path.join(DOCKER, "make-secrets"), os.path.dirname(made[0]))
            after = [open(f, encoding="ascii").read() for f in made]
            expect(before in ([], after), "make-secrets changes secrets that are in use")
        expect(os.stat(os.path.dirname(made[0])).st_mode & 0o777 == 0o700, "anybody can read the secrets")
        expect(len({s.strip() for s in after}) == 3 and all(len(s) > 64 for s in after), "they are short, or the same")
        socket = os.path.join(folder, "redis")
        command = yaml.safe_load(read("compose.yaml"))["services"]["redis"]["command"]
        command = [program, *command[1:command.index("--aclfile") + 1], made[2], "--port", "0", "--unixsocket", socket, "--dir", folder]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as redis:
            too_late = threading.Timer(PATIENCE, redis.kill)
            too_late.start()
            try:
                log = ""
                for line in redis.stdout:
                    log += line
                    if "eady to accept connections" in line:
                        break
                expect(os.path.exists(socket), f"Redis does not start:\n{log}")
                with serving("--redis", socket, "--redis-user", "fracture", "--redis-password-file", made[1], "--farm-key-file",
                             made[0]) as (port, admin):
                    fracture_a_cube(port, 3)
                    while 'tier="redis"' not in get(admin, "/metrics"):
                        time.sleep(0.01)  # pause: serving() ends the server after a while, and that ends the loop
                    up = samples(admin)['fracture_cache_tier_up{cache="result",tier="redis"}']
                expect(up == 1, "the servers' user is not let in")
                client = [ask_program("redis-cli"), "-s", socket]
                expect(run(*client, "ping").strip() == "PONG", "Redis cannot be asked whether it is there")
                for asked in ["keys", "*"], ["get", "fracture:x"], ["flushall"], ["config", "get", "*"], ["acl", "list"]:
                    expect("NOPERM" in run(*client, *asked), f"anybody may {asked}")
                own = ["--user", "fracture", "--pass", after[1].strip(), "--no-auth-warning"]
                for asked in ["keys", "*"], ["get", "other"], ["flushall"], ["acl", "list"], ["eval", "return 1", "0"]:
                    expect("NOPERM" in run(*client, *own, *asked), f"a server may {asked}")
                expect("NOPERM" not in run(*client, *own, "get", "fracture:x"), "a server may not read")
            finally:
                redis.terminate()
                redis.stdout.read()
                too_late.cancel()


main()
print("secrets: all is well")
