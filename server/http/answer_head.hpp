// The head of an answer: the status line and the fields that every answer has.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "server/http/asio.hpp"
#include "server/http/message.hpp"

namespace fracture::http {

using Fields = std::vector<std::pair<std::string, std::string>>;

/// Returns the current time as IMF-fixdate (RFC 9110, section 5.6.7).
std::string http_date();

/// `more`: fields in addition to those of the answer.
template <class Body>
beast::http::response<Body> begin_message(const Response& response, const std::string& id, const Fields& more,
                                          bool keep_alive) {
  beast::http::response<Body> message;
  message.version(11);
  message.result(static_cast<unsigned>(response.status));
  message.set(beast::http::field::server, "fracture-server/" FRACTURE_VERSION);
  if (!response.content_type.empty()) message.set(beast::http::field::content_type, response.content_type);
  message.set(beast::http::field::date, http_date());
  message.set("X-Request-Id", id);
  message.set("X-Content-Type-Options", "nosniff");
  for (const auto& [name, value] : response.headers) message.insert(name, value);
  for (const auto& [name, value] : more) message.insert(name, value);
  message.keep_alive(keep_alive);
  return message;
}

}  // namespace fracture::http
