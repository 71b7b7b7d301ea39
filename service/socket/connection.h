// One client on the socket: reads lines, answers them in order (a waiting method does not hold
// up the next line), and streams the events it subscribed to. All members run on the server's
// loop.
#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "service/methods/method.h"
#include "service/socket/asio.h"
#include "service/socket/outbox.h"

namespace sixdial::service {

/// What a connection needs of the server around it.
struct ConnectionHost {
  Service& service;
  asio::thread_pool& workers;
  asio::thread_pool& file_workers;
  asio::thread_pool& reading_workers;
  asio::thread_pool& long_workers;
  asio::steady_timer& changed;  // cancelled whenever a waiter should look again
  std::chrono::milliseconds slow_client{10'000};
  std::function<void(class Connection&)> ended;
};

class Connection final : public EventSink, public std::enable_shared_from_this<Connection> {
 public:
  Connection(LocalSocket socket, Caller caller, ConnectionHost& host);

  void start();
  void deliver(const EventPtr& event);
  /// Sends what is queued, then closes.
  void finish();
  void close();

  Json subscribe(std::vector<std::string> topics, std::optional<std::uint64_t> since) override;

 private:
  asio::awaitable<void> read_lines();
  asio::awaitable<void> take_line(std::string line);
  asio::awaitable<void> answer_line(Json json);
  asio::awaitable<Json> answer_one(Json json);
  asio::awaitable<Json> run(const RpcMethod& method, Json params);
  asio::awaitable<void> write_lines();
  asio::awaitable<void> watch_for_the_end();
  void send_error(const Json& id, const std::exception_ptr& thrown);
  void send_reply(const Json& reply);
  void wake();

  LocalSocket socket_;
  const Caller caller_;
  ConnectionHost& host_;
  Outbox outbox_;
  asio::steady_timer wake_;      // cancelled when there is something to write or to end
  asio::steady_timer drained_;   // cancelled after each written line and each ended request
  asio::steady_timer deadline_;  // of the line being written
  std::stop_source gone_;        // nobody reads the answer of a long method any more
  std::uint64_t writes_ = 0;
  int waiting_requests_ = 0;
  bool subscribed_ = false;
  std::vector<std::string> topics_;
  std::uint64_t delivered_seq_ = 0;
  bool finishing_ = false;
};

}  // namespace sixdial::service
