#include "service/live/live_page.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <thread>

#include "service/error.h"
#include "service/live/live_assets.h"
#include "service/socket/asio.h"
#include "service/socket/request.h"
#include "session/csv.h"
// after service/asio.h
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace sixdial::service {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::use_awaitable;
using asio::ip::tcp;
using Question = http::request<http::empty_body>;
using Reply = http::response<http::string_body>;
using WebSocket = websocket::stream<beast::tcp_stream>;

constexpr auto kPatience = std::chrono::seconds(30);  // with a slow browser
constexpr int kMostVisitors = 32;

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

/// In a time that does not tell how much of it is right.
bool same_secret(std::string_view given, std::string_view wanted) {
  unsigned difference = given.size() == wanted.size() ? 0U : 1U;
  for (std::size_t i = 0; i < given.size(); ++i) {
    difference |= static_cast<unsigned>(given[i] ^ wanted[i % wanted.size()]);
  }
  return difference == 0;
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      plain += text[i];
      continue;
    }
    const std::string digits(text.substr(i + 1, 2));
    char* end = nullptr;
    const long byte = std::strtol(digits.c_str(), &end, 16);
    if (digits.size() != 2 || end != digits.c_str() + 2) return std::nullopt;
    plain += static_cast<char>(byte);
    i += 2;
  }
  return plain;
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char letter : text) {
    switch (letter) {
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      default:
        safe += letter;
    }
  }
  return safe;
}

Reply answer(
    const Question& question, http::status status, std::string_view type, std::string body) {
  Reply reply(status, question.version());
  reply.set(http::field::content_type, beast::string_view(type.data(), type.size()));
  reply.set(http::field::cache_control, "no-store");
  reply.set(http::field::x_frame_options, "DENY");
  reply.set("X-Content-Type-Options", "nosniff");
  reply.set("Referrer-Policy", "no-referrer");  // the token is in the address
  reply.set("Cross-Origin-Resource-Policy", "same-origin");
  reply.keep_alive(question.keep_alive());
  reply.body() = std::move(body);
  reply.prepare_payload();
  return reply;
}

/// A refusal is a page for people.
Reply refusal(
    const Question& question, http::status status, std::string_view what,
    std::string_view advice) {
  return answer(
      question, status, "text/html; charset=utf-8",
      fmt::format(
          "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Sixdial</title>"
          "<body style=\"font:20px system-ui,sans-serif;max-width:40em;margin:3em auto\">"
          "<h1>{}</h1><p>{}</p></body></html>\n",
          escaped(what), escaped(advice)));
}

asio::awaitable<Json> ask(
    LocalSocket& service, std::string_view method, const std::string& session,
    const std::filesystem::path& path) {
  const Json params{{"session", session}, {"path", path.string()}};
  const std::string line =
      to_line({{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}, {"params", params}}) + '\n';
  co_await asio::async_write(service, asio::buffer(line), use_awaitable);
  std::string reply;
  co_await asio::async_read_until(
      service, asio::dynamic_buffer(reply, kMaxLineBytes), '\n', use_awaitable);
  co_return Json::parse(reply);
}

asio::awaitable<LocalSocket> connect_to_service(const std::filesystem::path& path) {
  LocalSocket socket(co_await asio::this_coro::executor);
  co_await socket.async_connect(
      asio::local::stream_protocol::endpoint(path.string()), use_awaitable);
  co_return socket;
}

}  // namespace

std::string new_live_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw Error(ErrorCode::kInternal, "the system gives no random bytes for the page's token");
  }
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

class LivePage::Site {
 public:
  explicit Site(LivePageOptions options)
      : options_(std::move(options)), token_(options_.token), acceptor_(loop_) {
    if (token_.empty()) token_ = new_live_token();
    boost::system::error_code trouble;
    const tcp::endpoint here(asio::ip::address_v4::loopback(), options_.port);
    acceptor_.open(here.protocol());
    acceptor_.set_option(asio::socket_base::reuse_address(true));
    ::fcntl(acceptor_.native_handle(), F_SETFD, FD_CLOEXEC);
    acceptor_.bind(here, trouble);
    if (!trouble) acceptor_.listen(asio::socket_base::max_listen_connections, trouble);
    if (trouble) {
      throw Error(
          ErrorCode::kFile,
          fmt::format(
              "the live page cannot listen on 127.0.0.1:{}: {}", options_.port,
              trouble.message()),
          {{"port", options_.port}},
          "Choose another port: --live PORT, or --live 0 for any free one.");
    }
    port_ = acceptor_.local_endpoint().port();
    std::string made = (std::filesystem::temp_directory_path() / "sixdial-live-").string();
    made.append(6, 'X');  // mkdtemp's
    if (::mkdtemp(made.data()) == nullptr) {
      throw Error(ErrorCode::kFile, "no temporary folder for reports", {{"file", made}});
    }
    reports_ = made;
    asio::co_spawn(loop_, welcome(), asio::detached);
    thread_ = std::thread([this] { loop_.run(); });
  }

  ~Site() {
    loop_.stop();
    thread_.join();
    std::error_code ignored;
    std::filesystem::remove_all(reports_, ignored);
  }
  Site(const Site&) = delete;
  Site& operator=(const Site&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] const std::string& token() const { return token_; }

 private:
  asio::awaitable<void> welcome() {
    for (;;) {
      boost::system::error_code trouble;
      tcp::socket socket =
          co_await acceptor_.async_accept(asio::redirect_error(use_awaitable, trouble));
      if (trouble) {
        asio::steady_timer pause(loop_, std::chrono::milliseconds(100));
        co_await pause.async_wait(use_awaitable);
        continue;
      }
      if (visitors_ >= kMostVisitors) continue;  // closes it
      ++visitors_;
      asio::co_spawn(
          loop_, talk(beast::tcp_stream(std::move(socket))),
          [this](const std::exception_ptr& thrown) {
            --visitors_;
            if (!thrown) return;
            try {
              std::rethrow_exception(thrown);
            } catch (const std::exception& trouble_there) {
              spdlog::debug("live page: {}", trouble_there.what());
            }
          });
    }
  }

  asio::awaitable<void> talk(beast::tcp_stream stream) {
    beast::flat_buffer buffer;
    for (;;) {
      stream.expires_after(kPatience);
      Question question;
      boost::system::error_code trouble;
      co_await http::async_read(
          stream, buffer, question, asio::redirect_error(use_awaitable, trouble));
      if (trouble) co_return;
      std::optional<Reply> refused = refuse(question);
      const std::string place = refused ? std::string() : place_of(question);
      if (!refused && websocket::is_upgrade(question)) {
        if (place == "socket") {
          co_await carry_lines(std::move(stream), std::move(question));
          co_return;
        }
        refused = refusal(question, http::status::not_found, "Nothing is here", "");
      }
      // Spelled out: g++ 12 destroys what `condition ? a : co_await b` makes twice.
      Reply reply;
      if (refused) {
        reply = std::move(*refused);
      } else {
        reply = co_await serve(question, place);
      }
      stream.expires_after(kPatience);
      co_await http::async_write(stream, reply, use_awaitable);
      if (!reply.keep_alive()) co_return;
    }
  }

  /// What of the request is not as this page's own requests are.
  std::optional<Reply> refuse(const Question& question) const {
    const auto ours = [this](std::string_view host) {
      return host == fmt::format("127.0.0.1:{}", port_) ||
             host == fmt::format("localhost:{}", port_);
    };
    const auto no = [&](std::string_view what, std::string_view advice) {
      spdlog::warn("live page: refused: {}", what);
      return refusal(question, http::status::forbidden, what, advice);
    };
    if (!ours(view(question[http::field::host]))) {
      return no(
          "Wrong host name", fmt::format("Open the page as http://127.0.0.1:{}/...", port_));
    }
    const std::string_view origin = view(question[http::field::origin]);
    constexpr std::string_view kScheme = "http://";
    const bool own = origin.starts_with(kScheme) && ours(origin.substr(kScheme.size()));
    const bool asked_for = websocket::is_upgrade(question) || !origin.empty();
    if (asked_for && !own)
      return no("A page of another origin asks", "Open the live page itself.");
    const std::string_view path = view(question.target());
    const std::size_t end = path.find('/', 1);
    const std::string_view token = path.starts_with('/') ? path.substr(1, end - 1) : "";
    if (!same_secret(token, token_)) {
      return no(
          "Wrong token",
          "The address with its token was printed when sixdiald began; each run has its own. "
          "Look there, or start sixdiald --live again.");
    }
    if (question.method() != http::verb::get && question.method() != http::verb::head) {
      return refusal(question, http::status::method_not_allowed, "Only GET is served here", "");
    }
    return std::nullopt;
  }

  /// What stands after the token and its slash, without a query.
  [[nodiscard]] std::string place_of(const Question& question) const {
    std::string_view path = view(question.target()).substr(1 + token_.size());
    path = path.substr(0, path.find('?'));
    return std::string(path.empty() ? "-" : path.substr(1));
  }

  asio::awaitable<Reply> serve(const Question& question, const std::string& place) {
    namespace files = live_assets;
    const auto text = [&](std::string_view type, std::string_view body) {
      Reply reply = answer(
          question, http::status::ok, fmt::format("{}; charset=utf-8", type),
          std::string(body));
      reply.set(
          "Content-Security-Policy",
          fmt::format(
              "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
              "connect-src 'self' ws://127.0.0.1:{0} ws://localhost:{0}; base-uri 'none'; "
              "form-action 'none'; frame-ancestors 'none'",
              port_));
      return reply;
    };
    if (place == "-") {  // /TOKEN: its relative links would miss the token
      Reply reply = refusal(question, http::status::found, "This way", "");
      reply.set(http::field::location, fmt::format("/{}/", token_));
      co_return reply;
    }
    if (place.empty()) co_return text("text/html", files::page());
    if (place == "live.css") co_return text("text/css", files::stylesheet());
    if (place == "live.js") co_return text("text/javascript", files::script());
    if (place == "link.js") co_return text("text/javascript", files::link());
    if (place == "dials.js") co_return text("text/javascript", files::dials());
    if (place == "drawing.js") co_return text("text/javascript", files::drawing());
    constexpr std::string_view kReport = "report/";
    if (place.starts_with(kReport)) {
      co_return co_await report(question, place.substr(kReport.size()));
    }
    co_return refusal(question, http::status::not_found, "Nothing is here", "");
  }

  /// report.write, asked of the service like anybody else, and its page; without a calibration
  /// the page of the diagnosis.
  asio::awaitable<Reply> report(const Question& question, std::string_view encoded_session) {
    const auto session = percent_decoded(encoded_session);
    if (!session) {
      co_return refusal(question, http::status::bad_request, "This is no session's name", "");
    }
    const std::string number = std::to_string(++report_number_);
    const std::filesystem::path folder = reports_ / number;
    std::string what, advice;
    try {
      LocalSocket service = co_await connect_to_service(options_.socket_path);
      std::filesystem::path file = folder / "report.html";
      Json json = co_await ask(service, "report.write", *session, folder);
      if (json.contains("error") &&
          json["error"]["data"]["code"] == error_kind(ErrorCode::kNotFound).code) {
        file = reports_ / (number + ".html");
        const Json page = co_await ask(service, "diagnose.report", *session, file);
        if (page.contains("result")) json = page;
      }
      if (json.contains("result")) {
        Reply page = answer(
            question, http::status::ok, "text/html; charset=utf-8",
            session::read_file(file.string()));
        std::error_code ignored;
        std::filesystem::remove_all(folder, ignored);
        std::filesystem::remove(file, ignored);
        co_return page;
      }
      what = json["error"]["message"].get<std::string>();
      advice = json["error"]["data"]["hint"].get<std::string>();
    } catch (const std::exception& trouble) {
      what = fmt::format("The report could not be made: {}", trouble.what());
    }
    co_return refusal(question, http::status::conflict, what, advice);
  }

  /// A message is a line, a line is a message, until either side ends.
  asio::awaitable<void> carry_lines(beast::tcp_stream stream, Question question) {
    stream.expires_never();
    const auto socket = std::make_shared<WebSocket>(std::move(stream));
    socket->set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket->read_message_max(kMaxRequestBytes);
    co_await socket->async_accept(question, use_awaitable);
    socket->text(true);
    boost::system::error_code ignored;
    std::shared_ptr<LocalSocket> service;
    try {
      service =
          std::make_shared<LocalSocket>(co_await connect_to_service(options_.socket_path));
    } catch (const std::exception& trouble) {
      spdlog::warn("live page: the service does not answer: {}", trouble.what());
    }
    if (!service) {
      const websocket::close_reason why(
          websocket::close_code::try_again_later, "the service does not answer");
      co_await socket->async_close(why, asio::redirect_error(use_awaitable, ignored));
      co_return;
    }
    asio::co_spawn(loop_, lines_to_page(socket, service), asio::detached);
    beast::flat_buffer message;
    for (;;) {
      boost::system::error_code trouble;
      co_await socket->async_read(message, asio::redirect_error(use_awaitable, trouble));
      if (trouble) break;
      std::string line = beast::buffers_to_string(message.data());
      message.consume(message.size());
      std::ranges::replace(line, '\n', ' ');  // white space to JSON
      line += '\n';
      co_await asio::async_write(
          *service, asio::buffer(line), asio::redirect_error(use_awaitable, trouble));
      if (trouble) break;
    }
    service->close(ignored);
  }

  static asio::awaitable<void> lines_to_page(
      std::shared_ptr<WebSocket> socket, std::shared_ptr<LocalSocket> service) {
    std::string lines;
    boost::system::error_code trouble;
    for (;;) {
      const std::size_t size = co_await asio::async_read_until(
          *service, asio::dynamic_buffer(lines, 2 * kMaxLineBytes), '\n',
          asio::redirect_error(use_awaitable, trouble));
      if (trouble) break;
      co_await socket->async_write(
          asio::buffer(lines.data(), size - 1), asio::redirect_error(use_awaitable, trouble));
      if (trouble) break;
      lines.erase(0, size);
    }
    const websocket::close_reason why(
        websocket::close_code::going_away, "the service has ended the connection");
    co_await socket->async_close(why, asio::redirect_error(use_awaitable, trouble));
  }

  const LivePageOptions options_;
  std::string token_;
  asio::io_context loop_{1};
  tcp::acceptor acceptor_;
  std::uint16_t port_ = 0;
  std::filesystem::path reports_;
  int report_number_ = 0;
  int visitors_ = 0;
  std::thread thread_;
};

LivePage::LivePage(LivePageOptions options)
    : site_(std::make_unique<Site>(std::move(options))) {}
LivePage::~LivePage() = default;

std::uint16_t LivePage::port() const { return site_->port(); }

std::string LivePage::url() const {
  return fmt::format("http://127.0.0.1:{}/{}/", site_->port(), site_->token());
}

}  // namespace sixdial::service
