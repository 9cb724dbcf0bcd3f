#include "server/bake/baker.hpp"

namespace fracture::bake {
namespace {

BakeFailure::Kind kind_of(ErrorCode code) {
  using enum BakeFailure::Kind;
  switch (code) {
    case ErrorCode::kCancelled:
      return kCancelled;
    case ErrorCode::kUnsound:
      return kUnsound;
    case ErrorCode::kInternal:
    case ErrorCode::kOutOfMemory:
      return kBroken;
    default:
      return kRefused;
  }
}

}  // namespace

BakeFailure::BakeFailure(const Error& error)
    : kind(kind_of(error.code)),
      problem{{"type", std::string("/problems/") + slug(error.code)},
              {"title", title(error.code)},
              {"detail", error.detail}} {
  if (!error.pointer.empty()) problem["parameter"] = error.pointer;
  if (const auto errors = error.extra->find("errors"); errors != error.extra->end() && errors->size() > 1)
    problem["errors"] = *errors;
  if (kind == Kind::kUnsound && !error.extra->empty()) certificate = *error.extra;
}

std::string BakeFailure::words() const {
  const std::string type = problem.value("type", "");
  const std::string name = type.substr(type.rfind('/') + 1);
  return (name.empty() ? name : name + ": ") + problem.value("detail", "");
}

std::string BakeFailure::all_words() const {
  const std::string first = problem.value("title", "");
  if (first.empty()) return words();
  const std::string type = problem.value("type", "");
  std::string text = type.substr(type.rfind('/') + 1) + ": " + first + "\n  " + problem.value("detail", "");
  if (const auto errors = problem.find("errors"); errors != problem.end())
    for (std::size_t k = 1; k < errors->size(); ++k) text += "\n  " + (*errors)[k].value("detail", "");
  return text;
}

}  // namespace fracture::bake
