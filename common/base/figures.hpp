// Figures for programs that go with an error: a JSON object, which only those look into who include JSON.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

namespace fracture {

/// Never changes; copies share it.
class Figures {
 public:
  Figures() = default;  ///< {}
  explicit Figures(nlohmann::json object);

  const nlohmann::json& operator*() const;
  const nlohmann::json* operator->() const { return &**this; }

 private:
  std::shared_ptr<const nlohmann::json> object_;  // null: {}
};

}  // namespace fracture
