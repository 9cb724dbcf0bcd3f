// What is known about a request once it has been answered: one line of the log, and a few counts.
#pragma once

#include <cstdint>
#include <string>

namespace fracture::ops {

struct RequestRecord {
  bool admin = false;  ///< came in on the admin listener
  std::string id;
  std::string trace_id, parent_id;  ///< of a well-formed traceparent, else empty
  std::string client;               ///< holder of the token, empty without tokens
  std::string address;              ///< of the peer
  std::string method;
  std::string path;        ///< decoded; may hold any byte
  std::string route;       ///< as in the interface document: "/fractures/{id}"; empty when there was none
  int status = 0;          ///< 0: the client went away before its request was whole
  bool delivered = false;  ///< the whole answer was handed to the socket
  std::uint64_t bytes_in = 0, bytes_out = 0;  ///< of the bodies, as sent
  double milliseconds = 0;                    ///< from the whole header to the last byte of the answer
  double queue_milliseconds = -1;             ///< waiting for a computing thread; -1: never was
  std::string cache;                          ///< Cache-Status of the answer
  std::string mesh;                           ///< first 16 hex digits of the mesh's digest
};

}  // namespace fracture::ops
