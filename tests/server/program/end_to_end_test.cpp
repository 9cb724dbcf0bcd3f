// The real program as a separate process: real meshes over HTTP, bad input, bake compared with serve, and
// signals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

/// An axis-aligned unit cube, closed, as OBJ text.

struct EndToEnd : testing::Test {
  fs::path folder = fs::temp_directory_path() / ("fracture_end_to_end_" + std::to_string(::getpid()));
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  std::string write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return (folder / name).string();
  }
  static std::string read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(EndToEnd, ACubeComesBackAsFragmentsThatAddUpToIt) {
  ServeProcess server;
  const Reply reply =
      ask(server.port, "POST", "/fracture?sites=20&seed=5", kObj + "Accept: application/json\r\n", kCube);
  ASSERT_EQ(reply.status, 200) << reply.body;
  const auto certificate = reply.json().at("certificate");
  EXPECT_EQ(certificate.at("open_edges"), 0);
  EXPECT_GE(certificate.at("fragments"), 20);
  EXPECT_DOUBLE_EQ(certificate.at("volume_in"), 1.0);
  EXPECT_NEAR(certificate.at("volume_out").get<double>(), 1.0, 1e-9);
  EXPECT_EQ(reply.json().at("parameters").at("seed"), 5);
  EXPECT_EQ(reply.json().at("parameters").at("sites"), 20);
  EXPECT_EQ(
      reply.json().at("report").at("frame"),
      nlohmann::json::parse(R"({"metres_per_unit":1.0,"unit_from":"assumed","up":"y","up_from":"assumed"})"));
  EXPECT_EQ(reply.json().at("report").at("solid").at("open_edges"), 0);
  EXPECT_GE(reply.json().at("bonds").at("area").size(), 19u);
}

TEST_F(EndToEnd, BakeAndServeGiveTheSameBytesForAnyNumberOfThreads) {
  const std::string mesh = write("cube.obj", kCube);
  std::string reference;
  for (const char* threads : {"1", "2", "5"}) {
    const std::string out = (folder / "out.glb").string();
    Process bake({"bake", mesh, "-o", out, "--sites", "200", "--seed", "9", "--threads", threads});
    ASSERT_EQ(bake.wait(), 0);
    if (reference.empty()) reference = read(out);
    EXPECT_EQ(read(out), reference) << threads << " threads";
  }
  EXPECT_EQ(reference.substr(0, 4), "glTF");
  ServeProcess server;
  EXPECT_EQ(ask(server.port, "POST", "/fracture?sites=200&seed=9", kObj, kCube).body, reference);
  EXPECT_TRUE(fs::exists(folder / "out.glb"));
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_EQ(entry.path().string().find(".tmp"), std::string::npos);
}

TEST_F(EndToEnd, AHitOnAnEarlierAnswerSaysWhatItChangedAndIsTheSameFromNothing) {
  const std::string hit = R"("local_point": [1, 1, 1], "local_radius": 0.3, "local_sites": 6})";
  const std::string json = "Content-Type: application/json\r\n";
  nlohmann::json parameters;
  std::string bytes;
  {
    ServeProcess server;
    const std::string path =
        "/meshes/" + ask(server.port, "POST", "/meshes", kObj, kCube).json().at("id").get<std::string>() +
        "/fracture";
    const Reply first = ask(server.port, "POST", path, json, R"({"sites": 30})");
    ASSERT_EQ(first.status, 200) << first.body;
    const std::string of = R"({"of": ")" + first.header("content-location") + "\", ";
    const Reply second = ask(server.port, "POST", path, json, of + hit);
    ASSERT_EQ(second.status, 200) << second.body;
    const Reply figures = ask(server.port, "POST", path, json + "Accept: application/json\r\n", of + hit);
    EXPECT_GE(figures.json().at("delta").at("new").size(), 6u);
    parameters = figures.json().at("parameters");
    // Once more, with the answer that the server has kept.
    const Reply third =
        ask(server.port, "POST", path, json,
            R"({"of": ")" + second.header("content-location") + R"(", "delta": "only", )" + hit);
    ASSERT_EQ(third.status, 200) << third.body;
    EXPECT_NE(third.header("cache-status").find("diagram; hit"), std::string::npos)
        << third.header("cache-status");
    const Reply whole = ask(server.port, "POST", path, json,
                            R"({"of": ")" + second.header("content-location") + "\", " + hit);
    EXPECT_LT(third.body.size(), whole.body.size());
    bytes = second.body;
  }
  ServeProcess fresh;
  const auto part = [](const std::string& disposition, const std::string& body) {
    return "--B\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + body + "\r\n";
  };
  const Reply from_nothing =
      ask(fresh.port, "POST", "/fracture", "Content-Type: multipart/form-data; boundary=B\r\n",
          part("name=mesh; filename=cube.obj", kCube) + part("name=params", parameters.dump()) + "--B--");
  EXPECT_EQ(from_nothing.status, 200);
  EXPECT_EQ(from_nothing.body, bytes);
}

TEST_F(EndToEnd, AnAssetOfSeveralFilesIsTheSameThroughAFormAndThroughBake) {
  const std::string obj = "mtllib parts/cube.mtl\nusemtl red\n" + kCube, mtl = "newmtl red\nKd 1 0 0\n";
  fs::create_directories(folder / "asset" / "parts");
  write("asset/parts/cube.mtl", mtl);
  const std::string out = (folder / "out.glb").string();
  Process bake({"bake", write("asset/cube.obj", obj), "-o", out, "--sites", "6"});
  ASSERT_EQ(bake.wait(), 0);
  const std::string baked = read(out);
  EXPECT_NE(baked.find("\"name\":\"red\""), std::string::npos);
  ServeProcess server;
  const auto part = [](const std::string& disposition, const std::string& body) {
    return "--B\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + body + "\r\n";
  };
  const std::string mesh = part("name=mesh; filename=cube.obj", obj), sites = part("name=sites", "6"),
                    library = part("name=file; filename=\"parts/cube.mtl\"", mtl),
                    type = "Content-Type: multipart/form-data; boundary=B\r\n";
  EXPECT_EQ(ask(server.port, "POST", "/fracture", type, mesh + library + sites + "--B--").body, baked);
  EXPECT_EQ(ask(server.port, "POST", "/fracture", type, library + sites + mesh + "--B--").body, baked);
  EXPECT_NE(ask(server.port, "POST", "/fracture", type, mesh + sites + "--B--").body, baked);
}

TEST_F(EndToEnd, BakeReadsNothingOutsideTheFolderOfItsInput) {
  fs::create_directories(folder / "asset");
  write("secret.bin", std::string(42, 'x'));
  const std::string outside = (folder / "secret.bin").string();
  fs::create_symlink(folder / "secret.bin", folder / "asset" / "link.bin");
  for (const std::string& uri : {std::string("../secret.bin"), std::string("%2e%2e/secret.bin"), outside,
                                 std::string("link.bin"), "file://" + outside}) {
    const std::string gltf =
        write("asset/a.gltf",
              R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":42,"uri":")" + uri + R"("}]})");
    Process bake({"bake", gltf, "-q", "-o", (folder / "out.glb").string()});
    EXPECT_NE(bake.error_line().find("external-resource"), std::string::npos) << uri;
    EXPECT_EQ(bake.wait(), 3) << uri;
  }
}

TEST_F(EndToEnd, SimultaneousRequestsGetTheirOwnAnswers) {
  ServeProcess server;
  std::vector<std::string> alone, together(12);
  for (int i = 0; i < 12; ++i)
    alone.push_back(
        ask(ServeProcess().port, "POST", "/fracture?sites=30&seed=" + std::to_string(i), kObj, kCube).body);
  std::vector<std::thread> threads;
  for (int i = 0; i < 12; ++i)
    threads.emplace_back([&, i] {
      together[static_cast<std::size_t>(i)] =
          ask(server.port, "POST", "/fracture?sites=30&seed=" + std::to_string(i), kObj, kCube).body;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(together, alone);
}

TEST_F(EndToEnd, BadInputGetsAStatusAndAProblemAPersonCanActOnAndTheProcessLives) {
  ServeProcess server({"--max-body", "100000"});
  const std::string glb = ask(server.port, "POST", "/fracture?sites=4", kObj, kCube).body;
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  const std::string type_glb = "Content-Type: model/gltf-binary\r\n";
  std::string nan_stl(84 + 50, '\0');
  nan_stl[80] = 1;
  for (std::size_t at = 84; at < 84 + 48; at += 4) nan_stl.replace(at, 4, std::string("\x00\x00\xc0\x7f", 4));
  const struct {
    const char* what;
    std::string target, fields, body;
    int status;
    const char* problem;
  } cases[] = {
      {"empty body", "/fracture", type_glb, "", 400, "empty-body"},
      {"truncated GLB", "/fracture", type_glb, glb.substr(0, glb.size() / 2), 422, "malformed-mesh"},
      {"GLB of which only the header is left", "/fracture", type_glb, glb.substr(0, 12), 422,
       "malformed-mesh"},
      {"text file called .glb", "/fracture?format=glb", "", "This is not a mesh.\n", 422, "malformed-mesh"},
      {"NaN in an OBJ", "/fracture", kObj, "v nan 0 0\n" + kCube.substr(8), 422, ""},
      {"NaN in an STL", "/fracture?format=stl", "", nan_stl, 422, "not-finite"},
      {"sites=0", "/fracture?sites=0", kObj, kCube, 400, "bad-parameter"},
      {"sites=-5", "/fracture?sites=-5", kObj, kCube, 400, "bad-parameter"},
      {"sites=1e12", "/fracture?sites=1e12", kObj, kCube, 400, "bad-parameter"},
      {"unknown parameter", "/fracture?size=5", kObj, kCube, 400, "unknown-parameter"},
      {"unknown format", "/fracture?format=docx", "", kCube, 415, "unknown-format"},
      {"a format that is off", "/fracture?format=blend", "", "BLENDER", 415, "unknown-format"},
      {"body over the limit", "/fracture", kObj, std::string(100'001, ' '), 413, "body-too-large"},
      {"one open quad", "/fracture", kObj, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", 422,
       "mesh-not-closed"},
      {"an OBJ without faces", "/fracture", kObj, "v 0 0 0\nv 1 0 0\n", 422, ""},
      {"a glTF that names a local file", "/fracture", "Content-Type: model/gltf+json\r\n",
       R"({"asset":{"version":"2.0"},"buffers":[{"uri":"/etc/passwd","byteLength":100}]})", 422,
       "external-resource"},
  };
  for (const auto& c : cases) {
    const Reply reply = ask(server.port, "POST", c.target, c.fields, c.body);
    EXPECT_EQ(reply.status, c.status) << c.what << ": " << reply.body;
    EXPECT_EQ(reply.header("content-type"), "application/problem+json") << c.what;
    if (*c.problem) {
      EXPECT_EQ(reply.problem(), c.problem) << c.what << ": " << reply.body;
    }
    EXPECT_GE(reply.json().value("detail", "").size(), 20u) << c.what << ": " << reply.body;
    EXPECT_TRUE(server.alive()) << c.what;
  }
  EXPECT_EQ(ask(server.port, "POST", "/fracture?sites=4", kObj, kCube).body, glb)
      << "the same process, the same bytes";
}

TEST_F(EndToEnd, SigtermDrainsAndExitsWithZero) {
  ServeProcess server({"--drain-delay", "60"});
  EXPECT_EQ(ask(server.admin_port, "GET", "/readyz").status, 200);
  RawClient kept(server.port);
  kept.send("GET /version HTTP/1.1\r\nHost: a\r\n\r\n");
  ASSERT_TRUE(kept.receive());
  server.signal(SIGTERM);
  // A thread of the server handles the signal, and must be scheduled first.
  require_eventually(kPatience, "the server to take the signal",
                     [&] { return ask(server.admin_port, "GET", "/readyz").status != 200; });
  EXPECT_EQ(ask(server.admin_port, "GET", "/readyz").status, 503);
  EXPECT_EQ(ask(server.port, "POST", "/fracture?sites=4", kObj, kCube).status, 200)
      << "within the drain delay";
  server.signal(SIGTERM);  // a second signal skips the rest of the delay
  EXPECT_EQ(server.wait(), 0);
  EXPECT_EQ(kept.receive_all(), "");
}

TEST_F(EndToEnd, AWorkingRequestIsFinishedAfterSigint) {
  ServeProcess server;
  RawClient client(server.port);
  client.send("POST /fracture?sites=3000 HTTP/1.1\r\nHost: a\r\n" + kObj +
              "Content-Length: " + std::to_string(kCube.size()) + "\r\n\r\n" + kCube);
  // pause: the signal comes when the header may or may not have been read
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  server.signal(SIGINT);
  // If the header was read before the signal came, the request is answered.
  const auto reply = client.receive();
  if (reply) {
    EXPECT_EQ(reply->status, 200);
  }
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(EndToEnd, ATakenPortIsSaidAndEndsWithOne) {
  ServeProcess server;
  Process second({"serve", "--port", std::to_string(server.port), "--admin-port", "0"});
  const std::string line = second.error_line_with(std::to_string(server.port));
  EXPECT_EQ(second.wait(), 1);
  EXPECT_NE(line.find(std::to_string(server.port)), std::string::npos) << line;
}

/// A cube as STL text, which has no unit.
std::string stl_of_size(int side) {
  const int corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                             {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                           {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::string text = "solid cube\n";
  for (const auto& face : faces)
    for (const auto& triangle : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int k : triangle) {
        text += "vertex";
        for (const int coordinate : corners[face[k]]) text += " " + std::to_string(coordinate * side);
        text += "\n";
      }
      text += "endloop\nendfacet\n";
    }
  return text + "endsolid cube\n";
}

TEST_F(EndToEnd, InspectSaysWhatAMeshIsWorthByItsExitStatusAndAsJson) {
  const std::string lid = "f 1 4 3 2\n",
                    open_box = std::string(kCube).replace(kCube.find(lid), lid.size(), "");
  const std::string closed = write("cube.obj", kCube), open = write("open.obj", open_box),
                    quad = write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const struct {
    std::vector<std::string> arguments;
    int code;
    const char* verdict;
  } cases[] = {
      {{"inspect", closed, "--json"}, 0, "closed"},
      {{"inspect", open, "--json"}, 5, "repaired"},
      {{"inspect", quad, "--json"}, 3, "refused"},
      {{"inspect", quad, "--json", "--thickness", "0.1"}, 5, "repaired"},
      {{"inspect", open, "--json", "--repair", "strict"}, 3, "refused"},
      {{"inspect", closed, "--json", "--sites", "0"}, 3, "refused"},
      {{"inspect", closed, "--json", "--nodes", "absent"}, 3, "refused"},
      {{"inspect", (folder / "absent.obj").string(), "--json"}, 1, ""},
      {{"inspect", closed, "--colour", "red"}, 2, ""},
      {{"inspect"}, 2, ""},
  };
  const fs::path out = folder / "out.json";
  for (const auto& c : cases) {
    Process inspect(c.arguments, out.string());
    EXPECT_EQ(inspect.wait(), c.code) << c.arguments.back();
    if (!*c.verdict) continue;
    const auto report = nlohmann::json::parse(read(out), nullptr, false);
    ASSERT_TRUE(report.is_object()) << read(out);
    EXPECT_EQ(report.at("verdict"), c.verdict);
  }
  Process figures({"inspect", open, "--json", "--unit", "cm", "--up", "z"}, out.string());
  EXPECT_EQ(figures.wait(), 5);
  const auto report = nlohmann::json::parse(read(out));
  EXPECT_NEAR(report.at("solid").at("volume").get<double>(), 1e-6, 1e-12);
  EXPECT_EQ(report.at("solid").at("open_edges"), 4);
  EXPECT_EQ(report.at("solid").at("holes_filled"), 1);
  EXPECT_EQ(report.at("frame").at("unit_from"), "request");
  EXPECT_EQ(report.at("choices").at(0).at("kind"), "lid");
  EXPECT_EQ(report.at("choices").at(0).at("parameters").at("thickness"), 0.0001) << "a hundredth of its side";
  EXPECT_EQ(report.at("estimate").at("fits"), true);
  EXPECT_GT(report.at("estimate").at("working_bytes"), 0);
  Process human({"inspect", closed}, out.string());
  EXPECT_EQ(human.wait(), 0);
  EXPECT_NE(read(out).find("closed solid as it is"), std::string::npos);
  EXPECT_NE(read(out).find("  estimate   50 fragments, "), std::string::npos) << read(out);
  Process large({"inspect", write("large.stl", stl_of_size(118))}, out.string());
  EXPECT_EQ(large.wait(), 0);
  EXPECT_NE(read(out).find("warning: The mesh is 118 m long"), std::string::npos) << read(out);
  EXPECT_NE(read(out).find("choice: --unit mm (unit): "), std::string::npos) << read(out);
}

TEST_F(EndToEnd, PartsThatAreNotAskedForPassThroughWhole) {
  const std::string two =
      "o left\n" + kCube +
      "o right\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nv 5 0 1\nv 6 0 1\nv 6 1 1\nv 5 1 1\n"
      "f 9 12 11 10\nf 13 14 15 16\nf 9 10 14 13\nf 10 11 15 14\nf 11 12 16 15\nf 12 9 13 16\n";
  const std::string out = (folder / "out.glb").string();
  Process bake({"bake", write("two.obj", two), "-q", "-o", out, "--sites", "5", "--nodes", "right"});
  ASSERT_EQ(bake.wait(), 0);
  const std::string file = read(out);
  std::uint32_t length = 0;
  std::memcpy(&length, file.data() + 12, 4);
  const auto document = nlohmann::json::parse(file.substr(20, length));
  std::size_t plain = 0, fragments = 0;
  for (const auto& node : document.at("nodes")) {
    if (!node.contains("mesh")) continue;
    const bool fragment = node.contains("extras") && node.at("extras").contains("fracture");
    fragments += fragment;
    if (fragment) {
      EXPECT_EQ(node.at("name").get<std::string>().rfind("right_", 0), 0u);
      continue;
    }
    if (node.at("name") != "left") continue;  // colliders have other names
    ++plain;
    EXPECT_FALSE(node.contains("extensions"));
    const auto& primitive =
        document.at("meshes").at(node.at("mesh").get<std::size_t>()).at("primitives").at(0);
    EXPECT_EQ(document.at("accessors").at(primitive.at("indices").get<std::size_t>()).at("count"), 36);
  }
  EXPECT_EQ(plain, 1u);
  EXPECT_GE(fragments, 5u);
  const auto& figures = document.at("nodes").at(0).at("extras").at("fracture");
  EXPECT_EQ(figures.at("report").at("passed_through").at("triangles"), 12);
  EXPECT_NEAR(figures.at("certificate").at("volume_in").get<double>(), 1, 1e-12);
}

TEST_F(EndToEnd, BakeSaysWhatIsWrongAndLeavesNoFile) {
  const std::string quad = write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const std::string cube = write("cube.obj", kCube);
  const std::string out = (folder / "out.glb").string();
  const struct {
    std::vector<std::string> arguments;
    int code;
  } cases[] = {
      {{"bake", quad, "-o", out}, 3},
      {{"bake", cube, "-o", out, "--sites", "0"}, 3},
      {{"bake", cube, "-o", out, "--dual", "triangle"}, 3},
      {{"bake", cube, "-o", out, "--format", "glb"}, 3},
      {{"bake", (folder / "absent.obj").string(), "-o", out}, 1},
      {{"bake", cube, "-o", cube + "/below/a/file.glb"}, 1},
      {{"bake", cube}, 2},
      {{"bake", cube, "-o", out, "--colour", "red"}, 2},
      {{"dance"}, 2},
  };
  for (const auto& c : cases) {
    Process bake(c.arguments);
    const std::string line = bake.error_line();
    EXPECT_EQ(bake.wait(), c.code) << line;
    EXPECT_FALSE(fs::exists(out));
  }
}

}  // namespace
}  // namespace fracture::test
