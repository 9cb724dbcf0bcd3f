// How much memory is reserved for a hit: for the changes if the kept answer allows that, otherwise for the
// whole answer.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/bulk.hpp"
#include "server/service/dispatcher.hpp"
#include "server/service/estimate.hpp"
#include "tests/server/support/engine_in_process.hpp"

namespace fracture {
namespace {

using nlohmann::json;

constexpr std::uint64_t kCells = 3000, kBytesOfCells = kCells * (16u << 10);

std::shared_ptr<const std::string> cube() {
  return std::make_shared<const std::string>(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
}

struct HitAdmissionTest : testing::Test {
  FractureService service{ServiceConfig{}, test::engine_in_process()};
  WorkerPool pool{1, 16};
  Dispatcher dispatcher{service, pool, {.max_working_bytes = 1u << 30}};

  FractureRequest request(const json& parameters) {
    std::vector<RawParameter> given;
    for (const auto& [name, value] : parameters.items()) given.push_back({name, value, false});
    const auto text = cube();
    FractureRequest request;
    request.mesh = std::as_bytes(std::span(*text));
    request.format = MeshFormat::kObj;
    request.owner = text;
    request.parameters = service.parse(given).value();
    return request;
  }
  std::string address_of(const json& parameters) {
    return "/fractures/sha256:" + service.fracture(request(parameters), {}).value().result->key;
  }
  /// Returns the memory that is reserved when the computation first reports progress.
  std::uint64_t held_for(const json& parameters) {
    std::atomic<std::uint64_t> held{0};
    Terms terms;
    terms.progress = [&](Stage, double) {
      std::uint64_t nothing = 0;
      held.compare_exchange_strong(nothing, dispatcher.figures().working_bytes);
    };
    bool answered = false;
    EXPECT_FALSE(dispatcher.fracture(request(parameters), terms, [&](const Expected<FractureAnswer>& answer) {
      answered = answer.has_value();
    }));
    dispatcher.wait_idle();
    EXPECT_TRUE(answered) << parameters;
    return held;
  }
  static json hit(const std::string& of, const char* delta) {
    return {{"of", of},
            {"local_point", {1, 0.5, 0.5}},
            {"local_radius", 0.05},
            {"local_sites", 10u},
            {"delta", delta}};
  }
};

TEST_F(HitAdmissionTest, WhatAnswersWithTheChangesIsHeldForTheChanges) {
  const std::string kept = address_of({{"sites", kCells}, {"delta", "stated"}});
  EXPECT_LT(held_for(hit(kept, "only")), kBytesOfCells / 4);
  EXPECT_GE(held_for(hit(kept, "stated")), kBytesOfCells) << "the whole is copied";
  const std::string rough =
      address_of({{"sites", kCells}, {"delta", "stated"}, {"rough_amplitude", 1e-6}, {"rough_frequency", 1}});
  EXPECT_LT(held_for(hit(rough, "only")), kBytesOfCells / 4);
}

TEST_F(HitAdmissionTest, WhatNobodyKeptIsHeldForAsAWhole) {
  EXPECT_GE(held_for(hit(address_of({{"sites", kCells}}), "only")), kBytesOfCells);
}

TEST_F(HitAdmissionTest, LimitsAndARestThatStaysWholeDoNotMatter) {
  const std::string counted =
      address_of({{"sites", kCells}, {"delta", "stated"}, {"max_fragments", 1'000'000}});
  EXPECT_LT(held_for(hit(counted, "only")), kBytesOfCells / 4) << "limits concern the pattern's pieces";
  json whole = hit("", "stated");
  whole.erase("of");
  whole["sites"] = kCells;
  whole["local_rest"] = "whole";
  EXPECT_LT(held_for(hit(address_of(whole), "only")), kBytesOfCells / 4) << "the rest is one piece";
}

TEST_F(HitAdmissionTest, TheAnswerBeforeTheHitsIsHeldForIfItMustBeMade) {
  json whole = hit("", "only");
  whole.erase("of");
  whole["sites"] = kCells;
  whole["local_rest"] = "whole";
  whole["local_new"] = 1;
  EXPECT_GE(held_for(whole), kBytesOfCells) << "the delta compares with the pattern's pieces";
  whole["seed"] = 2;
  address_of({{"sites", kCells}, {"seed", 2}, {"delta", "stated"}});
  EXPECT_LT(held_for(whole), kBytesOfCells / 4) << "they are kept";
}

/// Tetrahedra that touch nothing, in a row.
std::shared_ptr<const std::string> tetrahedra(int count) {
  std::string vertices, faces;
  for (int k = 0; k < count; ++k) {
    const std::string x = std::to_string(2 * k), x1 = std::to_string(2 * k + 1);
    vertices += "v " + x + " 0 0\nv " + x1 + " 0 0\nv " + x + " 1 0\nv " + x + " 0 1\n";
    const auto face = [&](int a, int b, int c) {
      faces += "f " + std::to_string(4 * k + a) + " " + std::to_string(4 * k + b) + " " +
               std::to_string(4 * k + c) + "\n";
    };
    face(1, 3, 2), face(1, 2, 4), face(1, 4, 3), face(2, 3, 4);
  }
  return std::make_shared<const std::string>(vertices + faces);
}

// Admission runs on the io thread. There, an estimate for many hits and parts took a second.
TEST_F(HitAdmissionTest, ManyPairsOfHitsAndPartsAreEstimatedByThePool) {
  FractureRequest asked = request(json{{"local_point", std::vector<std::array<int, 3>>(64, {5, 5, 5})},
                                       {"local_radius", 9999},
                                       {"local_sites", 9u}});
  const auto text = tetrahedra(600);
  asked.mesh = std::as_bytes(std::span(*text));
  asked.owner = text;
  for (std::size_t k = 0; k < asked.parameters.fracture.hits.size(); ++k)
    asked.parameters.fracture.hits[k].point.x += 1e-3 * static_cast<double>(k);
  asked.digest = digest_of(asked).hex();
  std::shared_ptr<const PreparedMesh> mesh;
  ASSERT_FALSE(dispatcher.prepare(asked, {}, [&](auto prepared) { mesh = prepared.value(); }));
  dispatcher.wait_idle();
  ASSERT_TRUE(mesh);
  ASSERT_EQ(mesh->solid.parts.size(), 600u);
  const auto exceeds = [](const auto& work) {
    BulkLimit limit(128u << 10);  // http::kMostInTurn
    limit_bulk(&limit);
    begin_bulk_turn();
    work();
    limit_bulk(nullptr);
    return limit.exceeded > 0;
  };
  EXPECT_TRUE(exceeds([&] { cannot_fit(asked.parameters, mesh->solid, dispatcher.most_bytes()); }))
      << "38,400 pairs";
  std::stop_source gone;
  Terms terms;
  terms.gone = gone.get_token();
  std::atomic<bool> replied{false};
  EXPECT_FALSE(exceeds([&] {
    EXPECT_FALSE(dispatcher.fracture(asked, terms, [&](const Expected<FractureAnswer>&) { replied = true; }));
  }));
  gone.request_stop();
  dispatcher.wait_idle();
  EXPECT_TRUE(replied);
}

}  // namespace
}  // namespace fracture
