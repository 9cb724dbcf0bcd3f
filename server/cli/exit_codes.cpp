#include "server/cli/exit_codes.hpp"

namespace fracture::cli {

int exit_code(const bake::RunFigures& figures, std::size_t allowed) {
  using bake::RunFigures;
  constexpr struct {
    std::size_t RunFigures::*count;
    int code;
  } kWorstFirst[] = {{&RunFigures::unavailable, kExitSystem}, {&RunFigures::cancelled, kExitInterrupted},
                     {&RunFigures::unsound, kExitInternal},   {&RunFigures::failed, kExitInternal},
                     {&RunFigures::unreadable, kExitSystem},  {&RunFigures::unwritable, kExitSystem}};
  for (const auto& [count, code] : kWorstFirst)
    if (figures.*count > 0) return code;
  return figures.refused > allowed ? kExitRefused : kExitDone;
}

int inspect_exit_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::kBadParameter:
    case ErrorCode::kUnknownParameter:
    case ErrorCode::kUnknownFormat:
      return kInspectFailed;
    default:
      return kInspectRefused;
  }
}

}  // namespace fracture::cli
