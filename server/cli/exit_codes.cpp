#include "server/cli/exit_codes.hpp"

#include "server/bake/failure.hpp"

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

int exit_code(ErrorCode code) {
  if (code == ErrorCode::kFileAccess) return kExitSystem;
  switch (bake::outcome_of(code)) {
    case bake::Outcome::kRefused:
      return kExitRefused;
    case bake::Outcome::kFailed:
    case bake::Outcome::kUnsound:
      return kExitInternal;
    case bake::Outcome::kCancelled:
      return kExitInterrupted;
    case bake::Outcome::kUnavailable:
      return kExitSystem;
  }
  return kExitInternal;
}

}  // namespace fracture::cli
