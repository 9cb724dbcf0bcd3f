#!/usr/bin/env python3
"""A client that closes its connection cancels its request: the server stops computing and releases what the client
held. Tested with the package, the standard library, a bare socket and curl, directly and through the HAProxy of
docker/haproxy."""
import contextlib
import hashlib
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import unittest

from support import PATIENCE, Client, Haproxy, Server, box_obj, caught, eventually, main
from fracture_client import Admin, Cancel

TOKEN = "small-token-0123456789"
LONG = {"sites": 20_000, "lloyd": 50}  # a minute on one thread
BODY = json.dumps(LONG).encode()
MOST_AFTER = 2.0  # processor seconds of the server after the close: the computation's, and those of the questions that the test asks
FIELDS = {"Authorization": f"Bearer {TOKEN}", "Content-Type": "application/json", "Priority": "u=3"}


class Closing(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        tokens = pathlib.Path(folder.name, "tokens.json")
        tokens.write_text(json.dumps({"tenants": [{"name": "small", "tokens": [{"sha256": hashlib.sha256(TOKEN.encode()).hexdigest()}],
                                                   "scopes": ["read", "fracture"], "computations": 1}]}), encoding="utf-8")
        tokens.chmod(0o600)
        cls.server = Server("--deadline", "36000", "--token-file", str(tokens))  # otherwise long requests would be refused
        cls.addClassCleanup(cls.server.stop)
        cls.admin = Admin(cls.server.admin_url)
        cls.addClassCleanup(cls.admin.close)
        with Client(cls.server.url, token=TOKEN) as client:
            cls.mesh = client.put(box_obj(), format="obj").id

    def figure(self, name):
        """Returns the value of a metric, possibly with labels; 0 if nothing was counted yet."""
        found = re.search(rf"^{re.escape(name)} (\S+)$", self.admin.metrics(), re.MULTILINE)
        return float(found.group(1)) if found else 0.0

    def cancelled(self):
        return sum(float(value) for value in re.findall(r'^fracture_requests_total\{.*status="499".*\} (\S+)$', self.admin.metrics(),
                                                        re.MULTILINE))

    def processor_seconds(self):
        """Returns the processor time that the server has used. Waiting for a busy machine does not count."""
        stat = pathlib.Path(f"/proc/{self.server.process.pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        return (int(stat[11]) + int(stat[12])) / os.sysconf("SC_CLK_TCK")  # user and system

    def expect_stopped(self):
        """Call this after the close: the computation, which would take a minute, stops soon and gives everything back."""
        before = self.processor_seconds()
        for name in ("fracture_flights", "fracture_jobs_running", 'fracture_tenant_computations{tenant="small"}',
                     'fracture_memory_reserved_bytes{part="working"}'):
            eventually(name + " to be 0", lambda: self.figure(name) == 0)
        self.assertLess(self.processor_seconds() - before, MOST_AFTER)

    def check(self, port, ask):
        """`ask(port)` sends the request and returns a function that closes the connection."""
        before = self.cancelled()
        close = ask(port)
        eventually("the computation", lambda: self.figure("fracture_jobs_running") == 1)
        self.assertEqual(self.figure('fracture_tenant_computations{tenant="small"}'), 1)
        self.assertEqual(self.ask_for_little(seed=int(before)), 429)
        close()
        self.expect_stopped()
        eventually("the request to be counted as cancelled", lambda: self.cancelled() == before + 1)
        self.assertEqual(self.ask_for_little(seed=int(before)), 200, "its share is free again")

    def ask_for_little(self, seed):
        """Sends a small request. Returns the status of the answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=PATIENCE)
        connection.request("POST", f"/meshes/{self.mesh}/fracture", json.dumps({"sites": 3, "seed": seed}), FIELDS)
        with contextlib.closing(connection):
            return connection.getresponse().status

    def both(self, ask):
        for through in (self.server, Haproxy(self.server)):
            if through is not self.server:
                self.addCleanup(through.stop)
            with self.subTest(through=type(through).__name__):
                self.check(through.port, ask)

    def package(self, port, end):
        """Starts a call of the package in a separate thread. `end(client, token)` cancels it."""
        client, token, errors = Client(f"http://127.0.0.1:{port}", token=TOKEN), Cancel(), []
        call = threading.Thread(target=lambda: errors.append(caught(client.mesh(self.mesh).fracture, cancel=token, **LONG)))
        call.start()

        def close():
            end(client, token)
            call.join(PATIENCE)
            self.assertEqual([error.type for error in errors], ["cancelled"])
            client.close()
        return close

    def test_the_package_by_a_token(self):
        self.both(lambda port: self.package(port, lambda client, token: token.cancel()))

    def test_the_package_by_the_end_of_the_client(self):
        self.both(lambda port: self.package(port, lambda client, token: client.close()))

    def test_the_standard_library(self):
        def ask(port):
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
            connection.request("POST", f"/meshes/{self.mesh}/fracture", BODY, FIELDS)
            return connection.close
        self.both(ask)

    def socket_of(self, port, **more):
        fields = "".join(f"{name}: {value}\r\n" for name, value in {**FIELDS, **more}.items())
        connection = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        connection.sendall(f"POST /meshes/{self.mesh}/fracture HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(BODY)}\r\n{fields}\r\n"
                           .encode() + BODY)
        self.addCleanup(connection.close)
        return connection

    def test_a_socket_that_closes_its_sending_side(self):
        def ask(port):
            connection = self.socket_of(port)
            return lambda: connection.shutdown(socket.SHUT_WR)
        self.both(ask)

    def test_a_socket_that_says_that_it_still_reads_goes_on(self):
        before = self.cancelled()
        connection = self.socket_of(self.server.port, **{"Half-Close": "yes"})
        eventually("the computation", lambda: self.figure("fracture_jobs_running") == 1)
        connection.shutdown(socket.SHUT_WR)
        self.assertEqual(self.ask_for_little(seed=99), 429)
        self.assertEqual((self.figure("fracture_jobs_running"), self.cancelled()), (1, before))
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")  # a reset cancels it
        connection.close()
        self.expect_stopped()

    @unittest.skipUnless(shutil.which("curl"), "curl is not installed")
    def test_curl_that_is_interrupted(self):
        def ask(port):
            fields = [part for name, value in FIELDS.items() for part in ("-H", f"{name}: {value}")]
            curl = subprocess.Popen(["curl", "--silent", *fields, "--data-binary", BODY.decode(),
                                     f"http://127.0.0.1:{port}/meshes/{self.mesh}/fracture"], stdout=subprocess.DEVNULL)

            def close():
                curl.send_signal(signal.SIGINT)
                self.assertNotEqual(curl.wait(PATIENCE), 0)
            return close
        self.both(ask)

    def test_the_log_says_499(self):
        lines = len(self.server.lines)
        self.check(self.server.port, lambda port: self.socket_of(port).close)
        eventually("a line of the log", lambda: any(" status=499 " in line for line in self.server.lines[lines:]))


if __name__ == "__main__":
    main()
