# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip file: its contents, that Blender installs it into an empty folder, that it works from there, and its presets.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, add_cube  # noqa: E402

SOURCE = support.ROOT / "client" / "blender"


class Packed(InBlender):
    def test_it_runs_from_the_folder_of_the_user_with_everything_inside(self):
        folder = pathlib.Path(os.environ["BLENDER_USER_RESOURCES"]).resolve()
        for module in ("fracture_blender.run", "fracture_blender.fracture_client.client"):
            self.assertIn(folder, pathlib.Path(sys.modules[module].__file__).resolve().parents)
        self.assertNotIn("fracture_client", sys.modules)
        add_cube()
        made, = self.fracture(material="stone", fragments=10)
        self.assertAlmostEqual(len(support.fragments_of(made)), 10, delta=1)

    def test_every_file_has_its_licence_and_none_is_binary(self):
        with zipfile.ZipFile(os.environ["FRACTURE_TEST_ZIP"]) as packed:
            names = packed.namelist()
            self.assertIn("fracture_blender/blender_manifest.toml", names)
            self.assertIn("fracture_blender/fracture_client/LICENSE", names)
            for name in names:
                text = packed.read(name).decode("utf-8")
                if "fracture_client" not in name and not name.endswith(".json"):
                    self.assertTrue(text.startswith("# SPDX-License-Identifier: GPL-3.0-or-later\n"), name)
        self.assertEqual({name.split("/")[0] for name in names}, {"fracture_blender"})
        self.assertFalse([name for name in names if "__pycache__" in name])
        for source in (SOURCE / "fracture_blender").glob("*.py"):
            self.assertIn(f"fracture_blender/{source.name}", names)

    def test_packing_again_gives_the_same_bytes(self):
        again = pathlib.Path(bpy.app.tempdir) / "again.zip"
        python = os.environ["FRACTURE_TEST_PYTHON"]
        subprocess.run([python, str(SOURCE / "pack.py"), "--describe", os.environ["FRACTURE_TEST_SERVER"], str(again)], check=True)
        self.assertEqual(again.read_bytes(), pathlib.Path(os.environ["FRACTURE_TEST_ZIP"]).read_bytes())

    def test_the_program_of_the_readme(self):
        """Runs in a separate Blender, from an empty folder with the zip file. Only the server's address is changed."""
        readme = (SOURCE / "README.md").read_text(encoding="utf-8")
        program = re.search(r"```python\n(.*?)```", readme, re.DOTALL).group(1)
        self.assertLessEqual(len(program.strip().splitlines()), 10)
        folder = pathlib.Path(bpy.app.tempdir) / "new user"
        folder.mkdir()
        shutil.copy(os.environ["FRACTURE_TEST_ZIP"], folder / "fracture_blender.zip")
        enable = 'bpy.ops.preferences.addon_enable(module="fracture_blender")\n'
        self.assertIn(enable, program)
        address = f'bpy.context.preferences.addons["fracture_blender"].preferences.url = "{self.server.url}"\n'
        (folder / "break.py").write_text(program.replace(enable, enable + address), encoding="utf-8")
        environment = {**os.environ, "PWD": str(folder), "BLENDER_USER_RESOURCES": str(folder / "user")}  # the program uses PWD
        command = [bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python", "break.py"]
        done = subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                              timeout=2 * support.PATIENCE)
        self.assertEqual(done.returncode, 0, done.stdout)
        shown = re.search(r"\$ blender --background.*?\n((?:    .*\n)+)", readme).group(1)
        for line in (line.strip() for line in shown.splitlines()):  # the README's transcript matches today's output
            self.assertIn(line.split(";")[0], done.stdout)
        bpy.ops.wm.open_mainfile(filepath=str(folder / "broken.blend"))
        self.assertEqual(sum("fracture_volume" in item for item in bpy.data.objects), 60)

    def test_the_versions_of_manifest_and_bl_info_are_one(self):
        module = support.install()
        manifest = (SOURCE / "fracture_blender" / "blender_manifest.toml").read_text(encoding="utf-8")
        self.assertIn('\nversion = "{}.{}.{}"\n'.format(*module.bl_info["version"]), manifest)
        self.assertIn(f'\nname = "{module.bl_info["name"]}"\n', manifest)

    def test_without_a_description_it_is_asked_for_at_the_first_fracture(self):
        properties = support.part("properties")
        self.addCleanup(properties.use, properties.Known.description)
        properties.use(None)
        add_cube()
        self.assertEqual(bpy.ops.object.fracture_exact(), {"FINISHED"})
        self.assertGreater(len(properties.Known.parameters), 80)
        self.assertEqual(bpy.context.scene.fracture_parameters.material, "stone")
        kept = support.part("preferences").kept_description()
        self.assertEqual(kept.document, properties.Known.description.document)

    def test_disabling_takes_everything_away_and_enabling_brings_it_back(self):
        bpy.ops.preferences.addon_disable(module=support.NAME)
        self.assertFalse(hasattr(bpy.types.Scene, "fracture_parameters") or hasattr(bpy.types.Scene, "fracture_settings"))
        bpy.ops.preferences.addon_enable(module=support.NAME)
        self.assertTrue(bpy.context.scene.fracture_parameters.use_material)


class Presets(InBlender):
    def test_a_preset_keeps_values_and_switches(self):
        group, settings = bpy.context.scene.fracture_parameters, support.settings()
        support.give(material="brick", fragments=77, grain=(0, 0, 1))
        settings.strength = 0.5
        group.seed = 9
        group.use_seed = False
        self.assertEqual(bpy.ops.fracture.preset_add(name="Old wall"), {"FINISHED"})
        path, = pathlib.Path(bpy.utils.user_resource("SCRIPTS", path="presets")).glob("object.fracture_exact/*.py")
        support.give(seed=1)
        settings.strength = 3
        kind = support.part("presets").FRACTURE_PT_presets
        bpy.ops.script.execute_preset(filepath=str(path), menu_idname=kind.__name__)
        self.assertEqual((group.material, group.fragments, tuple(group.grain)), ("brick", 77, (0, 0, 1)))
        self.assertEqual((group.use_material, group.use_seed, group.seed, settings.strength), (True, False, 9, 0.5))
        self.assertEqual(support.part("properties").given(bpy.context.scene), {"material": "brick", "fragments": 77, "grain": [0, 1, 0]})
        self.assertEqual(bpy.ops.fracture.preset_add(name="Old wall", remove_name=True, remove_active=False), {"FINISHED"})


if __name__ == "__main__":
    support.main()
