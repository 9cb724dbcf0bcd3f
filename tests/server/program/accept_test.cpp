// The representations of a result from the real program, chosen by Accept: a GLB, a single JSON document, or
// the report.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/gltf/glb_file.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"

namespace fracture::test {
namespace {

const std::string kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

Reply fractured(const ServeProcess& server, const std::string& accept) {
  return ask(server.port, "POST", "/fracture?sites=7&seed=3", "Content-Type: model/obj\r\n" + accept,
             kTetrahedron);
}

/// Returns extras.fracture of the root node.
nlohmann::json root_figures(const nlohmann::json& document) {
  const std::size_t scene = document.at("scene");
  const std::size_t root = document.at("scenes").at(scene).at("nodes").at(0);
  return document.at("nodes").at(root).at("extras").at("fracture");
}

nlohmann::json document_of(const Reply& glb) {
  return Glb(std::vector<std::uint8_t>(glb.body.begin(), glb.body.end())).document;
}

TEST(Accept, GlbIsTheDefaultAndWhatWildcardsMean) {
  ServeProcess server;
  const Reply plain = fractured(server, "");
  ASSERT_EQ(plain.status, 200) << plain.body;
  EXPECT_EQ(plain.header("content-type"), "model/gltf-binary");
  for (const char* accept : {"model/gltf-binary", "*/*", "model/*", "text/html, */*;q=0.1"}) {
    const Reply reply = fractured(server, "Accept: " + std::string(accept) + "\r\n");
    EXPECT_EQ(reply.status, 200) << accept;
    EXPECT_EQ(reply.header("content-type"), "model/gltf-binary") << accept;
    EXPECT_EQ(reply.body, plain.body) << accept;
  }
}

TEST(Accept, GltfJsonIsTheSameAssetAsOneText) {
  ServeProcess server;
  const nlohmann::json glb = document_of(fractured(server, ""));
  for (const char* accept : {"model/gltf+json", "model/gltf-binary;q=0.5, model/gltf+json"}) {
    const Reply reply = fractured(server, "Accept: " + std::string(accept) + "\r\n");
    ASSERT_EQ(reply.status, 200) << reply.body;
    EXPECT_EQ(reply.header("content-type"), "model/gltf+json");
    nlohmann::json gltf = reply.json();
    ASSERT_TRUE(gltf.is_object());
    const std::string uri = gltf.at("buffers").at(0).at("uri");
    EXPECT_EQ(uri.rfind("data:application/octet-stream;base64,", 0), 0u) << uri.substr(0, 60);
    EXPECT_EQ(root_figures(gltf), root_figures(glb));
    gltf.at("buffers").at(0).erase("uri");
    EXPECT_EQ(gltf, glb);  // only the place of the buffer differs
  }
}

TEST(Accept, JsonIsTheFiguresThatStandInTheGlb) {
  ServeProcess server;
  const Reply reply = fractured(server, "Accept: application/json\r\n");
  ASSERT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(reply.header("content-type"), "application/json");
  const nlohmann::json figures = reply.json(), glb = root_figures(document_of(fractured(server, "")));
  EXPECT_EQ(figures.at("certificate").at("fragments"), 7);
  EXPECT_EQ(figures, glb);
}

TEST(Accept, WhatIsNotOfferedIs406AndNamesWhatIs) {
  ServeProcess server;
  for (const char* accept :
       {"image/png", "text/html", "model/obj", "model/gltf-binary;q=0", "application/xml, image/*"}) {
    const Reply reply = fractured(server, "Accept: " + std::string(accept) + "\r\n");
    EXPECT_EQ(reply.status, 406) << accept;
    EXPECT_EQ(reply.problem(), "not-acceptable") << accept;
    for (const char* offer : {"model/gltf-binary", "model/gltf+json", "application/json"})
      EXPECT_NE(reply.body.find(offer), std::string::npos) << accept;
  }
}

}  // namespace
}  // namespace fracture::test
