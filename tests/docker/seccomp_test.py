"""seccomp_test.py FRACTURE_SERVER: tests whether docker/seccomp.json allows all calls of the server, and none that it
does not need.

The filter is loaded here by libseccomp, as an engine does it, with one difference: a call that is not allowed ends the
process, so that every refused call is noticed. Exits with 0 if all is well, with 1 and a list of the faults, or with 77
(skipped) if no filter can be loaded.
"""
import ctypes
import ctypes.util
import errno
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import urllib.request

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SERVER = sys.argv[1]
PATIENCE = 120  # seconds: at least ten times what anything takes here
ALLOW, KILL = 0x7FFF0000, 0x80000000
OPERATORS = {"SCMP_CMP_EQ": 4, "SCMP_CMP_MASKED_EQ": 7}
TETRAHEDRON = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


class Argument(ctypes.Structure):
    _fields_ = [("index", ctypes.c_uint), ("op", ctypes.c_int), ("a", ctypes.c_uint64), ("b", ctypes.c_uint64)]


def expect(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def errno_action(number):
    return 0x00050000 | number


def load(profile, default):
    """Loads the filter into this process and its children. Returns False if that is not possible."""
    library = ctypes.CDLL(ctypes.util.find_library("seccomp") or "libseccomp.so.2", use_errno=True)
    library.seccomp_init.restype = ctypes.c_void_p
    context = ctypes.c_void_p(library.seccomp_init(ctypes.c_uint32(default)))
    for rule in profile["syscalls"]:
        action = ALLOW if rule["action"] == "SCMP_ACT_ALLOW" else errno_action(rule["errnoRet"])
        arguments = [Argument(a["index"], OPERATORS[a["op"]], a["value"], a.get("valueTwo", 0)) for a in rule.get("args", [])]
        for name in rule["names"]:
            number = library.seccomp_syscall_resolve_name(name.encode())
            expect(number != -1, f"{name} is no system call")
            if number < 0:  # not a call of this machine's architecture
                continue
            done = library.seccomp_rule_add_array(context, ctypes.c_uint32(action), number, len(arguments),
                                                  (Argument * len(arguments))(*arguments))
            expect(done == 0, f"the rule for {name}: {os.strerror(-done)}")
    return library.seccomp_load(context) == 0


def under(profile, *command):
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=lambda: load(profile, KILL) or os._exit(77))


def finished(profile, *command):
    process = under(profile, *command)
    _, log = process.communicate(timeout=PATIENCE)
    expect(process.returncode == 0, f"{' '.join(command)}: {ending(process.returncode)}\n{log}")


def ending(code):
    return "a call that the profile does not allow" if code == -signal.SIGSYS else f"exit code {code}"


def refused(profile):
    """Tries calls that a compromised server could make."""
    library = ctypes.CDLL(None, use_errno=True)
    numbers = ctypes.CDLL(ctypes.util.find_library("seccomp") or "libseccomp.so.2")
    calls = ["add_key", "bpf", "chroot", "delete_module", "finit_module", "init_module", "io_uring_setup", "keyctl", "kexec_load",
             "mount", "move_mount", "open_by_handle_at", "perf_event_open", "pivot_root", "process_vm_readv", "process_vm_writev",
             "ptrace", "reboot", "setns", "swapon", "umount2", "unshare", "userfaultfd"]
    child = os.fork()
    if child == 0:
        if not load(profile, errno_action(errno.EPERM)):
            os._exit(77)
        for name in calls:
            ctypes.set_errno(0)
            if library.syscall(numbers.seccomp_syscall_resolve_name(name.encode()), 0, 0, 0, 0, 0) != -1 \
                    or ctypes.get_errno() != errno.EPERM:
                print(f"FAILED: {name} is not refused", flush=True)
                os._exit(1)
        new_network = 0x40000000
        library.syscall(numbers.seccomp_syscall_resolve_name(b"clone"), new_network | signal.SIGCHLD, 0, 0, 0, 0)
        packet = library.socket(17, 3, 0)
        os._exit(0 if ctypes.get_errno() == errno.EPERM and packet == -1 else 1)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code == 77:
        print("skipped: no filter can be loaded here")
        sys.exit(77)
    expect(code == 0, "a call is allowed that no server needs")


def ask(port, path, body=None, **fields):
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", data=body, headers=fields)
    with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
        return answer.read()


def serves(profile, folder):
    server = under(profile, SERVER, "serve", "--port", "0", "--admin-port", "0", "--drain-delay", "0", "--log-format", "text",
                   "--cache-dir", os.path.join(folder, "cache"), "--redis", "localhost:1", "--require-sandbox", "yes")
    too_late = threading.Timer(PATIENCE, server.kill)
    too_late.start()
    log = []
    try:
        for line in server.stderr:
            log.append(line)
            if "(admin port " in line:
                break
        found = re.search(r":(\d+) \(admin port (\d+)\)", log[-1] if log else "")
        if not found:
            sys.exit(f"FAILED: it does not start: {ending(server.wait(PATIENCE))}\n{''.join(log)}")
        port, admin = found.groups()
        obj = {"Content-Type": "model/obj"}
        for sites in 3, 300:
            ask(port, f"/fracture?sites={sites}", TETRAHEDRON, **obj)
        ask(port, "/fracture?sites=3", TETRAHEDRON, **obj, **{"Accept-Encoding": "zstd"})
        ask(port, "/fracture?sites=9", TETRAHEDRON, **obj, Prefer="respond-async")
        finished(profile, SERVER, "health", "--ready", f"http://127.0.0.1:{admin}")
        metrics = ask(admin, "/metrics").decode()
        expect('fracture_import_sandbox{layer="seccomp"} 1' in metrics, "the importers have no sandbox of their own")
        expect('fracture_imports_total{outcome="crashed"} 0' in metrics, "an importer ended early")
        server.send_signal(signal.SIGHUP)
    finally:
        server.terminate()
        log.append(server.stderr.read())
        too_late.cancel()
    expect(server.wait(PATIENCE) == 0, f"the server: {ending(server.returncode)}\n{''.join(log)}")


def main():
    with open(os.path.join(ROOT, "docker", "seccomp.json"), encoding="utf-8") as f:
        profile = json.load(f)
    expect(profile["defaultAction"] == "SCMP_ACT_ERRNO", "what is not named must be refused")
    refused(profile)
    with tempfile.TemporaryDirectory() as folder:
        mesh = os.path.join(folder, "tetrahedron.obj")
        with open(mesh, "wb") as f:
            f.write(TETRAHEDRON)
        serves(profile, folder)
        finished(profile, SERVER, "bake", mesh, "-o", os.path.join(folder, "fragments.glb"), "--sites", "5")
        finished(profile, SERVER, "inspect", mesh)
    print("seccomp: all is well")


main()
