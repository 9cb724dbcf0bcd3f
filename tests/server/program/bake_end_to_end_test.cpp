// bake of a folder as a process. It writes the same bytes in shards, one file at a time, through a server,
// and after bake or the server was killed halfway.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "tests/server/support/bake_folder.hpp"
#include "tests/server/support/child_process.hpp"
#include "tests/server/support/relay.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// The lines of a report, without the members that differ between two runs into two folders.
std::vector<nlohmann::json> without_times(const std::string& path, const std::string& folder) {
  std::vector<nlohmann::json> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    nlohmann::json json = nlohmann::json::parse(line);
    json.erase("seconds");
    const auto leave_out_folder = [&](nlohmann::json& place) {
      std::string text = place;
      place = text.erase(text.find("/" + folder + "/"), folder.size() + 1);
    };
    leave_out_folder(json.at("output"));
    if (json.contains("beside"))
      for (nlohmann::json& other : json.at("beside")) leave_out_folder(other.at("path"));
    lines.push_back(std::move(json));
  }
  return lines;
}

TEST(BakeOfAFolder, GivesTheSameBytesHoweverItIsDividedOrInterrupted) {
  const TemporaryFolder folder;
  constexpr int kMeshes = 24;
  write_meshes(folder, kMeshes);
  const auto bake = [&](const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> all{"bake", folder / "in", "-o", folder / out, "--sites", "300", "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  EXPECT_EQ(Process(bake("one", {"-j", "1"})).wait(), 3) << "the sheet is refused, and the exit code says so";
  const auto whole = outputs(folder / "one");
  EXPECT_EQ(whole.size(), static_cast<std::size_t>(kMeshes));
  EXPECT_FALSE(whole.contains("poison/sheet.obj.glb"));
  EXPECT_EQ(lines_in(folder / "one/bake.ndjson"), kMeshes + 1u);

  EXPECT_EQ(Process(bake("two", {"-j", "2", "--allow-refused", "1"})).wait(), 0);
  EXPECT_EQ(outputs(folder / "two"), whole);

  for (const char* shard : {"0/2", "1/2"})
    EXPECT_EQ(Process(bake("shards", {"--shard", shard, "--allow-refused", "1"})).wait(), 0);
  EXPECT_EQ(outputs(folder / "shards"), whole);

  {
    Process killed(bake("killed", {"-j", "2"}));
    require_eventually(kPatience, "three lines of the report",
                       [&] { return lines_in(folder / "killed/bake.ndjson") >= 3; });
    killed.signal(SIGKILL);
    killed.wait();
  }
  for (const auto& [name, bytes] : outputs(folder / "killed"))
    if (!name.ends_with(".part")) {
      EXPECT_EQ(bytes, whole.at(name)) << name;
    }
  EXPECT_EQ(Process(bake("killed", {"-j", "2", "--allow-refused", "1"})).wait(), 0);
  EXPECT_EQ(outputs(folder / "killed"), whole) << "nothing half-written is left";
}

/// A server behind a relay. The relay stays open while the server is killed and another one replaces it.
class Farm {
 public:
  void restart() {
    server_port_ = 0;
    server_->signal(SIGKILL);
    server_->wait();
    server_.emplace();
    server_port_ = server_->port;
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(door_.port()); }

 private:
  std::optional<ServeProcess> server_{std::in_place};
  std::atomic<std::uint16_t> server_port_{server_->port};
  FakeServer door_{[this](const FakeRequest& request) { return pass_on(request, server_port_); }};
};

TEST(BakeThroughAServer, GivesTheBytesOfALocalBakeAlsoWhereTheServerIsKilledMeanwhile) {
  const TemporaryFolder folder;
  constexpr int kMeshes = 16;
  write_meshes(folder, kMeshes);
  const auto arguments = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> all{"bake",    folder / "in",     "-o", folder / out, "--sites", "300",
                                 "--quiet", "--allow-refused", "1",  "-j",         "2"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  ASSERT_EQ(Process(arguments("local", {})).wait(), 0);
  const auto whole = outputs(folder / "local");
  ASSERT_EQ(whole.size(), static_cast<std::size_t>(kMeshes));

  Farm farm;
  const std::vector<std::string> through{"--server", farm.url(), "--patience", "3600"};
  ASSERT_EQ(Process(arguments("remote", through)).wait(), 0);
  EXPECT_EQ(outputs(folder / "remote"), whole);
  EXPECT_EQ(without_times(folder / "remote/bake.ndjson", "remote"),
            without_times(folder / "local/bake.ndjson", "local"))
      << "the same report";

  Process bake(arguments("restarted", through));
  require_eventually(kPatience, "three lines of the report",
                     [&] { return lines_in(folder / "restarted/bake.ndjson") >= 3; });
  farm.restart();
  EXPECT_EQ(bake.wait(), 0);
  EXPECT_EQ(outputs(folder / "restarted"), whole);
}

TEST(BakeThroughAServer, GivesGltfWhereAManifestAsksForIt) {
  const TemporaryFolder folder;
  write_meshes(folder, 2);
  folder.write("night.ndjson",
               "{\"input\": \"in/box1.obj\", \"output\": \"local.gltf\", \"parameters\": {\"sites\": 9}}\n");
  folder.write("farm.ndjson",
               "{\"input\": \"in/box1.obj\", \"output\": \"remote.gltf\", \"parameters\": {\"sites\": 9}}\n");
  EXPECT_EQ(Process({"bake", "--manifest", folder / "night.ndjson", "-q"}).wait(), 0);
  const Farm farm;
  EXPECT_EQ(Process({"bake", "--manifest", folder / "farm.ndjson", "-q", "--server", farm.url()}).wait(), 0);
  EXPECT_EQ(read_file(folder / "remote.gltf"), read_file(folder / "local.gltf"));
  EXPECT_TRUE(nlohmann::json::accept(read_file(folder / "local.gltf")));
}

TEST(BakeThroughAServer, WritesEveryFormatWithTheBytesOfALocalBake) {
  const TemporaryFolder folder;
  write_meshes(folder, 2);
  std::string lines;
  for (const char* ending : {"obj", "PLY", "stl"})
    lines += nlohmann::json{{"input", "../in/gltf/box.gltf"},
                            {"output", std::string("box.") + ending},
                            {"parameters", {{"sites", 9}}}}
                 .dump() +
             "\n";
  for (const char* name : {"local/m", "remote/m"}) {
    fs::create_directories(fs::path(folder / name).parent_path());
    folder.write(name, lines);
  }
  EXPECT_EQ(Process({"bake", "--manifest", folder / "local/m", "-q"}).wait(), 0);
  const Farm farm;
  EXPECT_EQ(Process({"bake", "--manifest", folder / "remote/m", "-q", "--server", farm.url()}).wait(), 0);
  auto local = outputs(folder / "local"), remote = outputs(folder / "remote");
  EXPECT_EQ(without_times(folder / "remote/m.report", "remote"),
            without_times(folder / "local/m.report", "local"));
  for (auto* files : {&local, &remote}) files->erase("m.report");
  EXPECT_EQ(local, remote);
  ASSERT_EQ(local.size(), 5u) << "the manifest, three outputs and materials";
  EXPECT_NE(local.at("box.obj").find("\nmtllib box.mtl\n"), std::string::npos);
  EXPECT_NE(local.at("box.mtl").find("\nnewmtl Interior\n"), std::string::npos);
  EXPECT_EQ(local.at("box.PLY").substr(0, 4), "ply\n");
  EXPECT_EQ(local.at("box.stl").substr(0, 20), "fracture, algorithm ");
}

TEST(BakeThroughAServer, SaysThatThereIsNone) {
  const TemporaryFolder folder;
  write_meshes(folder, 2);
  const DeafPort deaf;
  const std::string url = "http://127.0.0.1:" + std::to_string(deaf.port);
  const auto bake = [&](const std::string& server) {
    return std::vector<std::string>{"bake",     folder / "in", "-o",         folder / "out",
                                    "--server", server,        "--patience", "0"};
  };
  Process absent(bake(url));
  EXPECT_EQ(absent.wait(), 1);
  EXPECT_NE(absent.error_line().find(url.substr(7) + " does not answer"), std::string::npos);
  EXPECT_TRUE(outputs(folder / "out").empty());
  Process encrypted(bake("https" + url.substr(4)));
  EXPECT_EQ(encrypted.wait(), 1);
  EXPECT_NE(encrypted.error_line().find(url.substr(7) + " does not answer"), std::string::npos);
  auto unbelieving = bake("https" + url.substr(4));
  unbelieving.insert(unbelieving.end(), {"--ca-file", folder / "absent"});
  EXPECT_EQ(Process(unbelieving).wait(), 2);
}

TEST(BakeOfAFolder, SaysOnceWhatIsWrongWithTheCommandLineAndMakesNothing) {
  const TemporaryFolder folder;
  write_meshes(folder, 3);
  Process parameters({"bake", folder / "in", "-o", folder / "out", "--sites", "0"});
  EXPECT_EQ(parameters.wait(), 3);
  EXPECT_NE(parameters.error_line().find("bad-parameter"), std::string::npos);
  EXPECT_NE(parameters.error_line().find("'sites' must be"), std::string::npos);
  EXPECT_EQ(parameters.error_line(), "") << "not again for every mesh";
  for (const std::string absent : {"absent.obj", "absent/"}) {
    Process bake({"bake", folder / absent, "-o", folder / "out.glb"});
    EXPECT_EQ(bake.wait(), 1);
    EXPECT_NE(bake.error_line().find(absent + ": No such file or directory"), std::string::npos);
  }
  Process depfile({"bake", folder / "in", "-o", folder / "out", "--depfile", folder / "out.d"});
  EXPECT_EQ(depfile.wait(), 2);
  EXPECT_TRUE(outputs(folder / "out").empty());
}

TEST(BakeOfAFolder, OneFileGoesWhereItIsToGoWithADepfile) {
  const TemporaryFolder folder;
  write_meshes(folder, 1);
  EXPECT_EQ(Process({"bake", folder / "in/gltf/box.gltf", "-o", folder / "new/box.gltf", "--depfile",
                     folder / "box.d", "--sites", "5"})
                .wait(),
            0);
  const auto figures = nlohmann::json::parse(read_file(folder / "new/box.gltf"));
  EXPECT_EQ(figures.at("asset").at("version"), "2.0");
  EXPECT_EQ(read_file(folder / "box.d"), folder.path + "/new/box.gltf: " + folder.path +
                                             "/in/gltf/box.gltf \\\n  " + folder.path +
                                             "/in/gltf/box\\ data/box.bin\n");
}

TEST(BakeOfAFolder, StopsOnSigtermAndGoesOnLater) {
  const TemporaryFolder folder;
  write_meshes(folder, 24);
  const std::vector<std::string> arguments{
      "bake",    folder / "in", "-o", folder / "out",    "--sites", "300",
      "--quiet", "-j",          "1",  "--allow-refused", "1"};
  Process stopped(arguments);
  require_eventually(kPatience, "two lines of the report",
                     [&] { return lines_in(folder / "out/bake.ndjson") >= 2; });
  stopped.signal(SIGTERM);
  const int code = stopped.wait();
  EXPECT_TRUE(code == 130 || code == 0) << code << ": or it was done already";
  EXPECT_EQ(Process(arguments).wait(), 0);
  EXPECT_EQ(outputs(folder / "out").size(), 24u);
}

}  // namespace
}  // namespace fracture::test
