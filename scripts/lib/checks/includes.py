"""A file includes what it uses (alone.py), and a target includes only what it declares: each `#include` must match a dependency
in CMake.

In common/, server/ and client/, a file may include a header of another folder only if its own target lists that header's target
in DEPS (or in target_link_libraries). An indirect dependency is not enough. For third-party headers, and for
includes of tests, an indirect dependency is enough. Every .cpp file in these folders must belong to a target.

The check reads these commands from the text of CMakeLists.txt: fracture_library, fracture_test, fracture_fuzz, add_library,
add_executable, target_link_libraries.
"""
import posixpath
import re

from . import alone

INCLUDE = re.compile(r'\s*#\s*include\s+(?:"([^"]+)"|<([^>]+)>)')
PRODUCT = ("common/", "server/", "client/")

# The libraries that a third-party header requires: the target or one of its dependencies must link to one of these names.
ELSEWHERE = {
    "boost/": ("Boost::headers",), "nlohmann/": ("nlohmann_json::nlohmann_json",), "openssl/": ("OpenSSL::Crypto", "OpenSSL::SSL"),
    "spdlog/": ("spdlog::spdlog",), "prometheus/": ("${FRACTURE_PROMETHEUS}",), "CLI/": ("CLI11::CLI11",),
    "zstd.h": ("${FRACTURE_ZSTD}", "PkgConfig::zstd"), "zlib.h": ("ZLIB::ZLIB",), "hiredis/": ("PkgConfig::hiredis",),
    "jemalloc/": ("PkgConfig::jemalloc",),
    "xxhash.h": ("PkgConfig::xxhash",), "seccomp.h": ("${FRACTURE_SECCOMP}",), "assimp/": ("assimp::assimp",),
    "draco/": ("draco::draco",), "meshoptimizer.h": ("meshoptimizer::meshoptimizer",), "tiny_gltf.h": ("fracture_tinygltf",),
    "libqhull_r/": ("${FRACTURE_QHULL_LIBRARY}",), "glm/": ("glm::glm",), "epoxy/": ("PkgConfig::FRACTURE_EPOXY",),
    "stb/": ("${FRACTURE_STB}",), "webp/": ("${FRACTURE_WEBP}",), "imgui": ("PkgConfig::FRACTURE_WINDOW",), "GLFW/": ("PkgConfig::FRACTURE_WINDOW",),
    "bt": ("PkgConfig::FRACTURE_BULLET",), "BulletCollision/": ("PkgConfig::FRACTURE_BULLET",),
}
KEYWORDS = {"PUBLIC", "PRIVATE", "INTERFACE", "STATIC", "SHARED", "OBJECT", "ALIAS"}


class Target:
    def __init__(self, name, lists):
        self.name, self.lists = name, lists
        self.sources, self.public, self.private = [], [], []


def commands(text):
    """Yields (name, arguments) for each command, without comments and quotes."""
    text = re.sub(r"#[^\n]*", "", text)
    for match in re.finditer(r"(\w+)\s*\(((?:[^()]|\([^()]*\))*)\)", text):
        yield match.group(1).lower(), [word.strip('"') for word in match.group(2).split()]


def real(name):
    return name.replace("fracture::", "fracture_") if name.startswith("fracture::") else name


def keyed(arguments, keys):
    """Returns the arguments after each key, as cmake_parse_arguments does."""
    found, key = {key: [] for key in keys}, None
    for word in arguments:
        if word in keys:
            key = word
        elif key:
            found[key].append(word)
    return found


def read_targets(checkout):
    targets = {}
    for lists in checkout.files:
        if posixpath.basename(lists) != "CMakeLists.txt" or lists.startswith("common/cmake/example/"):
            continue
        folder = posixpath.dirname(lists)
        for command, words in commands(checkout.read(lists)):
            if command in ("fracture_library", "fracture_test", "fracture_fuzz") and words:
                name = "fracture_" + words[0] if command == "fracture_library" else words[0]
                parts = keyed(words[1:], ("SOURCES", "REPLAY", "DEPS", "LABELS", "TIMEOUT"))
                target = targets.setdefault(name, Target(name, lists))
                target.sources += parts["SOURCES"] + parts["REPLAY"]
                target.sources += [name + ".cpp"] if command == "fracture_fuzz" else []
                (target.public if command == "fracture_library" else target.private).extend(map(real, parts["DEPS"]))
            elif command in ("add_library", "add_executable") and len(words) > 1 and "ALIAS" not in words:
                target = targets.setdefault(words[0], Target(words[0], lists))
                target.sources += [word for word in words[1:] if word not in KEYWORDS]
            elif command == "target_link_libraries" and words and real(words[0]) in targets:
                target, kind = targets[real(words[0])], "PUBLIC"
                for word in words[1:]:
                    if word in KEYWORDS:
                        kind = word
                    else:
                        (target.private if kind == "PRIVATE" else target.public).append(real(word))
        for target in targets.values():
            if target.lists == lists:
                target.sources = [posixpath.normpath(s if s.startswith(folder + "/") else posixpath.join(folder, s))
                                  for s in target.sources if not s.startswith("${")]
    return targets


def reachable(targets, target):
    """Returns all targets visible to a target: itself, the targets that it links, and their public dependencies."""
    seen, todo = {target.name}, target.public + target.private
    while todo:
        name = todo.pop()
        if name not in seen:
            seen.add(name)
            todo += targets[name].public if name in targets else []
    return seen


def check(checkout, every):
    return undeclared_edges(checkout) + alone.check(checkout, every)


def undeclared_edges(checkout):
    targets = read_targets(checkout)
    of_source, of_folder = {}, {}
    for target in targets.values():
        for source in target.sources:
            of_source.setdefault(source, []).append(target)
            of_folder.setdefault(posixpath.dirname(source), set()).add(target.name)

    def owners(path):
        """Returns the targets that a file may belong to. A header belongs to the target of its source file, if it has one."""
        own = of_source.get(re.sub(r"\.hpp$", ".cpp", path))
        return {target.name for target in own} if own else of_folder.get(posixpath.dirname(path), set())

    offences = []
    for name in checkout.named(".cpp", ".hpp"):
        product = name.startswith(PRODUCT)
        if not product and not (name.startswith("tests/") and name.endswith(".cpp")):
            continue
        users = [targets[user] for user in sorted(owners(name))]
        if not users:
            if name.endswith(".cpp") and product and not name.startswith("common/cmake/"):
                offences.append(f"{name}:1: no CMakeLists.txt compiles it")
            continue
        for number, line in enumerate(checkout.lines(name), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            ours, foreign = match.groups()
            if ours and ours.startswith(PRODUCT):
                wanted = owners(ours)
            else:
                wanted = next((set(libraries) for prefix, libraries in ELSEWHERE.items()
                               if (foreign or "").startswith(prefix)), set())
            if not wanted or (ours and posixpath.dirname(ours) == posixpath.dirname(name)):
                continue
            direct = bool(ours) and product

            def sees(user):
                return wanted & ({user.name, *user.public, *user.private} if direct else reachable(targets, user))

            # If several targets share a header, it is enough that one of them sees it.
            if not any(map(sees, users)) if name.endswith(".hpp") else not all(map(sees, users)):
                user = next(user for user in users if not sees(user))
                offences.append(f"{name}:{number}: includes {ours or foreign}, but {user.name} ({user.lists}) does not declare "
                                f"{' or '.join(sorted(wanted))}")
    return offences
