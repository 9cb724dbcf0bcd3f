#include "client/protocol/protocol.hpp"

namespace fracture::protocol {

const char* name(Failure failure) {
  switch (failure) {
    case Failure::kNone:
      return "none";
    case Failure::kServerAbsent:
      return "server-absent";
    case Failure::kTimedOut:
      return "timed-out";
    case Failure::kOverloaded:
      return "overloaded";
    case Failure::kDamaged:
      return "damaged";
    case Failure::kTooLarge:
      return "too-large";
    case Failure::kRefused:
      return "refused";
    case Failure::kCancelled:
      return "cancelled";
  }
  return "";
}

const char* name(ServerState state) {
  switch (state) {
    case ServerState::kUnknown:
      return "unknown";
    case ServerState::kReachable:
      return "reachable";
    case ServerState::kOverloaded:
      return "overloaded";
    case ServerState::kAbsent:
      return "absent";
  }
  return "";
}

}  // namespace fracture::protocol
