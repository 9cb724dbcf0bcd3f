// Data for programs that accompanies an error: a JSON object. Only code that reads it has to include JSON.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

namespace fracture {

/// Immutable; copies share the object.
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
