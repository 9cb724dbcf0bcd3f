// Parts of Boost.Asio and Boost.Beast that a server needs in addition to those of a client.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/defer.hpp>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/strand.hpp>

#include "common/exchange/asio.hpp"

namespace fracture::http {

namespace asio = protocol::asio;
namespace beast = protocol::beast;
using error_code = boost::system::error_code;
using protocol::tcp;

}  // namespace fracture::http
