// The live page: a web page on the loopback for the person at the rig. HTTP hands out three
// files and reports; a WebSocket carries the lines of the Unix socket, one a message, both
// ways. So the page is a client like any other: same methods, events, limits; nothing is kept
// here.
//
// Who can open http://127.0.0.1:PORT/TOKEN/ is trusted as who runs the service. A page of
// another site is refused by its Origin, a name that was bent to 127.0.0.1 by its Host.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace sixdial::service {

inline constexpr std::uint16_t kDefaultLivePort = 8765;

struct LivePageOptions {
  std::filesystem::path socket_path{};    // of the service
  std::uint16_t port = kDefaultLivePort;  // 0: any free one
  std::string token{};                    // empty: drawn anew
};

/// 32 hexadecimal digits from the system's random source.
[[nodiscard]] std::string new_live_token();

class LivePage {
 public:
  /// Listens and serves from a thread of its own, until destroyed. Throws Error file: the port
  /// is taken, and what to do.
  explicit LivePage(LivePageOptions options);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  /// With the token: to be shown to the operator once.
  [[nodiscard]] std::string url() const;

 private:
  class Site;
  std::unique_ptr<Site> site_;
};

}  // namespace sixdial::service
