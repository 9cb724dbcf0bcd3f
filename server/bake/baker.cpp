#include "server/bake/baker.hpp"

namespace fracture::bake {

BakeFailure::BakeFailure(const Error& error)
    : kind(error.code == ErrorCode::kCancelled  ? Kind::kCancelled
           : error.code == ErrorCode::kInternal ? Kind::kBroken
                                                : Kind::kRefused),
      problem{{"type", std::string("/problems/") + slug(error.code)},
              {"title", title(error.code)},
              {"detail", error.detail}} {
  if (!error.pointer.empty()) problem["parameter"] = error.pointer;
}

std::string BakeFailure::words() const {
  const std::string type = problem.value("type", "");
  const std::string name = type.substr(type.rfind('/') + 1);
  return (name.empty() ? name : name + ": ") + problem.value("detail", "");
}

}  // namespace fracture::bake
