#!/usr/bin/env python3
"""HTTPS: certificates are checked, and calls over it can be cancelled like any others."""
import pathlib
import shutil
import ssl
import subprocess
import tempfile
import threading
import unittest

from support import FRAGMENTS, PATIENCE, Client, FaultServer, Reply, caught, eventually, fragments, main, quick
from fracture_client import Cancel

ID = "sha256:" + "0" * 64


class TlsServer(FaultServer):
    def __init__(self, handler, context):
        self._context = context
        super().__init__(handler)
        self.url = self.url.replace("http:", "https:")

    def _converse(self, end, connection):
        with self._context.wrap_socket(end, server_side=True) as tls:
            super()._converse(tls, connection)


@unittest.skipUnless(shutil.which("openssl"), "openssl is not installed")
class Https(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.certificate, key = pathlib.Path(folder.name) / "cert.pem", pathlib.Path(folder.name) / "key.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                        "-subj", "/CN=test", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", cls.certificate],
                       check=True, capture_output=True, timeout=PATIENCE)
        cls.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        cls.context.load_cert_chain(cls.certificate, key)
        cls.trust = ssl.create_default_context(cafile=str(cls.certificate))

    def test_an_answer_over_a_connection_that_is_kept(self):
        with TlsServer(lambda asked: fragments(), self.context) as server, \
                Client(server.url, tls=self.trust, settings=quick()) as client:
            for _ in range(3):
                self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
            self.assertEqual(server.connections, 1)

    def test_a_stranger_is_not_believed_and_not_asked_again(self):
        with TlsServer(lambda asked: fragments(), self.context) as server, Client(server.url, settings=quick()) as client:
            error = caught(client.version)
            self.assertEqual(error.type, "connection")
            self.assertIn("certificate", error.detail)
            self.assertEqual((server.asked, server.connections), ([], 1))

    def test_another_name_than_that_of_the_certificate_is_not_believed(self):
        with TlsServer(lambda asked: fragments(), self.context) as server, \
                Client(server.url.replace("127.0.0.1", "localhost"), tls=self.trust, settings=quick()) as client:
            self.assertIn("certificate", caught(client.version).detail)

    def test_who_speaks_no_tls_is_said_so(self):
        with FaultServer(lambda asked: fragments()) as server, \
                Client(server.url.replace("http:", "https:"), tls=self.trust, timeout=5, settings=quick(connect_timeout=0.2, tries=1)) as client:
            self.assertIn(caught(client.version).type, ("connection", "timeout"))

    def test_a_call_is_taken_back(self):
        with TlsServer(lambda asked: Reply(silent=True), self.context) as server, \
                Client(server.url, tls=self.trust, settings=quick()) as client:
            token, errors = Cancel(), []
            call = threading.Thread(target=lambda: errors.append(caught(client.mesh(ID).fracture, cancel=token)))
            call.start()
            eventually("the request", lambda: len(server.asked) == 1)
            token.cancel()
            call.join(PATIENCE)
            self.assertEqual([error.type for error in errors], ["cancelled"])
            eventually("the server to see it", lambda: server.closed_by_client == 1)

    def test_a_handshake_is_taken_back(self):
        silent = threading.Event()

        class NoHandshake(FaultServer):
            def _converse(self, end, connection):
                end.recv(65536)
                silent.set()
                while end.recv(65536):
                    pass

        with NoHandshake(lambda asked: fragments()) as server, \
                Client(server.url.replace("http:", "https:"), tls=self.trust, settings=quick(connect_timeout=PATIENCE)) as client:
            token, errors = Cancel(), []
            call = threading.Thread(target=lambda: errors.append(caught(client.version, cancel=token)))
            call.start()
            self.assertTrue(silent.wait(PATIENCE))
            token.cancel()
            call.join(PATIENCE)
            self.assertEqual([error.type for error in errors], ["cancelled"])


if __name__ == "__main__":
    main()
