#!/usr/bin/env python3
"""Tests the request for a mesh: the files that it refers to, its key and the form. Also tests the answer of the real
server."""
import email
import email.policy
import hashlib
import os
import pathlib
import tempfile
import unittest

from support import WithServer, box_gltf, box_obj, caught, main, pixel_png
from fracture_client.upload import Upload, mesh_id


def sha(data):
    return hashlib.sha256(data).hexdigest()


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "asset"
        self.folder.mkdir()

    def write(self, name, content):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        return path


class Files(Folder):
    def names(self, path, **options):
        return [name for name, _ in Upload.of(path, **options).files]

    def test_an_obj_brings_its_libraries_and_their_textures(self):
        self.write("a.mtl", b"newmtl m\r\nmap_Kd -s 1 1 1 tex/wood.png\r\n  bump my bump.png \nmap_Ks gone.png\nKd 1 1 1\n")
        self.write("tex/wood.png", b"w")
        self.write("my bump.png", b"b")
        self.write("unrelated.png", b"u")
        path = self.write("mesh.OBJ", box_obj(extra="mtllib a.mtl\nmtllib nowhere.mtl"))
        self.assertEqual(self.names(path), ["a.mtl", "my bump.png", "tex/wood.png"])
        self.assertEqual(self.names(str(path), files=()), [])

    def test_a_gltf_brings_buffers_and_images(self):
        text, buffer = box_gltf("d%C3%A4ta/box%201.bin")
        self.write("d\u00e4ta/box 1.bin", buffer)
        self.assertEqual(self.names(self.write("box.gltf", text)), ["d\u00e4ta/box 1.bin"])
        embedded, _ = box_gltf("data:application/octet-stream;base64,AAAA")
        self.assertEqual(self.names(self.write("embedded.gltf", embedded)), [])
        for damaged in (b"", b"{", b"[]", b'{"buffers": 5, "images": [7, {"uri": 7}]}', b"glTF"):
            self.assertEqual(self.names(self.write("damaged.gltf", damaged)), [])

    def test_nothing_outside_of_the_folder_is_sent(self):
        secret = self.folder.parent / "secret.mtl"
        secret.write_bytes(b"secret")
        os.symlink(secret, self.folder / "link.mtl")
        for name in ("../secret.mtl", str(secret), "link.mtl", "sub/../../secret.mtl", "..\\secret.mtl", "."):
            self.assertEqual(self.names(self.write("m.obj", f"mtllib {name}\n".encode())), [], name)
        self.write("secret.mtl", b"own")  # only the last component of a name that leads outside is looked up
        upload = Upload.of(self.write("m.obj", f"mtllib {secret}\n".encode()))
        self.assertEqual(upload.files, (("secret.mtl", b"own"),))

    def test_files_may_be_given_as_paths_or_by_name(self):
        path = self.write("deep/x.bin", b"1")
        self.assertEqual(Upload.of(b"{}", [path], "gltf").files, (("x.bin", b"1"),))
        self.assertEqual(Upload.of(b"{}", {"y/x.bin": path, "z": b"2"}, "gltf").files, (("y/x.bin", b"1"), ("z", b"2")))
        self.assertEqual(caught(Upload.of, b"{}", {"a\r\nb": b""}, "gltf").parameter, "files")
        self.assertEqual(caught(Upload.of, b"{}", {str(k): b"" for k in range(255)}, "gltf").parameter, "files")
        with self.assertRaises(FileNotFoundError):
            Upload.of(self.folder / "gone.obj")

    def test_the_format_is_that_of_the_ending_or_of_the_first_bytes(self):
        self.assertEqual(Upload.of(b"glTFabc").format, "glb")
        self.assertEqual(Upload.of(b"v 0 0 0").format, "")
        self.assertEqual(Upload.of(self.write("a.PLY", b"ply")).format, "ply")
        self.assertEqual(Upload.of(self.write("b.glb", b"solid"), format="stl").format, "stl")
        self.assertEqual(Upload.of(b"", format="ply").query, {"format": "ply"})
        self.assertEqual(Upload.of(b"", format="obj").query, {})


class Key(unittest.TestCase):
    def test_of_one_file_it_is_its_digest(self):
        self.assertEqual(Upload.of(b"abc").id, "sha256:" + sha(b"abc"))

    def test_of_several_it_is_that_of_the_list_in_the_interface(self):
        """The list follows the description of PUT /meshes/{id}."""
        upload = Upload.of(b"m", {"b": b"2", "\u00e4 x": b"3", "a": b"1"}, "gltf")
        text = "files\n" + sha(b"m") + "\n" + "1 a " + sha(b"1") + "\n" + "1 b " + sha(b"2") + "\n" + \
            "4 \u00e4 x " + sha(b"3") + "\n"
        self.assertEqual(upload.id, "sha256:" + sha(b"fracture files 2\n" + sha(text.encode()).encode()))
        self.assertNotEqual(upload.id, mesh_id(b"m"))

    def test_the_form_is_read_back_by_another_reader(self):
        upload = Upload.of(b"\0mesh\r\n--", {'qu"ote\\.bin': b"\r\n\0", "\u00e4.png": b""}, "gltf")
        kind, body = upload.form({"sites": 5})
        message = email.message_from_bytes(f"Content-Type: {kind}\r\n\r\n".encode() + body, policy=email.policy.HTTP)
        parts = [(p.get_param("name", header="content-disposition"), p.get_content_type(), p.get_payload(decode=True))
                 for p in message.iter_parts()]
        self.assertEqual(parts, [("params", "application/json", b'{"sites":5}'), ("mesh", "model/gltf+json", b"\0mesh\r\n--"),
                                 ("file", "application/octet-stream", b"\r\n\0"), ("file", "application/octet-stream", b"")])


class Real(Folder, WithServer):
    def test_an_obj_with_its_material_and_texture(self):
        self.write("a.mtl", b"newmtl painted\nmap_Kd tex/pixel.png\n")
        self.write("tex/pixel.png", pixel_png())
        mesh = self.client.put(self.write("b.obj", box_obj(extra="mtllib a.mtl\nusemtl painted")))
        self.assertEqual((mesh.stored["files"], mesh.stored["id"]), (2, mesh.id))
        self.assertEqual((mesh.report["verdict"], mesh.report["materials"], mesh.report["images"]), ("closed", ["painted"], 1))
        answer = mesh.fracture(sites=8)
        self.assertIn("painted", {name for fragment in answer.fragments for name in fragment.materials})
        self.assertAlmostEqual(sum(fragment.volume for fragment in answer.fragments), 1, places=9)

    def test_a_gltf_whose_buffer_has_a_name_with_everything_in_it(self):
        name = "b\u00f6x \"1\" \u6728.bin"
        text, buffer = box_gltf("sub/b%C3%B6x%20%221%22%20%E6%9C%A8.bin")
        self.write("sub/" + name, buffer)
        path = self.write("\u6728 b\u00f6x.gltf", text)
        mesh = self.client.put(path)
        self.assertEqual((mesh.stored["id"], mesh.report["solid"]["volume"]), (mesh.id, 1))
        same = self.client.put(text, files={"sub/" + name: buffer}, format="gltf")
        self.assertEqual(same.id, mesh.id)
        self.assertEqual(mesh.fracture(sites=4).certificate["fragments"], 4)

    def test_a_missing_buffer_is_refused_in_the_servers_words(self):
        text, _ = box_gltf("gone.bin")
        error = caught(self.client.put, self.write("m.gltf", text))
        self.assertEqual(error.status, 422)
        self.assertIn("gone.bin", error.detail)

    def test_formats_by_ending_and_by_name(self):
        off = ["OFF", "4 4 0", "0 0 0", "1 0 0", "0 1 0", "0 0 1", "3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3", ""]
        path = self.write("tetrahedron.off", "\n".join(off).encode())
        self.assertAlmostEqual(self.client.put(path).report["solid"]["volume"], 1 / 6, places=12)
        in_cm = self.client.inspect(path.read_bytes(), format="off", unit="cm")["solid"]["volume"]
        self.assertAlmostEqual(in_cm * 6e6, 1, places=6)  # coordinates are floats
        self.assertEqual(caught(self.client.put, path.read_bytes() + b"\n").type, "unknown-format")  # a mesh that is not known yet
        self.assertEqual(caught(self.client.put, self.write("mesh.xyz", b"what is it")).type, "unknown-format")

    def test_a_mesh_that_is_none_is_refused(self):
        self.assertEqual(caught(self.client.put, b"", format="obj").type, "empty-body")
        self.assertEqual(caught(self.client.put, b"glTF" + bytes(30)).status, 422)
        self.assertEqual(caught(self.client.put, b"v 0 0 0\n", format="obj").type, "empty-mesh")

    def test_a_body_over_the_limit_is_refused_in_the_servers_words(self):
        limit = self.client.limits()["max_body_bytes"]
        error = caught(self.client.put, bytes(limit + 1), format="stl")
        self.assertEqual((error.type, error.status), ("body-too-large", 413))
        self.assertIn(f"{limit:,}", error.detail)


if __name__ == "__main__":
    main()
