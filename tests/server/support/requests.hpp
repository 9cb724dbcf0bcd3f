// A cube that many tests send, and its header fields.
#pragma once

#include <string>

namespace fracture::test {

/// A unit cube as OBJ.
inline const std::string kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
inline const std::string kObj = "Content-Type: model/obj\r\n", kRespondAsync = "Prefer: respond-async\r\n";
/// The head of a request, up to its framing.
inline const std::string kPostObj = "POST /fracture HTTP/1.1\r\nHost: a\r\n" + kObj;

}  // namespace fracture::test
