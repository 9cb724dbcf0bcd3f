// A service with the real engine, a box to hit, and functions that read its answers.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "server/service/service.hpp"
#include "tests/server/support/engine_in_process.hpp"
#include "tests/server/support/figures_of.hpp"

namespace fracture::test {

using nlohmann::json;

inline std::span<const std::byte> bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// A closed box of 2 x 1 x 1 m, each side divided into n x n squares, as OBJ text.
inline std::string box_obj(int n) {
  std::string text;
  int vertices = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int end = 0; end < 2; ++end)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          for (const auto& [a, b] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}) {
            double p[3];
            p[axis] = end;
            p[(axis + 1) % 3] = static_cast<double>(a) / n;
            p[(axis + 2) % 3] = static_cast<double>(b) / n;
            text += "v " + std::to_string(2 * p[0]) + " " + std::to_string(p[1]) + " " +
                    std::to_string(p[2]) + "\n";
          }
          vertices += 4;
          const std::string a = std::to_string(vertices - 3), b = std::to_string(vertices - 2),
                            c = std::to_string(vertices - 1), d = std::to_string(vertices);
          text += end == 1 ? "f " + a + " " + b + " " + c + " " + d + "\n"
                           : "f " + d + " " + c + " " + b + " " + a + "\n";
        }
  return text;
}

inline json document_of(const FractureResult& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.file.data() + 12, 4);
  return json::parse(glb.file.begin() + 20, glb.file.begin() + 20 + length);
}

inline std::set<std::uint64_t> fragment_ids(const FractureResult& glb) {
  std::set<std::uint64_t> ids;
  const json document = document_of(glb);
  for (const json& node : document.at("nodes"))
    if (const json::json_pointer id("/extras/fracture/id"); node.contains(id))
      ids.insert(node.at(id).get<std::uint64_t>());
  return ids;
}

inline std::vector<std::uint64_t> ids(const json& delta, const char* name) {
  return delta.at(name).get<std::vector<std::uint64_t>>();
}

struct HitsTest : testing::Test {
  const std::string mesh = box_obj(6), other = box_obj(5);
  ServiceConfig config;
  FractureService service{config, test::engine_in_process()};

  static Expected<FractureAnswer> ask(FractureService& service, const std::string& mesh,
                                      const json& parameters) {
    std::vector<RawParameter> given;
    for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
    Expected<RequestParameters> parsed = service.parse(given);
    if (!parsed) return tl::unexpected<Error>(parsed.error());
    return service.fracture({bytes(mesh), MeshFormat::kObj, *parsed}, {});
  }
  FractureAnswer ask(const json& parameters) {
    auto answer = ask(service, mesh, parameters);
    if (!answer) throw std::runtime_error(answer.error().detail);
    return *answer;
  }
  static std::string address(const FractureAnswer& answer) {
    return "/fractures/sha256:" + answer.result->key;
  }
  Error refused(const json& parameters) {
    auto answer = ask(service, mesh, parameters);
    if (answer) throw std::runtime_error("was not refused: " + parameters.dump());
    return answer.error();
  }
};

}  // namespace fracture::test
