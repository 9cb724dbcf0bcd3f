// Data of a request after it was answered, for the access log and the metrics.
#pragma once

#include <cstdint>
#include <string>

namespace fracture::ops {

struct RequestRecord {
  bool admin = false;  ///< from the admin listener
  std::string id;
  std::string trace_id, parent_id;  ///< from a well-formed traceparent, else empty
  std::string client;               ///< name of the token's holder; empty without tokens
  std::string address;              ///< of the peer
  std::string method;
  std::string path;        ///< decoded; may contain any byte
  std::string route;       ///< as in the interface document: "/fractures/{id}"; empty if unknown
  int status = 0;          ///< 0: the client left before the request was complete
  bool delivered = false;  ///< the whole answer was passed to the socket
  std::uint64_t bytes_in = 0, bytes_out = 0;  ///< of the bodies, as sent
  double milliseconds = 0;                    ///< from the complete header to the last byte of the answer
  double queue_milliseconds = -1;             ///< wait for a computing thread; -1: did not wait
  std::string cache;                          ///< Cache-Status of the answer
  std::string mesh;                           ///< first 16 hex digits of the mesh's digest
};

}  // namespace fracture::ops
