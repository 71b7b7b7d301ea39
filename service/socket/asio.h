// Boost.Asio as this folder uses it. 1.74's awaitable.hpp needs <utility> before it (g++ 12).
#pragma once

#include <utility>
// after <utility>
#include <boost/asio.hpp>

namespace sixdial::service {

namespace asio = boost::asio;
using LocalSocket = asio::local::stream_protocol::socket;

}  // namespace sixdial::service
