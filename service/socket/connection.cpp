#include "service/socket/connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/long_work.h"
#include "service/service.h"
#include "service/socket/request.h"

namespace sixdial::service {
namespace {

constexpr std::size_t kReadChunk = std::size_t{64} * 1024;
constexpr std::size_t kMaxQueuedAnswerBytes = std::size_t{1} << 20;
constexpr int kMaxWaitingRequests = 32;

using asio::use_awaitable;

/// Completes when the timer is cancelled or over; a timer never throws here.
asio::awaitable<void> until_cancelled(asio::steady_timer& timer) {
  boost::system::error_code ignored;
  co_await timer.async_wait(asio::redirect_error(use_awaitable, ignored));
}

bool asks_to_wait(const Json& request) {
  if (request.is_array()) return std::ranges::any_of(request, asks_to_wait);
  if (!request.is_object()) return false;
  const auto method = request.find("method");
  if (method == request.end() || !method->is_string()) return false;
  const auto rows = all_methods();
  const auto found =
      std::ranges::find(rows, method->get_ref<const std::string&>(), &RpcMethod::name);
  return found != rows.end() && (*found)->wait != nullptr;
}

/// What may take minutes; ends within a moment once nobody waits for it.
Json run_long(const RpcMethod& method, const Call& call, const std::stop_token& gone) {
  const geometry::LongWork work(gone);
  try {
    geometry::check_end();  // it may have waited for a worker
    return method.run(call);
  } catch (const geometry::WorkEnded&) {
    throw Error(ErrorCode::kShuttingDown, "it was ended before there was an answer");
  }
}

}  // namespace

Connection::Connection(LocalSocket socket, Caller caller, ConnectionHost& host)
    : socket_(std::move(socket)),
      caller_(std::move(caller)),
      host_(host),
      wake_(socket_.get_executor()),
      drained_(socket_.get_executor()),
      deadline_(socket_.get_executor()) {
  wake_.expires_at(asio::steady_timer::time_point::max());
  drained_.expires_at(asio::steady_timer::time_point::max());
}

void Connection::start() {
  const auto loop = socket_.get_executor();
  asio::co_spawn(
      loop, [self = shared_from_this()] { return self->read_lines(); }, asio::detached);
  asio::co_spawn(
      loop, [self = shared_from_this()] { return self->write_lines(); }, asio::detached);
  asio::co_spawn(
      loop, [self = shared_from_this()] { return self->watch_for_the_end(); }, asio::detached);
}

/// A client that has hung up, while its request is at work: no line is read then that would
/// tell. Requests that are no long work go on to their end.
asio::awaitable<void> Connection::watch_for_the_end() {
  boost::system::error_code trouble;
  co_await socket_.async_wait(
      LocalSocket::wait_error, asio::redirect_error(use_awaitable, trouble));
  gone_.request_stop();
}

void Connection::wake() {
  wake_.cancel();
  drained_.cancel();
}

void Connection::deliver(const EventPtr& event) {
  if (!subscribed_ || finishing_ || event->seq <= delivered_seq_) return;
  if (!topics_.empty() && std::ranges::find(topics_, event->topic) == topics_.end()) return;
  delivered_seq_ = event->seq;
  outbox_.push_event(event);
  wake_.cancel();
}

void Connection::finish() {
  finishing_ = true;
  gone_.request_stop();
  wake();
}

void Connection::close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
  deadline_.cancel();
  wake();
  host_.changed.cancel();  // its waiting requests end, too
}

Json Connection::subscribe(
    std::vector<std::string> topics, std::optional<std::uint64_t> since) {
  const EventHub& events = host_.service.events();
  outbox_.drop_events();
  topics_ = std::move(topics);
  subscribed_ = true;
  const std::uint64_t last = events.last_seq();
  Replay replay = events.since(since.value_or(last), topics_);
  delivered_seq_ = replay.last_seq;
  if (replay.lost_from != 0) {
    outbox_.push_gap(replay.lost_from, replay.lost_to, replay.lost_to - replay.lost_from + 1);
  }
  const std::size_t replayed = replay.events.size();
  for (EventPtr& event : replay.events) outbox_.push_event(std::move(event));
  wake_.cancel();
  return {
      {"epoch", events.epoch()},
      {"last_seq", replay.last_seq},
      {"replayed", replayed},
      {"lost", replay.lost_from == 0 ? 0 : replay.lost_to - replay.lost_from + 1}};
}

void Connection::send_reply(const Json& reply) {
  outbox_.push_answer(to_reply_line(reply));
  wake_.cancel();
}

void Connection::send_error(const Json& id, const std::exception_ptr& thrown) {
  send_reply(error_reply(id, to_error_object(thrown)));
}

asio::awaitable<void> Connection::read_lines() {
  std::string partial;
  std::string chunk(kReadChunk, '\0');
  bool discarding = false;  // the rest of a line that was too long
  while (socket_.is_open() && !finishing_) {
    boost::system::error_code trouble;
    const std::size_t size = co_await socket_.async_read_some(
        asio::buffer(chunk), asio::redirect_error(use_awaitable, trouble));
    if (trouble) break;
    std::string_view rest(chunk.data(), size);
    while (!rest.empty()) {
      const std::size_t end = rest.find('\n');
      const std::string_view piece = rest.substr(0, end);
      rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
      if (!discarding) partial += piece;
      if (partial.size() > kMaxRequestBytes) {
        discarding = true;
        partial.clear();
        partial.shrink_to_fit();
        send_error(
            nullptr, std::make_exception_ptr(Error(
                         ErrorCode::kLineTooLong,
                         fmt::format("a request line may have {} bytes", kMaxRequestBytes))));
      }
      if (end == std::string_view::npos) continue;
      if (!std::exchange(discarding, false)) co_await take_line(std::exchange(partial, {}));
      partial.clear();
    }
    while (outbox_.answer_bytes() > kMaxQueuedAnswerBytes && socket_.is_open()) {
      co_await until_cancelled(drained_);
    }
  }
  if (!partial.empty() && socket_.is_open()) co_await take_line(std::move(partial));
  while (waiting_requests_ > 0 && socket_.is_open() && !finishing_) {
    co_await until_cancelled(drained_);
  }
  finish();
}

asio::awaitable<void> Connection::take_line(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  if (std::ranges::all_of(line, [](char c) { return c == ' ' || c == '\t'; })) co_return;
  Json json;
  try {
    json = parse_line(line);
    if (json.is_array() && json.empty()) {
      throw Error(ErrorCode::kInvalidRequest, "a batch must hold at least one request");
    }
    if (json.is_array() && json.size() > kMaxBatch) {
      throw Error(
          ErrorCode::kInvalidRequest, fmt::format("a batch may hold {} requests", kMaxBatch));
    }
    if (asks_to_wait(json) && waiting_requests_ >= kMaxWaitingRequests) {
      throw Error(
          ErrorCode::kTooManyRequests,
          fmt::format("{} requests of this connection are waiting", waiting_requests_));
    }
  } catch (...) {
    send_error(id_of(json), std::current_exception());
    co_return;
  }
  if (!asks_to_wait(json)) {
    co_await answer_line(std::move(json));
    co_return;
  }
  ++waiting_requests_;
  asio::co_spawn(
      socket_.get_executor(),
      [self = shared_from_this(), json = std::move(json)]() -> asio::awaitable<void> {
        co_await self->answer_line(json);
        --self->waiting_requests_;
        self->drained_.cancel();
      },
      asio::detached);
}

asio::awaitable<void> Connection::answer_line(Json json) {
  if (!json.is_array()) {
    const Json reply = co_await answer_one(std::move(json));
    if (!reply.is_null()) send_reply(reply);
    co_return;
  }
  // The answers of a batch share one line: those that no longer fit are said to be too large.
  std::string line = "[";
  constexpr std::size_t kRoomForErrors = 400;
  std::size_t left = json.size();
  for (Json& each : json) {
    const Json reply = co_await answer_one(std::move(each));
    --left;
    if (reply.is_null()) continue;
    std::string text = to_reply_line(reply);
    if (line.size() + text.size() + (left + 1) * kRoomForErrors >= kMaxLineBytes) {
      text = to_line(error_reply(
          id_of(reply),
          to_error_object(std::make_exception_ptr(Error(
              ErrorCode::kResultTooLarge, "the answers of this batch do not fit into one line",
              {}, "Ask in several lines.")))));
    }
    if (line.size() > 1) line += ',';
    line += text;
  }
  if (line.size() == 1) co_return;  // only notifications
  line += ']';
  outbox_.push_answer(std::move(line));
  wake_.cancel();
}

asio::awaitable<Json> Connection::answer_one(Json json) {
  std::exception_ptr thrown;
  Json id = id_of(json);
  bool notification = false;
  Json result;
  try {
    Request request = parse_request(json);
    notification = request.notification;
    const RpcMethod& method = find_method(request.method);
    check_params(method, request.params);
    result = co_await run(method, std::move(request.params));
  } catch (...) {
    thrown = std::current_exception();
  }
  if (notification) co_return Json(nullptr);
  if (thrown) co_return error_reply(id, to_error_object(thrown));
  co_return result_reply(id, std::move(result));
}

asio::awaitable<Json> Connection::run(const RpcMethod& method, Json params) {
  Service& service = host_.service;
  if (service.stopping()) throw Error(ErrorCode::kShuttingDown, "the service is going down");
  const Call call{service, params, caller_, this};
  if (method.wait != nullptr) {
    const Wait wait = method.wait(call);
    const auto end = std::chrono::steady_clock::now() + wait.timeout;
    asio::steady_timer over(socket_.get_executor(), end);
    over.async_wait([&host = host_](const boost::system::error_code& error) {
      if (!error) host.changed.cancel();
    });
    // Going down makes every wait ready: jobs and the collection are ended first.
    while (!wait.ready() && socket_.is_open() && std::chrono::steady_clock::now() < end) {
      co_await until_cancelled(host_.changed);
    }
    co_return wait.answer();
  }
  if (method.runs_on == RunsOn::kLoop) co_return method.run(call);
  if (method.runs_on == RunsOn::kLong || method.runs_on == RunsOn::kReading) {
    // By reference: g++ 12 destroys captured objects of a co_await's argument twice.
    const std::stop_token gone = gone_.get_token();
    co_return co_await asio::co_spawn(
        method.runs_on == RunsOn::kLong ? host_.long_workers : host_.reading_workers,
        [&method, &call, &gone]() -> asio::awaitable<Json> {
          co_return run_long(method, call, gone);
        },
        use_awaitable);
  }
  co_return co_await asio::co_spawn(
      method.runs_on == RunsOn::kFiles ? host_.file_workers : host_.workers,
      [&method, &call]() -> asio::awaitable<Json> { co_return method.run(call); },
      use_awaitable);
}

asio::awaitable<void> Connection::write_lines() {
  while (socket_.is_open()) {
    const std::optional<std::string> line = outbox_.pop();
    if (!line) {
      if (finishing_) break;
      co_await until_cancelled(wake_);
      continue;
    }
    const std::uint64_t this_write = ++writes_;
    deadline_.expires_after(host_.slow_client);
    deadline_.async_wait([weak = weak_from_this(), this_write](const auto& error) {
      const auto self = weak.lock();
      if (!error && self && self->writes_ == this_write) self->close();
    });
    boost::system::error_code trouble;
    co_await asio::async_write(
        socket_, asio::buffer(*line), asio::redirect_error(use_awaitable, trouble));
    ++writes_;
    deadline_.cancel();
    drained_.cancel();
    if (trouble) break;
  }
  close();
  host_.ended(*this);
}

}  // namespace sixdial::service
